#pragma once

#include <memory>
#include <vector>

#include "experiments/instrument_sights.hpp"
#include "experiments/sequence.hpp"
#include "robot/psm.hpp"

namespace atropos::experiments {

/// The arms of a recorded sequence as a tracker in the loop would know them: their measured poses, and
/// where the pictures show the instruments.
class SequenceArms {
  public:
    /// Reads kinematics.csv, and the arms' tools from scene.yaml. Null when one of the two is missing or the
    /// poses are not in C. `rig` is the tracker's. Throws scenes::FileError on bad rows.
    static std::unique_ptr<SequenceArms> open(const Sequence& sequence, const scenes::StereoRig& rig,
                                              int threads);

    /// Adds the instruments to the frame that was number `index` of the sequence. Measured held ends move by
    /// as much as their grips are seen away from where they are measured. Once a frame, in their order.
    void add_to(tracker::StereoFrame& frame, int index);

  private:
    SequenceArms(const scenes::SceneConfig& scene, const scenes::StereoRig& rig, int threads);

    std::array<std::unique_ptr<robot::Psm>, kArms> psms_;
    std::unique_ptr<InstrumentSights> sights_;
    bool tips_are_measured_;
    std::vector<ArmReadings> readings_;  ///< one a frame
};

}  // namespace atropos::experiments
