#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <vector>

#include "experiments/arm_reading.hpp"
#include "experiments/instrument_colours.hpp"
#include "experiments/instrument_outline.hpp"
#include "robot/scissors_input.hpp"
#include "scenes/stereo_rig.hpp"

namespace atropos::experiments {

/// How badly an arm's calibration may be off, one sigma; what the sight begins with and returns to.
struct SightPrior {
    double shift_m = 0.0011;  ///< of the whole instrument, each axis of C
    Eigen::Vector3d play_rad =
        Eigen::Vector3d::Zero();  ///< half widths of the cables' play: roll, pitch, yaw
};

/// Where one arm's instrument truly is, as the images show it: a shift of the whole, and what the three wrist
/// joints are off by because their cables have play. Kalman filter over frames; a measurement is the way from
/// the predicted outline to the border of what has the instruments' colours. Sees images and measured poses
/// only.
class InstrumentSight {
  public:
    using Parameters = Eigen::Matrix<double, 6, 1>;  ///< shift in C (m), roll, pitch, yaw (rad)
    using Covariance = Eigen::Matrix<double, 6, 6>;

    /// What is seen by one eye.
    struct EyeView {
        const scenes::Camera* camera;
        Eigen::Isometry3d X_EC;
        cv::Mat probability;  ///< of an instrument, CV_32F
        cv::Mat labels;       ///< 8 bit: number + 1 of the arm predicted there, 0 none
    };

    InstrumentSight(const render::InstrumentModel& model, const SightPrior& prior);

    /// Carries the belief on to what `arm` measures now.
    void predict(const ArmReading& arm);

    /// Draws the outline where it is believed to be. Once a frame, before `look`.
    void project(const std::array<EyeView, 2>& eyes);

    /// Fits the outline to both eyes; false when too little of it is seen. `number`: of this arm in the
    /// labels.
    bool look(const std::array<EyeView, 2>& eyes, int number);

    /// The outline in one eye (0 left, 1 right), as last drawn or fitted.
    const std::vector<InstrumentOutline::Polygon>& outline(size_t eye) const { return polygons_[eye]; }

    /// Tip as believed.
    Eigen::Isometry3d X_CT() const;
    std::vector<scenes::Capsule> capsules_C() const;

    /// Of a point of the tip's frame: believed minus measured; nothing when the last frame did not show it.
    std::optional<robot::InstrumentOffset> offset(const Eigen::Vector3d& p_T) const;

    /// Of a point of the tip's frame: how sure the belief is, one axis (m).
    Eigen::Matrix3d covariance(const Eigen::Vector3d& p_T) const;
    double support() const { return support_; }  ///< share of the outline that lies on borders

  private:
    using Links = std::array<Eigen::Isometry3d, robot::kLinkCount>;
    Links links_C(const Parameters& x) const;
    Eigen::Isometry3d X_CT(const Parameters& x) const;
    void move(const std::array<EyeView, 2>& eyes, const Parameters& x);
    void collect(const EyeView& eye, size_t side, int number, const Parameters& x, double reach_px,
                 Covariance& H, Parameters& g);

    InstrumentOutline outline_;
    SightPrior prior_;
    Covariance P0_;
    ArmReading arm_;
    bool started_ = false, seen_ = false;
    Parameters x_ = Parameters::Zero();
    Covariance P_;
    std::array<std::vector<InstrumentOutline::Polygon>, 2> polygons_;
    cv::Mat own_;  // of one eye: pixels inside the outline
    double support_ = 0.0;
    int tried_ = 0, fitted_ = 0;
};

}  // namespace atropos::experiments
