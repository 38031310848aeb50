#pragma once

#include <Eigen/Core>

namespace atropos::robot {

/// Kalman filter of a moving point whose acceleration fades (Singer 1970): position, velocity and an
/// acceleration of given size that is forgotten in given time. The size adapts to the innovations.
class MotionFilter {
  public:
    struct Options {
        double acceleration_sigma_m_s2 = 0.05;
        double forget_s = 0.3;             ///< correlation time of the acceleration
        double velocity_sigma_m_s = 0.05;  ///< before anything is known
        double along_share = 1.0;          ///< of acceleration and velocity along `set_along`'s direction
        double least_adapted = 0.02, most_adapted = 100.0;  ///< bounds of the adaptation, of the variance
    };
    struct State {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        Eigen::Vector3d v = Eigen::Vector3d::Zero();
        Eigen::Matrix3d known = Eigen::Matrix3d::Zero();  ///< covariance of p at the last update, m^2
        Eigen::Matrix3d growth =
            Eigen::Matrix3d::Zero();  ///< covariance of p gained since the last update, m^2
    };

    MotionFilter() = default;
    explicit MotionFilter(const Options& options) : options_(options) {}

    /// Unit direction in which the motion differs by `along_share`; the adaptation heeds what is across it.
    void set_along(const Eigen::Vector3d& direction) { along_ = direction; }

    bool started() const { return started_; }
    double time_s() const { return time_s_; }
    void start(double time_s, const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance);

    /// Squared distance of a measurement from its prediction in units of its standard deviation (three
    /// degrees of freedom); changes nothing.
    double surprise(double time_s, const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance) const;

    /// `time_s` must not go back.
    void update(double time_s, const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance);

    State at(double time_s) const;

  private:
    using Matrix9d = Eigen::Matrix<double, 9, 9>;
    struct Belief {
        Eigen::Matrix3d x;  // columns: position, velocity, acceleration
        Matrix9d P;
    };
    Belief advanced(double time_s) const;
    double jerk_density() const;
    Eigen::Matrix3d shape() const;

    Options options_;
    bool started_ = false;
    double time_s_ = 0.0;
    Eigen::Vector3d along_ = Eigen::Vector3d::UnitX();
    double adapted_ = 1.0;  // of the acceleration's variance
    Belief belief_{Eigen::Matrix3d::Zero(), Matrix9d::Zero()};
};

}  // namespace atropos::robot
