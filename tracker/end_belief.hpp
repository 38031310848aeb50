#pragma once

#include <Eigen/Core>

namespace atropos::tracker {

/// A point of space known to within a covariance (m, m^2), in C.
struct UncertainPoint {
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

/// What is known of the error of one measured end: the arm's registration, nearly constant, apart from what
/// changes from frame to frame. Filtered over time from where the fitted curve ended.
class EndBelief {
  public:
    struct Options {
        double bias_sigma_m = 0.0011;    ///< of the constant error, each axis
        double jitter_sigma_m = 0.0003;  ///< of what is new in each frame
        double forget_s = 20.0;          ///< over which the error becomes another one
        double excess_sigma_m = 0.0004;  ///< jaws seen wider than their capsules, on each side
    };

    explicit EndBelief(const Options& options);

    void reset();

    /// Time goes on: the error wanders, within what the options promise (Ornstein-Uhlenbeck).
    void wait(double dt_s);

    /// Where an end measured at `measured_C` is.
    UncertainPoint expected(const Eigen::Vector3d& measured_C) const;

    /// The fit, which used expected(measured_C) and images, put the end at `fitted`: takes from the images
    /// what they say of the error, and counts nothing twice (a fixed-lag step of Rauch, Tung, Striebel).
    void learn(const Eigen::Vector3d& measured_C, const UncertainPoint& fitted);

    const Eigen::Vector3d& bias_C() const { return bias_C_; }

    /// How much wider than their capsules the jaws are seen on each side, and its variance.
    double excess_m() const { return excess_m_; }
    double excess_variance_m2() const { return excess_variance_m2_; }
    void learn_excess(double seen_m, double sigma_m);

    static constexpr int kStateSize = 14;
    void save(double* out) const;
    void load(const double* in);

  private:
    Options options_;
    Eigen::Vector3d bias_C_;
    Eigen::Matrix3d P_;
    double excess_m_ = 0.0;
    double excess_variance_m2_ = 0.0;
};

}  // namespace atropos::tracker
