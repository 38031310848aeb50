#pragma once

#include <Eigen/Core>

namespace atropos::robot {

/// Kalman filter of a moving point whose acceleration fades (Singer 1970): position, velocity and an
/// acceleration of given size that is forgotten in given time. The size adapts to the innovations. Where
/// something known drives the point, its linear response to that is learned along: p = motion + R drive.
class MotionFilter {
  public:
    struct Options {
        double acceleration_sigma_m_s2 = 0.05;
        double forget_s = 0.3;                              ///< correlation time of the acceleration
        double velocity_sigma_m_s = 0.05;                   ///< before anything is known
        double least_adapted = 0.02, most_adapted = 100.0;  ///< bounds of the adaptation, of the variance
        double response_sigma = 0.0;      ///< of each entry of R; 0: nothing drives the point
        double response_forget_s = 20.0;  ///< in which R becomes another one
    };
    struct State {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        Eigen::Vector3d v = Eigen::Vector3d::Zero();      ///< of the motion alone
        Eigen::Matrix3d R = Eigen::Matrix3d::Zero();      ///< response to the drive
        Eigen::Matrix3d known = Eigen::Matrix3d::Zero();  ///< covariance of p at the last update, m^2
        Eigen::Matrix3d growth =
            Eigen::Matrix3d::Zero();  ///< covariance of p gained since the last update, m^2
    };

    MotionFilter() = default;
    explicit MotionFilter(const Options& options) : options_(options) {}

    bool started() const { return started_; }
    double time_s() const { return time_s_; }
    void start(double time_s, const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance);

    /// Squared distance of a measurement from its prediction in units of its standard deviation (three
    /// degrees of freedom); changes nothing. `drive` in m.
    double surprise(double time_s, const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance,
                    const Eigen::Vector3d& drive = Eigen::Vector3d::Zero()) const;

    /// `time_s` must not go back.
    void update(double time_s, const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance,
                const Eigen::Vector3d& drive = Eigen::Vector3d::Zero());

    State at(double time_s, const Eigen::Vector3d& drive = Eigen::Vector3d::Zero()) const;

  private:
    static constexpr int kMotion = 9, kSize = 18;  // position, velocity, acceleration; columns of R
    using Matrix18d = Eigen::Matrix<double, kSize, kSize>;
    using Observation = Eigen::Matrix<double, 3, kSize>;
    struct Belief {
        Eigen::Matrix<double, 3, 6> x;  // columns: position, velocity, acceleration, R
        Matrix18d P;
    };
    Belief advanced(double time_s) const;
    double jerk_density() const;
    static Observation observation(const Eigen::Vector3d& drive);

    Options options_;
    bool started_ = false;
    double time_s_ = 0.0;
    Eigen::Vector3d drive_ = Eigen::Vector3d::Zero();  // at the last update
    double adapted_ = 1.0;                             // of the acceleration's variance
    Belief belief_{Eigen::Matrix<double, 3, 6>::Zero(), Matrix18d::Zero()};
};

}  // namespace atropos::robot
