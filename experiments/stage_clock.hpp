#pragma once

#include <chrono>
#include <map>
#include <string>

namespace atropos::experiments {

/// Wall time by stage of the program. For timing.json alone.
class StageClock {
  public:
    /// Adds the time until its own end to a stage.
    class Lap {
      public:
        Lap(StageClock& clock, const char* stage) : clock_(clock), stage_(stage) {}
        ~Lap() {
            clock_.seconds_[stage_] +=
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        }
        Lap(const Lap&) = delete;
        Lap& operator=(const Lap&) = delete;

      private:
        StageClock& clock_;
        const char* stage_;
        std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    };

    Lap lap(const char* stage) { return {*this, stage}; }
    const std::map<std::string, double>& seconds() const { return seconds_; }

  private:
    std::map<std::string, double> seconds_;
};

}  // namespace atropos::experiments
