#pragma once

#include <Eigen/Core>
#include <cstddef>

namespace atropos::tracker {

/// A point of space known to within a covariance (m, m^2), in C.
struct UncertainPoint {
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Where a fit puts its two ends, one above the other.
struct FittedEnds {
    Vector6d p_C = Vector6d::Zero();
    Matrix6d covariance = Matrix6d::Identity();
    Matrix6d by_noise = Matrix6d::Zero();  ///< the part of it that the noise of the images alone makes

    UncertainPoint end(std::size_t which) const;
    Eigen::Matrix3d noise(std::size_t which) const;
};

/// What a fit is told of an end: a place and an information, 1/m^2.
struct ToldEnd {
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
};

/// The fit that had been told `instead` of end `which` what it was `told`. Evidence on one end must not rest
/// on what was learned of the other: a curve that slides along itself would prove itself right.
FittedEnds told_instead(const FittedEnds& fit, std::size_t which, const ToldEnd& told,
                        const ToldEnd& instead);

/// What a fit says of where its end is, apart from what it was told of the end itself.
struct EndEvidence {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  ///< M; of images and all other priors, 1/m^2
    Eigen::Matrix3d new_part = Eigen::Matrix3d::Zero();  ///< of M: by noise that is another one in each frame
    Eigen::Vector3d score = Eigen::Vector3d::Zero();     ///< M (where it says - where it was expected), 1/m
};

/// Evidence from a fit that was told `expected` of its end, with the information `told`, and put it at
/// `fitted`; `by_noise` is the part of fitted.covariance that the noise of the images alone makes.
EndEvidence end_evidence(const Eigen::Vector3d& expected_C, const Eigen::Matrix3d& told,
                         const UncertainPoint& fitted, const Eigen::Matrix3d& by_noise);

/// What is known of the error of one measured end: the arm's registration, nearly constant, apart from what
/// changes from frame to frame. Filtered over time from where the fitted curve ended.
///
/// A fit's end is wrong in two ways. Noise makes it wrong anew in each frame. What was assumed of the curve
/// (bending, length, where jaws end) makes it wrong in the same way in frame after frame: that part, the rest
/// of the evidence's covariance, is a state of its own here (Schmidt's consider state), so that a hundred
/// frames that agree count as one look, not as a hundred.
class EndBelief {
  public:
    struct Options {
        double bias_sigma_m = 0.0011;    ///< of the constant error, each axis
        double jitter_sigma_m = 0.0003;  ///< of what is new in each frame
        double forget_s = 20.0;          ///< over which either error becomes another one
        double excess_sigma_m = 0.0004;  ///< jaws seen wider than their capsules, on each side
    };

    explicit EndBelief(const Options& options);

    void reset();

    /// Time goes on: the errors wander, within what is promised of them (Ornstein-Uhlenbeck).
    void wait(double dt_s);

    /// Where an end measured at `measured_C` is.
    UncertainPoint expected(const Eigen::Vector3d& measured_C) const;

    /// The same before anything was learned of the error.
    UncertainPoint unlearned(const Eigen::Vector3d& measured_C) const;

    /// Takes from a fit that used expected() what it says of the error.
    void learn(const EndEvidence& evidence);

    const Eigen::Vector3d& bias_C() const { return bias_C_; }

    /// How much wider than their capsules the jaws are seen on each side, and its variance.
    double excess_m() const { return excess_m_; }
    double excess_variance_m2() const { return excess_variance_m2_; }
    void learn_excess(double seen_m, double sigma_m);

    static constexpr int kStateSize = 44;
    void save(double* out) const;
    void load(const double* in);

  private:
    Options options_;
    Eigen::Vector3d bias_C_;  ///< added to the measured end
    Eigen::Vector3d common_;  ///< what evidence is off by in frame after frame, in its own sigmas
    Matrix6d P_;              ///< of both
    double excess_m_ = 0.0;
    double excess_variance_m2_ = 0.0;
};

}  // namespace atropos::tracker
