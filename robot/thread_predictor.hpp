#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "robot/motion_filter.hpp"
#include "robot/scissors_input.hpp"
#include "robot/scissors_options.hpp"

namespace atropos::robot {

/// Where the thread will be cut at some time, in C.
struct ThreadPrediction {
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
    Eigen::Vector3d v_C = Eigen::Vector3d::Zero();
    Eigen::Vector3d tangent_C = Eigen::Vector3d::UnitX();
    Eigen::Matrix3d tracking = Eigen::Matrix3d::Zero();  ///< covariance when last seen, over all frames, m^2
    Eigen::Matrix3d prediction = Eigen::Matrix3d::Zero();  ///< covariance gained since, m^2
};

/// Carries the place of the cut from late estimates to any moment near now. What the measured grips do is
/// known at once: the thread goes with their mean, and how it gives when they move against one another is
/// learned; only what is left is the filter's to guess.
class ThreadPredictor {
  public:
    enum class Verdict { kUsed, kUnusable, kImplausible, kJumped };

    /// How surprising an estimate may be: wary while blades that close hide part of the thread.
    enum class Trust { kUsual, kWary };

    explicit ThreadPredictor(const ScissorsOptions& options);

    /// Measured poses of the holding arms, as often as they come.
    void observe_grips(const ScissorsInput& input);

    /// Estimates must come in the order of their capture. Implausible ones are refused, with rejection().
    Verdict observe(const scenes::ThreadEstimate& estimate, Trust trust = Trust::kUsual);

    /// False until an estimate has been used.
    bool known() const { return relative_.started(); }
    double capture_time_s() const { return relative_.time_s(); }  ///< of the last used estimate
    ThreadPrediction at(double time_s) const;

    /// Covariance gained when the cut is made `closing_s` after `now_s` and nothing but the grips is followed
    /// meanwhile, m^2.
    Eigen::Matrix3d growth(double now_s, double closing_s) const;

    /// The samples of the last used estimate.
    const std::vector<scenes::ThreadSample>& samples() const { return samples_; }

    /// Why the last estimate was not used; empty when it was.
    const std::string& rejection() const { return rejection_; }

    /// Forgets the thread, not the grips.
    void forget();

  private:
    struct GripSample {
        double time_s;
        Eigen::Vector3d p;      // weighted by nearness to the cut
        Eigen::Vector3d apart;  // from end 0 to end 1
    };
    static constexpr size_t kHistory = 512;
    static constexpr double kGripPeriod_s = 0.004;

    Verdict refuse(Verdict verdict, std::string why);
    bool plausible(const scenes::ThreadEstimate& estimate);
    bool ends_at_grips(const scenes::ThreadEstimate& estimate);
    GripSample grips_at(double time_s) const;
    void remember(const GripSample& grips);
    Eigen::Vector3d drive(const GripSample& grips) const { return grips.apart - apart_; }
    const GripSample& past(size_t age) const { return history_[(head_ + kHistory - age) % kHistory]; }

    ScissorsOptions options_;
    MotionFilter relative_;
    MotionFilter grips_, spread_;  // of the grips' weighted mean and of the way between them
    std::array<GripSample, kHistory> history_{};
    size_t head_ = 0;
    size_t count_ = 0;
    std::array<std::optional<Eigen::Vector3d>, 2> grip_points_;
    double weight_ = -1.0;                             // of end 1; negative: not yet known
    Eigen::Vector3d apart_ = Eigen::Vector3d::Zero();  // of the grips when the filter began
    double length_m_ = 0.0;                            // slow mean of the span's
    Eigen::Vector3d tangent_ = Eigen::Vector3d::UnitX();
    Eigen::Matrix3d tracking_ = Eigen::Matrix3d::Zero();
    double last_capture_s_ = -1e9;
    double jumped_since_s_ = -1.0;
    std::vector<scenes::ThreadSample> samples_;
    std::string rejection_;
};

/// Arc length from end 0 at which a span of this length is to be cut.
double cut_arc_length_m(const CutPlace& place, double length_m);

}  // namespace atropos::robot
