#include "experiments/closed_loop.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/polyline.hpp"
#include "scenes/scene_file.hpp"
#include "tracker/cut_check.hpp"

namespace atropos::experiments {
using Eigen::Vector3d;
using scenes::CutController;
using scenes::ThreadEstimate;
using scenes::TrackStatus;
namespace {

constexpr double kAfter_s = 0.5;  ///< the run goes on this long after the command has finished
constexpr int kEstimateSamples = 101;
// One sigma of a tip's error in each axis without the wrist's play: hand-eye and the first three joints.
constexpr double kCalibratedShift_m = 0.0008, kUncalibratedShift_m = 0.0022;

/// An estimate that claims to be sure of a curve in C: for the null controllers.
ThreadEstimate certain(const scenes::Polyline& curve_C, double time_s) {
    ThreadEstimate estimate;
    estimate.capture_time_s = time_s;
    estimate.status = TrackStatus::kTracking;
    estimate.confidence = 1.0;
    const scenes::Polyline even = curve_C.resampled(kEstimateSamples);
    const double length = curve_C.length_m();
    for (int i = 0; i < kEstimateSamples; ++i)
        estimate.samples.push_back(
            {length * i / (kEstimateSamples - 1), even.points[static_cast<size_t>(i)], 1e-4, 1e-4});
    return estimate;
}

}  // namespace

robot::ScissorsOptions scissors_options(const scenes::SceneConfig& scene) {
    robot::ScissorsOptions options;
    options.place.fraction = scene.cut.fraction;
    options.tolerance_m = scene.cut.tolerance_m;
    options.max_attempts = scene.cut.max_attempts;
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

ClosedLoop::ClosedLoop(const scenes::SceneConfig& scene, const TrackerMaker& make_tracker)
    : scene_(scene),
      testbed_(scene),
      endoscope_(testbed_),
      tracker_(make_tracker ? make_tracker(testbed_.rig())
                            : tracker::make_tracker(scene.tracking.tracker, testbed_.rig())) {
    robot::ScissorsOptions options = scissors_options(scene_);
    for (int end : {0, 1}) options.X_TG[static_cast<size_t>(end)] = testbed_.arm(end).psm().tool().X_TG;
    robot::RobotArm& arm = testbed_.arm(kScissorsArm);
    if (scene_.arms.accuracy != scenes::ArmAccuracy::kPerfect) {
        const SightPrior prior{scene_.arms.accuracy == scenes::ArmAccuracy::kUncalibrated
                                   ? kUncalibratedShift_m
                                   : kCalibratedShift_m,
                               robot::Imperfection::of(scene_.arms.accuracy).play};
        std::vector<InstrumentSight> sights;
        for (int i = 0; i < kArms; ++i) sights.emplace_back(endoscope_.instrument(i), prior);
        sights_ = std::make_unique<InstrumentSights>(testbed_.rig(), std::move(sights));
    }
    command_ = std::make_unique<robot::ScissorsCommand>(options, arm.controller(), arm.X_CB());
}

ClosedLoop::~ClosedLoop() = default;

long ClosedLoop::frames() const {
    return static_cast<long>(std::floor(scene_.duration_s * scene_.camera.fps_hz));
}

tracker::StereoFrame ClosedLoop::tracker_frame(int frame, const View& view) {
    tracker::StereoFrame f;
    f.index = frame;
    f.capture_time_s = testbed_.time_s();
    f.left = view.left;
    f.right = view.right;
    look_at_instruments(f);
    if (scene_.tracking.tips == scenes::TipSource::kNone) return f;
    for (int end : {0, 1}) {
        const Vector3d seen = seen_grip_C(end);
        const bool exact = scene_.tracking.tips == scenes::TipSource::kExact;
        f.tips[static_cast<size_t>(end)] =
            tracker::MeasuredTip{exact ? testbed_.true_grip_C(end) : seen, tracker::MeasuredTip::Kind::kHeld};
    }
    return f;
}

/// Finds each instrument in the images; the tracker gets them where they are seen.
void ClosedLoop::look_at_instruments(tracker::StereoFrame& frame) {
    if (sights_) {
        std::vector<const robot::RobotArm*> arms;
        for (int arm = 0; arm < kArms; ++arm) arms.push_back(&testbed_.arm(arm));
        sights_->look(frame.left, frame.right, arms);
    }
    for (int arm = 0; arm < kArms; ++arm) {
        const auto capsules =
            sights_ ? (*sights_)[arm].capsules_C() : testbed_.arm(arm).measured_capsules_C().value;
        frame.instruments.insert(frame.instruments.end(), capsules.begin(), capsules.end());
    }
}

Vector3d ClosedLoop::seen_grip_C(int end) const {
    if (!sights_) return testbed_.measured_grip_C(end);
    return (*sights_)[end].X_CT() * testbed_.arm(end).psm().tool().X_TG.translation();
}

std::optional<robot::CutCheck> ClosedLoop::check_cut(const tracker::StereoFrame& frame) {
    if (command_->status().state != robot::ScissorsState::kVerify || before_close_.samples.empty())
        return std::nullopt;
    tracker::CutCheckOptions options;
    const scenes::TrackerConfig& config = scene_.tracking.tracker;
    options.width_m = config.thread.width_m;
    options.polarity = config.thread.polarity;
    options.channel = config.thread.channel;
    options.contrast_levels = config.refined.contrast_levels;
    options.instrument_sigma_m = config.refined.instrument_sigma_m;
    const double s_m = scene_.cut.fraction * before_close_.length_m();
    const tracker::CutCheck seen = tracker::check_cut(frame, testbed_.rig(), before_close_, s_m, options);
    const robot::CutEvidence evidence = seen.verdict == tracker::CutVerdict::kCut ? robot::CutEvidence::kCut
                                        : seen.verdict == tracker::CutVerdict::kIntact
                                            ? robot::CutEvidence::kIntact
                                            : robot::CutEvidence::kUnknown;
    return robot::CutCheck{frame.capture_time_s, evidence};
}

/// The tracker's estimate, or what a null controller puts in its place.
ThreadEstimate ClosedLoop::delivered(const ThreadEstimate& estimate) {
    const double now = testbed_.time_s();
    ThreadEstimate result = estimate;
    switch (scene_.cut.controller) {
        case CutController::kTracker:
            break;
        case CutController::kChord:
            result = certain({{testbed_.measured_grip_C(0), testbed_.measured_grip_C(1)}}, now);
            break;
        case CutController::kFrozen:
            if (!frozen_ && now >= scene_.cut.at_s && estimate.status == TrackStatus::kTracking)
                frozen_ = estimate;
            if (frozen_) result = *frozen_;
            result.capture_time_s = now;
            break;
        case CutController::kTruth: {
            scenes::Polyline span;
            for (const TruthSample& s : truth_samples(testbed_.thread(), testbed_.X_WC().inverse()))
                if (s.in_span) span.points.push_back(s.p_C);
            if (span.points.size() < 2)
                result = ThreadEstimate{};
            else
                result = certain(span, now);
            break;
        }
    }
    return result;
}

void ClosedLoop::look(int frame, const Observer& observer) {
    std::optional<View> view;
    {
        const auto lap = clock_.lap("rendering");
        view = endoscope_.capture(testbed_, frame);
    }
    const tracker::TrackResult* tracked = nullptr;
    const double now = testbed_.time_s();
    if (now + 1e-9 >= next_track_s_) {
        if (scene_.tracking.rate_hz > 0.0) next_track_s_ += 1.0 / scene_.tracking.rate_hz;
        const auto lap = clock_.lap("tracking");
        const tracker::StereoFrame f = tracker_frame(frame, *view);
        tracked = &tracker_->track(f);
        if (command_->status().close_time_s < 0.0) before_close_ = tracked->estimate;
        Pending pending{now + scene_.tracking.latency_s, delivered(tracked->estimate), {}, check_cut(f)};
        for (int arm = 0; arm < kArms && sights_; ++arm) {
            const robot::Tool& tool = testbed_.arm(arm).psm().tool();
            pending.offsets[static_cast<size_t>(arm)] =
                (*sights_)[arm].offset((tool.X_TS ? *tool.X_TS : tool.X_TG).translation());
        }
        pending_.push_back(std::move(pending));
    }
    const auto lap = clock_.lap("output");
    observer({frame, *view, tracked, command_->status()});
}

robot::ScissorsInput ClosedLoop::scissors_input() {
    robot::ScissorsInput input;
    input.time_s = testbed_.time_s();
    input.commanded = input.time_s >= scene_.cut.at_s;
    arrived_.reset();
    while (!pending_.empty() && pending_.front().arrives_s <= input.time_s + 1e-9) {
        arrived_ = pending_.front();
        pending_.erase(pending_.begin());
    }
    if (arrived_) {
        input.estimate = &arrived_->estimate;
        input.blade_offset = arrived_->offsets[kScissorsArm];
        for (size_t end : {0, 1}) input.grip_offsets[end] = arrived_->offsets[end];
        input.cut_check = arrived_->cut_check;
    }
    input.scissors = testbed_.arm(kScissorsArm).measured();
    others_C_.clear();
    for (int arm : {0, 1}) {
        input.holders[static_cast<size_t>(arm)] = testbed_.arm(arm).measured();
        const auto capsules = testbed_.arm(arm).measured_capsules_C();
        others_C_.insert(others_C_.end(), capsules.value.begin(), capsules.value.end());
    }
    input.others_C = others_C_;
    return input;
}

void ClosedLoop::run(const Observer& observer) {
    const auto ticks = std::lround(1e3 * scene_.duration_s);
    double finished_s = -1.0;
    int frame = 0;
    for (long tick = 0; tick < ticks; ++tick) {
        if (tick == std::lround(1e3 * frame / scene_.camera.fps_hz)) look(frame++, observer);
        {
            const auto lap = clock_.lap("command");
            command_->step(scissors_input());
        }
        const auto lap = clock_.lap("simulation");
        testbed_.tick();
        if (command_->status().finished && finished_s < 0.0) finished_s = testbed_.time_s();
        if (finished_s >= 0.0 && testbed_.time_s() >= finished_s + kAfter_s) break;
    }
}

}  // namespace atropos::experiments
