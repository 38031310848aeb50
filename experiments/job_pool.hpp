#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <list>
#include <string>

namespace atropos::experiments {

/// How a child process ended.
struct TaskEnd {
    enum class Kind {
        kDone,      ///< exit status 0
        kFailed,    ///< another exit status, a crash, or out of time: `reason`
        kBadInput,  ///< exit status 2: input or environment, nothing that the task is to blame for
    };
    Kind kind = Kind::kDone;
    std::string reason;  ///< the last line it printed, or how it died
};

/// Runs tasks as child processes of this program, a few at a time. A child dies with us, prints into a file
/// of its own, and is ended when its time is over.
class JobPool {
  public:
    using Work = std::function<int()>;  ///< in the child; returns its exit status, may throw
    using Then = std::function<void(const TaskEnd&)>;

    explicit JobPool(int size);
    ~JobPool();  ///< ends what still runs
    JobPool(const JobPool&) = delete;
    JobPool& operator=(const JobPool&) = delete;

    bool has_room() const { return static_cast<int>(running_.size()) < size_; }
    bool is_idle() const { return running_.empty(); }

    /// Throws std::runtime_error when no process can be made. `log` is removed when the task is done.
    void start(const Work& work, double timeout_s, std::filesystem::path log, Then then);

    /// Returns after at least one task has ended and its `then` was called.
    void wait();

  private:
    struct Running {
        pid_t child;
        std::chrono::steady_clock::time_point deadline;
        double timeout_s;
        std::filesystem::path log;
        Then then;
        bool timed_out = false;
    };
    static TaskEnd end_of(const Running& task, int status);

    int size_;
    std::list<Running> running_;
};

}  // namespace atropos::experiments
