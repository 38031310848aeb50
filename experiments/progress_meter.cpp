#include "experiments/progress_meter.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace atropos::experiments {
using Clock = std::chrono::steady_clock;

ProgressMeter::ProgressMeter(std::string what, long total, bool quiet)
    : what_(std::move(what)),
      total_(std::max(1L, total)),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      drawn_(start_ - std::chrono::hours(1)) {}

ProgressMeter::~ProgressMeter() {
    if (!quiet_ && terminal_ && done_ > 0) fmt::print(stderr, "\r\033[K");
}

void ProgressMeter::advance(long steps) {
    done_ += steps;
    if (!quiet_) draw();
}

void ProgressMeter::draw() {
    const auto now = Clock::now();
    const double elapsed_s = std::chrono::duration<double>(now - start_).count();
    const double rate = static_cast<double>(done_) / std::max(elapsed_s, 1e-9);
    const double left_s = static_cast<double>(total_ - done_) / std::max(rate, 1e-9);
    if (terminal_) {
        if (now - drawn_ < std::chrono::milliseconds(100) && done_ < total_) return;
        drawn_ = now;
        const auto width = static_cast<size_t>(30 * std::min(done_, total_) / total_);
        fmt::print(stderr, "\r{} [{:<30}] {}/{}  {:.1f}/s  {:.0f} s left \033[K", what_,
                   std::string(width, '#'), done_, total_, rate, left_s);
        std::fflush(stderr);
    } else if (done_ >= next_line_) {
        fmt::print(stderr, "{}: {}/{}, {:.1f} a second, {:.0f} s left\n", what_, done_, total_, rate, left_s);
        next_line_ = done_ + std::max(1L, total_ / 10);
    }
}

}  // namespace atropos::experiments
