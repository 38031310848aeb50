#pragma once

#include <Eigen/Geometry>
#include <istream>
#include <string>
#include <vector>

#include "robot/psm_arm.hpp"

namespace atropos::robot {

/// One arm's recorded motion, as joints or as tip poses in some frame.
struct Recording {
    std::string arm;       ///< PSM1 ..., empty when the file does not say
    std::string frame_id;  ///< of `X_FT`: C, ECM or <arm>_base; "joints": no poses, drive the joints
    std::vector<double> time_s;
    std::vector<int> line;                ///< of the file, for messages
    std::vector<Joints> q;                ///< empty when the file has none
    std::vector<double> jaw_rad;          ///< empty when the file has none
    std::vector<Eigen::Isometry3d> X_FT;  ///< empty when the file has none

    size_t size() const { return time_s.size(); }
};

/// A sequence's kinematics.csv (columns of design.md; rows of several arms) or a table whose header has six
/// columns q1..q6, *_q1..*_q6 or CRTK's joint names, with rows `rate_hz` apart. All errors are
/// std::runtime_error "NAME:LINE: what is wrong, what was expected".
std::vector<Recording> read_recording_csv(std::istream& in, const std::string& name, double rate_hz = 100.0);

/// JIGSAWS: 76 columns without header at 30 Hz. Gives PSM1 (patient-side left) and PSM2 (right): tip
/// position, rotation (row by row) and gripper angle, in frame ECM.
std::vector<Recording> read_jigsaws(std::istream& in, const std::string& name);

/// Where a recording's frames are in the scene.
struct ReplayFrames {
    Eigen::Isometry3d X_BC = Eigen::Isometry3d::Identity();  ///< camera C in the arm's base, as registered
    /// The scene file's registration: applied, in the recording's frame, to every pose.
    Eigen::Isometry3d X_registration = Eigen::Isometry3d::Identity();
};

/// A recording turned into joints of an arm at 1 kHz.
class Replay {
  public:
    static constexpr double kAngleSlack_rad = 0.01, kLengthSlack_m = 0.001;

    /// Values past a joint limit by up to the slack are clamped and counted; the first row beyond it, or out
    /// of reach, or with times that do not grow, is a std::runtime_error naming `name` and the line.
    Replay(const Recording& recording, const Psm& psm, const ReplayFrames& frames, const std::string& name);

    double duration_s() const { return time_s_.back(); }
    int clamped_values() const { return clamped_; }

    /// Joints at `time_s` from the recording's first row, by cubic interpolation inside the limits; the last
    /// ones after its end.
    Joints joints(double time_s) const;
    double jaw_rad(double time_s) const;

    /// Streams the recording to an arm for this period; the arm should stand at joints(0).
    CommandResult drive(PsmArm& arm, double time_s) const;

  private:
    void clamp(Joints& q, const std::string& where);
    void clamp_jaw(double& jaw, const std::string& where);

    Psm psm_;
    std::vector<double> time_s_;
    std::vector<Joints> q_;
    std::vector<double> jaw_rad_;
    int clamped_ = 0;
};

}  // namespace atropos::robot
