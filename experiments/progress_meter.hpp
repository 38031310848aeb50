#pragma once

#include <chrono>
#include <string>

namespace atropos::experiments {

/// Progress of long work on stderr: a bar with rate and remaining time on a terminal, a plain line every ten
/// per cent elsewhere, nothing when quiet.
class ProgressMeter {
  public:
    ProgressMeter(std::string what, long total, bool quiet);
    ~ProgressMeter();
    void advance(long steps = 1);

  private:
    void draw();
    std::string what_;
    long total_;
    long done_ = 0;
    long next_line_ = 0;
    bool quiet_;
    bool terminal_;
    std::chrono::steady_clock::time_point start_;
    std::chrono::steady_clock::time_point drawn_;
};

}  // namespace atropos::experiments
