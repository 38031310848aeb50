#pragma once

#include <array>
#include <filesystem>
#include <string>

#include "experiments/append_file.hpp"
#include "experiments/closed_loop.hpp"

namespace atropos::experiments {

/// What the pilot of a run was given and what it commanded, in `inputs/` of the run's folder: pictures as
/// PNG, every measured pose in full precision, the goals of the scissors' joints at each millisecond. No
/// truth.
class LoopRecording {
  public:
    /// Throws scenes::FileError when the folder can't be written.
    LoopRecording(const std::filesystem::path& folder, const ClosedLoop& loop);

    void add(const LoopFrame& frame, double time_s);
    void add(const LoopTick& tick);
    void close();

  private:
    std::filesystem::path folder_;
    AppendFile frames_, readings_, commands_;
    std::array<double, kArms> last_s_{};
};

/// One line of commands.csv.
std::string command_row(double time_s, const robot::PsmArm& scissors);

/// Feeds the recorded inputs of a run, and nothing else, to a new pilot; the commands it gives, in the form
/// of commands.csv. Throws scenes::FileError when the recording is incomplete.
std::string replay_inputs(const std::filesystem::path& run_folder);

}  // namespace atropos::experiments
