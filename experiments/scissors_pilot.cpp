#include "experiments/scissors_pilot.hpp"

#include "experiments/configured_tracker.hpp"
#include "scenes/scene_file.hpp"
#include "tracker/cut_check.hpp"

namespace atropos::experiments {
using Eigen::Vector3d;
using scenes::ThreadEstimate;
using scenes::TrackStatus;
namespace {

constexpr double kLearnContrast = 0.2;
constexpr double kAnyJump_m = 0.1;

tracker::CutCheckOptions cut_check_options(const scenes::TrackerConfig& config) {
    tracker::CutCheckOptions options;
    options.width_m = config.thread.width_m;
    options.polarity = config.thread.polarity;
    options.channel = config.thread.channel;
    options.contrast_levels = config.refined.contrast_levels;
    options.instrument_sigma_m = config.refined.instrument_sigma_m;
    return options;
}

}  // namespace

robot::ScissorsOptions scissors_options(const scenes::SceneConfig& scene) {
    robot::ScissorsOptions options;
    options.place.fraction = scene.cut.fraction;
    options.tolerance_m = scene.cut.tolerance_m;
    options.sigmas = scene.cut.sigmas;
    options.max_attempts = scene.cut.max_attempts;
    if (options.sigmas == 0.0) {  // nothing is known of the tracker's error: what it says is done
        options.min_confidence = 0.0;
        options.max_jump_m = kAnyJump_m;
    }
    // RMS of the blade point in C before images help (docs/arms.md).
    switch (scene.arms.accuracy) {
        case scenes::ArmAccuracy::kPerfect:
            options.registration_sigma_m = 1e-5;
            break;
        case scenes::ArmAccuracy::kCalibrated:
            options.registration_sigma_m = 0.0031;
            break;
        case scenes::ArmAccuracy::kAsRecorded:
            options.registration_sigma_m = 0.0038;
            break;
        case scenes::ArmAccuracy::kUncalibrated:
            options.registration_sigma_m = 0.0047;
            break;
    }
    options.p_CR = scenes::scene_rig(scene.camera).X_RC.inverse().translation();
    return options;
}

ScissorsPilot::ScissorsPilot(const scenes::SceneConfig& scene, const scenes::StereoRig& rig,
                             const ArmReadings& arms, const InstrumentModels& instruments,
                             robot::PsmArm& scissors, const TrackerMaker& make_tracker)
    : scene_(scene),
      rig_(rig),
      tracker_(make_tracker ? make_tracker(rig) : make_configured_tracker(scene.tracking.tracker, rig)),
      sights_(
          make_instrument_sights(scene.arms.accuracy, rig_, instruments, scene.tracking.tracker.threads)) {
    robot::ScissorsOptions options = scissors_options(scene_);
    for (size_t end : {0, 1}) options.X_TG[end] = arms[end].psm->tool().X_TG;
    command_ = std::make_unique<robot::ScissorsCommand>(options, scissors, arms[kScissorsArm].X_CB);
}

/// Finds each instrument in the images; the tracker gets instruments and grips where they are seen.
void ScissorsPilot::look_at_instruments(tracker::StereoFrame& frame, const ArmReadings& arms) {
    const std::array<Vector3d, kArms> grips_C = add_instruments(sights_.get(), arms, frame);
    if (scene_.tracking.tips == scenes::TipSource::kNone) return;
    for (size_t end : {0, 1})
        frame.tips[end] = tracker::MeasuredTip{told_tips_C_ ? (*told_tips_C_)[end] : grips_C[end],
                                               tracker::MeasuredTip::Kind::kHeld};
}

void ScissorsPilot::remember_whole(const tracker::StereoFrame& frame, const ThreadEstimate& estimate) {
    if (status().close_time_s >= 0.0 || estimate.status != TrackStatus::kTracking) return;
    whole_.estimate = estimate;
    whole_.tips = frame.tips;
    if (status().state != robot::ScissorsState::kFollow) return;
    const double s_m = scene_.cut.fraction * estimate.length_m();
    const double levels =
        tracker::check_cut(frame, rig_, estimate, s_m, cut_check_options(scene_.tracking.tracker))
            .usual_levels;
    double& usual = whole_.contrast_levels;
    usual = usual > 0.0 ? usual + kLearnContrast * (levels - usual) : levels;
}

/// The thread as it was, carried on by its grips.
ThreadEstimate ScissorsPilot::carried(const tracker::StereoFrame& frame) const {
    ThreadEstimate expected = whole_.estimate;
    const double length_m = expected.length_m();
    for (scenes::ThreadSample& sample : expected.samples)
        for (size_t end : {0, 1}) {
            if (!frame.tips[end] || !whole_.tips[end]) continue;
            const double share = end == 0 ? 1.0 - sample.s_m / length_m : sample.s_m / length_m;
            sample.p_C += share * (frame.tips[end]->p_C - whole_.tips[end]->p_C);
        }
    return expected;
}

/// Whole is what the tracker follows through the place; cut, what passes neither there nor where a whole
/// thread would be.
std::optional<robot::CutCheck> ScissorsPilot::check_cut(const tracker::StereoFrame& frame,
                                                        const ThreadEstimate& estimate) const {
    if (status().state != robot::ScissorsState::kVerify || whole_.estimate.samples.empty())
        return std::nullopt;
    tracker::CutCheckOptions options = cut_check_options(scene_.tracking.tracker);
    options.usual_levels = whole_.contrast_levels;
    const auto verdict = [&](const ThreadEstimate& curve) {
        return tracker::check_cut(frame, rig_, curve, scene_.cut.fraction * curve.length_m(), options)
            .verdict;
    };
    using tracker::CutVerdict;
    robot::CutCheck check{frame.capture_time_s, robot::CutEvidence::kUnknown};
    const bool tracking = estimate.status == TrackStatus::kTracking;
    const CutVerdict followed = tracking ? verdict(estimate) : CutVerdict::kCut;
    if (followed == CutVerdict::kIntact) check.evidence = robot::CutEvidence::kIntact;
    if (followed == CutVerdict::kCut && verdict(carried(frame)) == CutVerdict::kCut)
        check.evidence = robot::CutEvidence::kCut;
    return check;
}

const tracker::TrackResult* ScissorsPilot::see(int frame, double time_s, const cv::Mat& left,
                                               const cv::Mat& right, const ArmReadings& arms) {
    if (status().verified == robot::CutEvidence::kCut) return nullptr;  // two threads now, neither tracked
    if (time_s + 1e-9 < next_track_s_) return nullptr;
    if (scene_.tracking.rate_hz > 0.0) next_track_s_ += 1.0 / scene_.tracking.rate_hz;
    tracker::StereoFrame f;
    f.index = frame;
    f.capture_time_s = time_s;
    f.left = left;
    f.right = right;
    look_at_instruments(f, arms);
    const tracker::TrackResult& tracked = tracker_->track(f);
    remember_whole(f, tracked.estimate);
    Message message{time_s + scene_.tracking.latency_s,
                    substitute_ ? substitute_(tracked.estimate) : tracked.estimate,
                    {},
                    check_cut(f, tracked.estimate)};
    for (int arm = 0; arm < kArms && sights_; ++arm) {
        const robot::Tool& tool = arms[static_cast<size_t>(arm)].psm->tool();
        message.offsets[static_cast<size_t>(arm)] =
            (*sights_)[arm].offset((tool.X_TS ? *tool.X_TS : tool.X_TG).translation());
    }
    under_way_.push_back(std::move(message));
    return &tracked;
}

robot::ScissorsInput ScissorsPilot::input(double time_s, const ArmReadings& arms) {
    robot::ScissorsInput input;
    input.time_s = time_s;
    input.commanded = time_s >= scene_.cut.at_s;
    arrived_.reset();
    while (!under_way_.empty() && under_way_.front().arrives_s <= time_s + 1e-9) {
        arrived_ = under_way_.front();
        under_way_.erase(under_way_.begin());
    }
    if (arrived_) {
        input.estimate = &arrived_->estimate;
        input.blade_offset = arrived_->offsets[kScissorsArm];
        for (size_t end : {0, 1}) {
            input.grip_offsets[end] = arrived_->offsets[end];
            if (arrived_->offsets[end]) offsets_C_m_[end] = arrived_->offsets[end]->offset_C_m;
        }
        input.cut_check = arrived_->cut_check;
    }
    input.scissors.value = arms[kScissorsArm].measured;
    others_C_.clear();
    for (size_t arm : {0, 1}) {
        input.holders[arm] = {arms[arm].measured};
        const Vector3d offset_C = offsets_C_m_[arm];
        for (const scenes::Capsule& c : arms[arm].capsules_C())
            others_C_.push_back({c.a + offset_C, c.b + offset_C, c.radius_m});
    }
    input.others_C = others_C_;
    return input;
}

void ScissorsPilot::step(double time_s, const ArmReadings& arms) {
    command_->step(input(time_s, arms));
}

}  // namespace atropos::experiments
