#include "experiments/job_pool.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "experiments/exit_status.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace {

using Clock = std::chrono::steady_clock;

/// The child's whole life: never returns.
[[noreturn]] void live(const JobPool::Work& work, const std::filesystem::path& log, pid_t parent) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(kInternal);
    const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file >= 0) {
        dup2(file, STDOUT_FILENO);
        dup2(file, STDERR_FILENO);
    }
    int status = kInternal;
    try {
        status = work();
    } catch (const scenes::FileError& error) {
        status = kBadInput;
        fmt::print(stderr, "{}\n", error.what());
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
    }
    std::fflush(nullptr);
    _exit(status);
}

std::string last_line(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::string line, last;
    while (std::getline(stream, line))
        if (!line.empty()) last = line;
    return last.substr(0, 500);
}

}  // namespace

JobPool::JobPool(int size) : size_(size) {}

JobPool::~JobPool() {
    for (const Running& task : running_) {
        kill(-task.child, SIGKILL);
        kill(task.child, SIGKILL);
        waitpid(task.child, nullptr, 0);
        std::error_code error;
        std::filesystem::remove(task.log, error);
    }
}

void JobPool::start(const Work& work, double timeout_s, std::filesystem::path log, Then then) {
    std::fflush(nullptr);
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0) live(work, log, parent);
    if (child < 0) throw std::runtime_error(std::string("no child process: ") + std::strerror(errno));
    setpgid(child, child);
    const auto time = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s));
    running_.push_back({child, Clock::now() + time, timeout_s, std::move(log), std::move(then)});
}

TaskEnd JobPool::end_of(const Running& task, int status) {
    if (task.timed_out) return {TaskEnd::Kind::kFailed, fmt::format("took longer than {} s", task.timeout_s)};
    if (WIFSIGNALED(status))
        return {TaskEnd::Kind::kFailed, fmt::format("ended by signal {}", WTERMSIG(status))};
    if (WEXITSTATUS(status) == kDone) return {};
    const std::string line = last_line(task.log);
    return {WEXITSTATUS(status) == kBadInput ? TaskEnd::Kind::kBadInput : TaskEnd::Kind::kFailed,
            line.empty() ? fmt::format("exit status {}", WEXITSTATUS(status)) : line};
}

void JobPool::wait() {
    while (!running_.empty()) {
        for (auto task = running_.begin(); task != running_.end(); ++task) {
            int status = 0;
            if (waitpid(task->child, &status, WNOHANG) == task->child) {
                const Running ended = *task;
                running_.erase(task);
                kill(-ended.child, SIGKILL);  // what it left behind
                const TaskEnd end = end_of(ended, status);
                std::error_code error;
                std::filesystem::remove(ended.log, error);
                ended.then(end);
                return;
            }
            if (!task->timed_out && Clock::now() > task->deadline) {
                task->timed_out = true;
                kill(-task->child, SIGKILL);
            }
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
}

}  // namespace atropos::experiments
