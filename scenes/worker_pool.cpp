#include "scenes/worker_pool.hpp"

namespace atropos::scenes {

WorkerPool::WorkerPool(int threads) {
    for (int i = 1; i < threads; ++i) workers_.emplace_back([this] { work(); });
}

WorkerPool::~WorkerPool() {
    {
        const std::lock_guard lock(mutex_);
        stop_ = true;
    }
    wake_.notify_all();
    for (std::thread& worker : workers_) worker.join();
}

bool WorkerPool::take_one(std::unique_lock<std::mutex>& lock) {
    if (next_ >= count_) return false;
    const int i = next_++;
    const Call call = call_;
    void* const task = task_;
    lock.unlock();
    call(task, i);
    lock.lock();
    if (++finished_ == count_) done_.notify_all();
    return true;
}

void WorkerPool::run_shared(int count, Call call, void* task) {
    std::unique_lock lock(mutex_);
    call_ = call;
    task_ = task;
    count_ = count;
    next_ = 0;
    finished_ = 0;
    wake_.notify_all();
    while (take_one(lock)) {
    }
    done_.wait(lock, [this] { return finished_ == count_; });
    count_ = 0;
    next_ = 0;
}

void WorkerPool::work() {
    std::unique_lock lock(mutex_);
    while (!stop_) {
        if (!take_one(lock)) wake_.wait(lock, [this] { return stop_ || next_ < count_; });
    }
}

}  // namespace atropos::scenes
