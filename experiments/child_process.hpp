#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace atropos::experiments {

/// A shell command as a child in its own process group, its stdin and stdout in our hands, its stderr ours.
/// It dies with us, and its death never takes us along (no SIGPIPE).
class ChildProcess {
  public:
    using Deadline = std::chrono::steady_clock::time_point;

    /// Throws std::runtime_error when no process can be made. A command that doesn't exist shows as an end.
    explicit ChildProcess(const std::string& command);
    ~ChildProcess();  ///< ends its input, waits a moment, then kills its group
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    enum class Outcome { kDone, kTimeout, kClosed, kTooLong };

    /// Sends all parts one after the other; what it prints meanwhile is kept, so that neither waits for the
    /// other.
    Outcome send(const std::vector<std::span<const unsigned char>>& parts, Deadline deadline);

    /// The next line of its stdout without the newline.
    Outcome read_line(std::string& line, Deadline deadline);

  private:
    enum class Wait { kReady, kTimeout };
    Wait wait(bool to_write, Deadline deadline, bool& readable, bool& writable) const;
    bool receive();  ///< takes what is there; false at the end
    bool take_line(std::string& line);

    pid_t child_ = -1;
    int to_child_ = -1;
    int from_child_ = -1;
    std::string received_;
    std::size_t searched_ = 0;
};

}  // namespace atropos::experiments
