#pragma once

#include <Eigen/Geometry>

#include "robot/motion_profile.hpp"

namespace atropos::robot {

/// The way of the blades from where they are to a stand-off before a target that may move: what separates
/// them shrinks from all (share 1) to nothing (share 0), rotation and position together.
class BladeTravel {
  public:
    BladeTravel() = default;
    BladeTravel(const Eigen::Isometry3d& X_CS, const Eigen::Vector3d& target_C, double standoff_m);

    Eigen::Isometry3d at(double share, const Eigen::Vector3d& target_C, const Eigen::Matrix3d& R_CS,
                         double standoff_m) const;

    /// Greatest way of the blade point, and its turn, to a goal.
    double way_m(const Eigen::Matrix3d& R_CS, double standoff_m) const;
    double turn_rad(const Eigen::Matrix3d& R_CS) const;

  private:
    Eigen::Quaterniond R_start_ = Eigen::Quaterniond::Identity();
    Eigen::Vector3d gap_ = Eigen::Vector3d::Zero();
};

/// Reference pose of the blade point S: keeps up with a predicted target, smoothly though each new estimate
/// moves the prediction, at speeds that suit the neighbourhood.
class BladePursuit {
  public:
    struct Options {
        double travel_speed_m_s = 0.04;
        double near_speed_m_s = 0.02;
        double turn_speed_rad_s = 1.5;
        /// Corrections of the prediction are made up for within this time constant, but not faster than this.
        double smooth_s = 0.04;
        double correction_speed_m_s = 0.05;
    };
    struct Goal {
        Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
        Eigen::Matrix3d R_CS = Eigen::Matrix3d::Identity();
    };

    BladePursuit(const Options& options, const Eigen::Isometry3d& X_CS);

    /// Sets out for a stand-off before the goal.
    void travel(const Goal& goal, double standoff_m);

    /// Changes the stand-off; 0 is at the goal.
    void advance_to(double standoff_m);

    /// A new estimate moved the prediction: position and velocity before minus after.
    void absorb(const Eigen::Vector3d& p, const Eigen::Vector3d& v);

    /// Stops being a pursuit: the goal that keeps the reference at `X_CS` with its present stand-off. `v` is
    /// run out smoothly.
    Goal stand(const Eigen::Isometry3d& X_CS, const Eigen::Vector3d& v);

    /// The arm could not go where step() said and still is at `p_C`.
    void yield(const Eigen::Vector3d& p_C);

    /// The reference one period later; `goal` is where the prediction sees it then.
    const Eigen::Isometry3d& step(const Goal& goal);

    const Eigen::Isometry3d& X_CS() const { return X_CS_; }
    double delay_s() const { return options_.smooth_s; }  ///< after which a correction has been made
    bool arrived() const { return share_.done(); }
    double standoff_m() const { return standoff_.state.position; }
    bool at_standoff() const { return standoff_.done(); }
    bool is_advancing() const { return !at_standoff() && standoff_.goal < standoff_.state.position; }

  private:
    struct Glide {
        MotionState state;
        MotionProfile profile;
        double goal = 0.0;
        double time_s = 0.0;
        void to(double position, const MotionLimits& limits);
        void step();
        bool done() const { return time_s >= profile.duration_s(); }
    };
    void turn_towards(const Eigen::Matrix3d& R_CS);

    Options options_;
    Eigen::Isometry3d X_CS_;
    BladeTravel travel_;
    Glide share_, standoff_;
    Eigen::Vector3d error_ = Eigen::Vector3d::Zero(), error_rate_ = Eigen::Vector3d::Zero();
    Eigen::Quaterniond limited_ = Eigen::Quaterniond::Identity(), smooth_ = Eigen::Quaterniond::Identity();
};

}  // namespace atropos::robot
