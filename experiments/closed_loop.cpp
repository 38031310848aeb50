#include "experiments/closed_loop.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/polyline.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
using Eigen::Vector3d;
using scenes::CutController;
using scenes::ThreadEstimate;
using scenes::TrackStatus;
namespace {

constexpr double kAfter_s = 0.5;  ///< the run goes on this long after the command has finished
constexpr int kEstimateSamples = 101;

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
    switch (scene.arms.accuracy) {
        case scenes::ArmAccuracy::kPerfect:
            options.registration_sigma_m = 0.0;
            break;
        case scenes::ArmAccuracy::kUncalibrated:
            options.registration_sigma_m = 0.004;
            break;
        case scenes::ArmAccuracy::kCalibrated:
        case scenes::ArmAccuracy::kAsRecorded:
            break;
    }
    options.p_CR = scenes::scene_rig(scene.camera).X_RC.inverse().translation();
    return options;
}

ClosedLoop::ClosedLoop(const scenes::SceneConfig& scene)
    : scene_(scene),
      testbed_(scene),
      endoscope_(testbed_),
      tracker_(tracker::make_tracker(scene.tracking.tracker, testbed_.rig())) {
    robot::ScissorsOptions options = scissors_options(scene_);
    for (int end : {0, 1}) options.X_TG[static_cast<size_t>(end)] = testbed_.arm(end).psm().tool().X_TG;
    robot::RobotArm& arm = testbed_.arm(kScissorsArm);
    command_ = std::make_unique<robot::ScissorsCommand>(options, arm.controller(), arm.X_CB());
}

ClosedLoop::~ClosedLoop() = default;

long ClosedLoop::frames() const {
    return static_cast<long>(std::floor(scene_.duration_s * scene_.camera.fps_hz));
}

tracker::StereoFrame ClosedLoop::tracker_frame(int frame, const View& view) const {
    tracker::StereoFrame f;
    f.index = frame;
    f.capture_time_s = testbed_.time_s();
    f.left = view.left;
    f.right = view.right;
    if (scene_.tracking.tips != scenes::TipSource::kNone)
        for (int end : {0, 1}) {
            const bool exact = scene_.tracking.tips == scenes::TipSource::kExact;
            f.tips[static_cast<size_t>(end)] =
                tracker::MeasuredTip{exact ? testbed_.true_grip_C(end) : testbed_.measured_grip_C(end),
                                     tracker::MeasuredTip::Kind::kHeld};
        }
    for (int arm = 0; arm < kArms; ++arm) {
        const auto capsules = testbed_.arm(arm).measured_capsules_C();
        f.instruments.insert(f.instruments.end(), capsules.value.begin(), capsules.value.end());
    }
    return f;
}

/// Hands an estimate to the command after the tracker's latency, or what a null controller puts in its place.
void ClosedLoop::deliver(const ThreadEstimate& estimate) {
    const double now = testbed_.time_s();
    ThreadEstimate delivered = estimate;
    switch (scene_.cut.controller) {
        case CutController::kTracker:
            break;
        case CutController::kChord:
            delivered = certain({{testbed_.measured_grip_C(0), testbed_.measured_grip_C(1)}}, now);
            break;
        case CutController::kFrozen:
            if (!frozen_ && now >= scene_.cut.at_s && estimate.status == TrackStatus::kTracking)
                frozen_ = estimate;
            if (frozen_) delivered = *frozen_;
            delivered.capture_time_s = now;
            break;
        case CutController::kTruth: {
            scenes::Polyline span;
            for (const TruthSample& s : truth_samples(testbed_.thread(), testbed_.X_WC().inverse()))
                if (s.in_span) span.points.push_back(s.p_C);
            if (span.points.size() < 2)
                delivered = ThreadEstimate{};
            else
                delivered = certain(span, now);
            break;
        }
    }
    pending_.push_back({now + scene_.tracking.latency_s, delivered});
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
        tracked = &tracker_->track(tracker_frame(frame, *view));
        deliver(tracked->estimate);
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
        arrived_ = pending_.front().estimate;
        pending_.erase(pending_.begin());
    }
    input.estimate = arrived_ ? &*arrived_ : nullptr;
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
