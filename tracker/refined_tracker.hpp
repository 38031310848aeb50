#pragma once

#include <Eigen/Core>
#include <array>
#include <string_view>
#include <vector>

#include "tracker/curve_refinement.hpp"
#include "tracker/curve_sight.hpp"
#include "tracker/curve_slide.hpp"
#include "tracker/eye_sight.hpp"
#include "tracker/loss_test.hpp"
#include "tracker/measured_ends.hpp"
#include "tracker/motion_prediction.hpp"
#include "tracker/recovery.hpp"
#include "tracker/rod_prediction.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

/// Tracks by continuous refinement: predict, look across the predicted curve for the thread in both eyes, fit
/// curve and length to what was found, look closer, fit again. A local loss test guards the result; only when
/// it fails is the paper's discrete search run (recovery). The estimate carries its own uncertainty.
class RefinedTracker final : public StereoTracker {
  public:
    RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig);
    RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                   const CurvePriors& priors, std::optional<DeformationPrior> deformation = std::nullopt);
    ~RefinedTracker() override;

    /// Takes an initial curve of any degree and number of control points.
    const TrackResult& start(const StereoFrame& frame, const NurbsCurve& initial) override;
    const TrackResult& track(const StereoFrame& frame) override;
    const StageTimings& timings() const override { return timings_; }
    TrackerState state() const override;
    void restore(const TrackerState& state) override;
    void set_observer(TrackObserver* observer) override { observer_ = observer; }

    const FitQuality& quality() const { return fit_.quality; }  ///< of the last frame

  private:
    /// A curve and how well the last frame bears it out.
    struct Fit {
        Eigen::Matrix3Xd Q;
        double length_m = 0.0;
        FitQuality quality;
    };

    /// One look at the images and the fit that follows; px at 640.
    struct Round {
        CurveSight::Look look;
        double robust_px;
        int iterations;
    };

    void begin(const NurbsCurve& initial);
    void set_control_points(int K);
    bool chooses_control_points() const;
    bool has_too_few_control_points() const;
    void follow_bends(const StereoFrame& frame);
    void slide_to_ends(Fit& fit) const;
    Eigen::Matrix3Xd control_points_of(const NurbsCurve& curve) const;
    NurbsCurve curve_of(const Eigen::Matrix3Xd& Q) const;
    void predict(const StereoFrame& frame);
    void correct_eye(const StereoFrame& frame);
    void set_rig(const scenes::StereoRig& rig);
    void refine(const StereoFrame& frame, double first_search_px, Fit& fit);
    void look_near_expected(const StereoFrame& frame);
    bool takes_given_length() const { return config_.thread.length_m > 0.0 && !length_refuted_; }
    void doubt_length(const StereoFrame& frame);
    double length_surprise();
    double surprise_px() const;
    void recover(const StereoFrame& frame);
    std::optional<NurbsCurve> near(const StereoFrame& frame, const Eigen::Matrix3Xd& expected);
    bool start_from_tips(const StereoFrame& frame);
    void try_fit(const StereoFrame& frame, const NurbsCurve& curve, Fit& best);
    void conclude(const StereoFrame& frame);
    void fill_estimate(const StereoFrame& frame);
    void show(std::string_view stage, const Eigen::Matrix3Xd& Q);
    std::size_t method_state_size() const;
    const TrackResult& lost(const StereoFrame& frame);

    scenes::TrackerConfig config_;
    scenes::StereoRig given_rig_;
    scenes::StereoRig rig_;  ///< with the right eye as it was found to be
    double scale_;           ///< image width over 640
    CurvePriors priors_;
    CurveRefinement refinement_;
    CurveInterpolation interpolation_;
    CurveSight sight_;
    MeasuredEnds ends_;
    LossTestOptions loss_test_;
    Recovery recovery_;
    std::optional<DeformationPrior> deformation_;
    std::optional<RodPrediction> rod_;
    std::optional<EyeSight> eye_;  ///< where the calibration is doubted

    // What passes from frame to frame.
    bool started_ = false;
    bool confirmed_ = false;  ///< a curve between measured ends that the images bear out
    scenes::TrackStatus status_ = scenes::TrackStatus::kLost;
    int frames_unseen_ = 0;
    double capture_time_s_ = 0.0;
    Fit fit_;
    MotionPrediction motion_;
    double surprise_px_ = 0.0;  ///< that the thread was off its prediction by, lately at most; at 640
    double expected_length_m_ = 0.0;
    double expected_length_sigma_m_ = 0.0;
    bool length_refuted_ = false;  ///< the length that was given

    // Working memory of one frame.
    Eigen::Matrix3Xd expected_;
    CurveProblem problem_;
    Fit trial_;
    Fit other_;
    CurveProblem chosen_problem_;
    std::vector<scenes::Capsule> instruments_C_;
    std::array<ImageView, 2> images_;
    std::array<cv::Mat, 2> buffers_;
    Eigen::MatrixXd covariance_;
    std::vector<double> arc_;

    TrackResult result_;
    StageTimings timings_;
    TrackObserver* observer_ = nullptr;
};

}  // namespace atropos::tracker
