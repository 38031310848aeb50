#pragma once

#include <Eigen/Geometry>
#include <array>

#include "robot/layout.hpp"

namespace atropos::robot {

/// Where the default scene begins: two arms hold the thread before the camera, the third waits with its
/// blades out of the thread's way. For the default layout at 0.1 m; own choices, measured in
/// tests/robot/layout_defaults_test.
///
/// The grips stand symmetrically 50 mm apart and 10 mm above the target, so that a 70 mm thread hangs with
/// its middle about as far below it: grips and middle lie at depths of 93 and 107 mm, 7 mm above and below
/// the picture's centre. The jaws point down and outwards, the thread leaves along the jaw pins, inwards and
/// down.
struct LayoutDefaults {
    double thread_length_m = 0.070;
    double grip_distance_m = 0.050;
    double grip_height_m = 0.010;    ///< above the target, in W
    double grip_tilt_rad = 0.2618;   ///< of the jaws from straight down, outwards
    double park_distance_m = 0.060;  ///< of the blades from the target, on the line to the remote centre
    double holder_jaw_rad = -0.17;   ///< squeezing
    double parked_jaw_rad = 0.0;

    /// Grip frames of PSM1 and PSM2 in W. The thread runs along +y_G from PSM1 to PSM2.
    std::array<Eigen::Isometry3d, 2> X_WG() const;

    /// Blade frame S in W for a cut at `p_WS` of a thread that runs along `tangent_W`: y along the thread, z
    /// as near as can be to the line from the remote centre `p_WB`. Throws std::invalid_argument when both
    /// are parallel.
    static Eigen::Isometry3d X_WS(const Eigen::Vector3d& p_WS, const Eigen::Vector3d& tangent_W,
                                  const Eigen::Vector3d& p_WB);

    /// Blade frame of the parked third arm.
    Eigen::Isometry3d X_WS_parked(const Eigen::Vector3d& p_WB) const;
    /// The same with the blade point at `p_WS`.
    static Eigen::Isometry3d X_WS_parked_at(const Eigen::Vector3d& p_WS, const Eigen::Vector3d& p_WB);
};

/// Joints that put the tool frame X_TF (grip or blade) of an arm at X_WF; the roll nearest to `q_near`'s.
IkResult<Joints> joints_for(const Psm& psm, const Eigen::Isometry3d& X_WB, const Eigen::Isometry3d& X_WF,
                            const Eigen::Isometry3d& X_TF, const Joints& q_near = Joints::Zero());

}  // namespace atropos::robot
