#include "experiments/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <stdexcept>
#include <thread>

namespace atropos::experiments {
namespace {

constexpr std::size_t kMaxLine = std::size_t{16} << 20;
constexpr auto kFarewell = std::chrono::milliseconds(500);
using Clock = std::chrono::steady_clock;

void make_pipe(int (&ends)[2]) {
    if (pipe2(ends, O_CLOEXEC) != 0)
        throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
}

}  // namespace

ChildProcess::ChildProcess(const std::string& command) {
    int in[2], out[2];
    make_pipe(in);
    make_pipe(out);
    const pid_t parent = getpid();
    child_ = fork();
    if (child_ == 0) {
        setpgid(0, 0);
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (getppid() != parent) _exit(127);
        std::signal(SIGPIPE, SIG_DFL);
        dup2(in[0], STDIN_FILENO);
        dup2(out[1], STDOUT_FILENO);
        execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
        _exit(127);
    }
    ::close(in[0]);
    ::close(out[1]);
    to_child_ = in[1];
    from_child_ = out[0];
    if (child_ < 0) {
        ::close(to_child_);
        ::close(from_child_);
        throw std::runtime_error(std::string("no child process: ") + std::strerror(errno));
    }
    setpgid(child_, child_);
    std::signal(SIGPIPE, SIG_IGN);
    fcntl(to_child_, F_SETFL, O_NONBLOCK);
    fcntl(from_child_, F_SETFL, O_NONBLOCK);
    fcntl(to_child_, F_SETPIPE_SZ, 1 << 20);
}

ChildProcess::~ChildProcess() {
    ::close(to_child_);
    ::close(from_child_);
    const auto end = Clock::now() + kFarewell;
    while (waitpid(child_, nullptr, WNOHANG) == 0) {
        if (Clock::now() > end) {
            kill(-child_, SIGKILL);
            waitpid(child_, nullptr, 0);
            return;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    kill(-child_, SIGKILL);  // what it started itself
}

ChildProcess::Wait ChildProcess::wait(bool to_write, Deadline deadline, bool& readable,
                                      bool& writable) const {
    std::array<pollfd, 2> fds{{{from_child_, POLLIN, 0}, {to_child_, POLLOUT, 0}}};
    while (true) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
        if (left <= 0) return Wait::kTimeout;
        const int ready = poll(fds.data(), to_write ? 2 : 1, static_cast<int>(std::min<long>(left, 60000)));
        if (ready < 0 && errno != EINTR)
            throw std::runtime_error(std::string("poll: ") + std::strerror(errno));
        if (ready <= 0) continue;
        readable = fds[0].revents != 0;
        writable = to_write && fds[1].revents != 0;
        return Wait::kReady;
    }
}

bool ChildProcess::receive() {
    std::array<char, 65536> buffer{};
    const ssize_t got = ::read(from_child_, buffer.data(), buffer.size());
    if (got < 0) return errno == EINTR || errno == EAGAIN;
    received_.append(buffer.data(), static_cast<size_t>(got));
    return got > 0;
}

ChildProcess::Outcome ChildProcess::send(const std::vector<std::span<const unsigned char>>& parts,
                                         Deadline deadline) {
    for (std::span<const unsigned char> rest : parts)
        while (!rest.empty()) {
            bool readable = false, writable = false;
            if (wait(true, deadline, readable, writable) == Wait::kTimeout) return Outcome::kTimeout;
            if (readable && !receive()) return Outcome::kClosed;
            if (received_.size() > kMaxLine) return Outcome::kTooLong;
            if (!writable) continue;
            const ssize_t written = ::write(to_child_, rest.data(), rest.size());
            if (written < 0 && errno != EINTR && errno != EAGAIN) return Outcome::kClosed;
            if (written > 0) rest = rest.subspan(static_cast<size_t>(written));
        }
    return Outcome::kDone;
}

bool ChildProcess::take_line(std::string& line) {
    const std::size_t end = received_.find('\n', searched_);
    searched_ = received_.size();
    if (end == std::string::npos) return false;
    line = received_.substr(0, end);
    received_.erase(0, end + 1);
    searched_ = 0;
    return true;
}

ChildProcess::Outcome ChildProcess::read_line(std::string& line, Deadline deadline) {
    while (!take_line(line)) {
        if (received_.size() > kMaxLine) return Outcome::kTooLong;
        bool readable = false, writable = false;
        if (wait(false, deadline, readable, writable) == Wait::kTimeout) return Outcome::kTimeout;
        if (!receive()) return take_line(line) ? Outcome::kDone : Outcome::kClosed;
    }
    return Outcome::kDone;
}

}  // namespace atropos::experiments
