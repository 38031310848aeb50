#include "experiments/closed_loop.hpp"

#include <cmath>

#include "scenes/polyline.hpp"

namespace atropos::experiments {
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

ArmReadings read_all(const Testbed& testbed) {
    return {read(testbed.arm(0)), read(testbed.arm(1)), read(testbed.arm(2))};
}

}  // namespace

ClosedLoop::ClosedLoop(const scenes::SceneConfig& scene, const TrackerMaker& make_tracker)
    : scene_(scene),
      testbed_(scene),
      endoscope_(testbed_),
      pilot_(scene, testbed_.told_rig(), read_all(testbed_), endoscope_.instruments(),
             testbed_.arm(kScissorsArm).controller(), make_tracker) {
    if (testbed_.is_knotted())
        throw std::invalid_argument("arms.PSM1 holds nothing, expected the thread's start in a closed loop");
    if (scene_.cut.controller != CutController::kTracker)
        pilot_.substitute([this](const ThreadEstimate& estimate) { return substituted(estimate); });
}

long ClosedLoop::frames() const {
    return static_cast<long>(std::floor(scene_.duration_s * scene_.camera.fps_hz));
}

/// What a null controller puts in the place of the tracker's estimate.
ThreadEstimate ClosedLoop::substituted(const ThreadEstimate& estimate) {
    const double now = testbed_.time_s();
    switch (scene_.cut.controller) {
        case CutController::kTracker:
            return estimate;
        case CutController::kChord:
            return certain({{testbed_.measured_grip_C(0), testbed_.measured_grip_C(1)}}, now);
        case CutController::kFrozen: {
            if (!frozen_ && now >= scene_.cut.at_s && estimate.status == TrackStatus::kTracking)
                frozen_ = estimate;
            ThreadEstimate result = frozen_ ? *frozen_ : estimate;
            result.capture_time_s = now;
            return result;
        }
        case CutController::kTruth: {
            scenes::Polyline span;
            for (const TruthSample& s : truth_samples(testbed_.thread(), testbed_.X_WC().inverse()))
                if (s.in_span) span.points.push_back(s.p_C);
            return span.points.size() < 2 ? ThreadEstimate{} : certain(span, now);
        }
    }
    return estimate;
}

void ClosedLoop::look(int frame, const Observer& observer) {
    std::optional<View> view;
    {
        const auto lap = clock_.lap("rendering");
        view = endoscope_.capture(testbed_, frame);
    }
    if (scene_.tracking.tips == scenes::TipSource::kExact)
        pilot_.tell_tips({testbed_.true_grip_C(0), testbed_.true_grip_C(1)});
    const tracker::TrackResult* tracked = nullptr;
    {
        const auto lap = clock_.lap("tracking");
        tracked = pilot_.see(frame, testbed_.time_s(), view->left, view->right, read_all(testbed_));
    }
    const auto lap = clock_.lap("output");
    observer({frame, *view, tracked, pilot_.status()});
}

void ClosedLoop::run(const Observer& observer, const TickObserver& tick_observer) {
    const auto ticks = std::lround(1e3 * scene_.duration_s);
    double finished_s = -1.0;
    int frame = 0;
    for (long tick = 0; tick < ticks; ++tick) {
        if (tick == std::lround(1e3 * frame / scene_.camera.fps_hz)) look(frame++, observer);
        {
            const auto lap = clock_.lap("command");
            const ArmReadings arms = read_all(testbed_);
            pilot_.step(testbed_.time_s(), arms);
            if (tick_observer)
                tick_observer({testbed_.time_s(), arms, testbed_.arm(kScissorsArm).controller()});
        }
        const auto lap = clock_.lap("simulation");
        testbed_.tick();
        if (pilot_.status().finished && finished_s < 0.0) finished_s = testbed_.time_s();
        if (finished_s >= 0.0 && testbed_.time_s() >= finished_s + kAfter_s) break;
    }
}

}  // namespace atropos::experiments
