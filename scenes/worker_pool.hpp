#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

namespace atropos::scenes {

/// Runs independent tasks on some threads, the caller's among them. Tasks write to places of their own, so
/// that the number of threads changes no byte. Starts its threads once; running tasks allocates nothing.
class WorkerPool {
  public:
    /// `threads` >= 1 in all; 1 starts none.
    explicit WorkerPool(int threads);
    ~WorkerPool();
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    /// Calls task(0) ... task(count - 1) and returns when all are done. Tasks must not throw.
    template <typename Task>
    void run(int count, Task&& task) {
        if (workers_.empty()) {
            for (int i = 0; i < count; ++i) task(i);
            return;
        }
        run_shared(
            count, [](void* what, int i) { (*static_cast<std::remove_reference_t<Task>*>(what))(i); }, &task);
    }

  private:
    using Call = void (*)(void*, int);
    void run_shared(int count, Call call, void* task);
    void work();
    bool take_one(std::unique_lock<std::mutex>& lock);

    std::vector<std::thread> workers_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::condition_variable done_;
    Call call_ = nullptr;
    void* task_ = nullptr;
    int count_ = 0;
    int next_ = 0;
    int finished_ = 0;
    bool stop_ = false;
};

}  // namespace atropos::scenes
