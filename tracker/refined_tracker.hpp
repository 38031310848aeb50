#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "tracker/curve_refinement.hpp"
#include "tracker/end_belief.hpp"
#include "tracker/grip_sight.hpp"
#include "tracker/loss_test.hpp"
#include "tracker/recovery.hpp"
#include "tracker/stereo_tracker.hpp"
#include "tracker/valley_association.hpp"
#include "tracker/valley_filter.hpp"

namespace atropos::tracker {

/// Tracks by continuous refinement: predict, look across the predicted curve for the thread in both eyes, fit
/// curve and length to what was found, look closer, fit again. A local loss test guards the result; only when
/// it fails is the paper's discrete search run (recovery). The estimate carries its own uncertainty.
class RefinedTracker final : public StereoTracker {
  public:
    RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig);
    RefinedTracker(const scenes::TrackerConfig& config, const scenes::StereoRig& rig,
                   const CurvePriors& priors);
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
        double search_px;
        double robust_px;
        int iterations;
        double threshold_share;
        bool closely;
    };

    void begin(const NurbsCurve& initial);
    Eigen::Matrix3Xd control_points_of(const NurbsCurve& curve) const;
    NurbsCurve curve_of(const Eigen::Matrix3Xd& Q) const;
    void predict(const StereoFrame& frame);
    void refine(const StereoFrame& frame, double first_search_px, Fit& fit);
    void place_instruments(const StereoFrame& frame);
    void expect_ends(const StereoFrame& frame);
    void look_at_grips(const StereoFrame& frame, const Fit& fit);
    void learn_ends(const StereoFrame& frame);
    void measure(const Fit& fit, const Round& round);
    void measure_eye(const Fit& fit, std::size_t eye, const Round& round);
    void localise(std::size_t eye);
    void recover(const StereoFrame& frame);
    bool start_from_tips(const StereoFrame& frame);
    void try_fit(const StereoFrame& frame, const NurbsCurve& curve, Fit& best);
    void learn();
    void conclude(const StereoFrame& frame);
    void fill_estimate(const StereoFrame& frame);
    void show(std::string_view stage, const Eigen::Matrix3Xd& Q);
    const TrackResult& lost(const StereoFrame& frame);

    scenes::TrackerConfig config_;
    scenes::StereoRig rig_;
    double scale_;  ///< image width over 640
    CurveRefinement refinement_;
    ValleyFilter filter_;
    ValleyAssociation association_;
    LossTestOptions loss_test_;
    Recovery recovery_;
    GripSight grip_sight_;

    // What passes from frame to frame.
    bool started_ = false;
    bool confirmed_ = false;  ///< a curve between measured ends that the images bear out
    scenes::TrackStatus status_ = scenes::TrackStatus::kLost;
    int frames_unseen_ = 0;
    double capture_time_s_ = 0.0;
    Fit fit_;
    Eigen::Matrix3Xd velocity_m_s_;  ///< of the control points, beyond what the ends' motion explains
    double expected_length_m_ = 0.0;
    double expected_length_sigma_m_ = 0.0;
    std::array<std::optional<Eigen::Vector3d>, 2> last_tips_C_;
    std::array<std::vector<double>, 2> expected_depth_levels_;
    std::array<EndBelief, 2> ends_;

    // Working memory of one frame.
    Eigen::Matrix3Xd expected_;
    CurveProblem problem_;
    Fit trial_;
    Fit other_;
    CurveProblem chosen_problem_;
    std::vector<scenes::Capsule> instruments_C_;
    std::array<UncertainPoint, 2> expected_ends_;
    std::array<std::optional<GripSighting>, 2> grips_;
    std::array<ImageView, 2> images_;
    std::array<cv::Mat, 2> buffers_;
    std::vector<ValleyCandidates> candidates_;
    std::vector<NormalLine> lines_;
    std::vector<double> widths_px_;
    std::vector<double> noises_;
    Eigen::MatrixXd covariance_;
    std::vector<double> arc_;

    TrackResult result_;
    StageTimings timings_;
    TrackObserver* observer_ = nullptr;
};

}  // namespace atropos::tracker
