#include "robot/thread_predictor.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "robot/offset_filter.hpp"

namespace atropos::robot {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Of a thread that hangs between moving grips, measured over seeds of the default scene and the fast one:
// beside what the response to the grips explains, the middle moves with 0.03 to 0.2 m/s^2, across the thread
// and along it: it swings to and fro as a whole.
constexpr MotionFilter::Options kRelative{0.04, 0.3, 0.005, 0.1, 25.0, 0.4, 20.0};
constexpr MotionFilter::Options kGrips{0.10, 0.2, 0.05};
constexpr double kTangentReach_m = 0.004;  // half of the chord that gives the tangent
constexpr double kTangentMemory = 0.3;     // share of a new tangent
constexpr double kGripSigma_m = 2e-5;      // of measured motion over a few tenths of a second
// Squared, three degrees of freedom: one in a million; one in thirty.
constexpr double kMaxSurprise = 30.0, kWarySurprise = 9.0;
constexpr double kModelSigma_m = 3e-4;  // no innovation below this is a jump
// What a tracker's sigmas leave out: along the thread a point is known by the ends alone.
constexpr double kSlideSigma_m = 1.5e-4, kJitterSigma_m = 1.5e-4;
constexpr double kSwing_m_s = 0.010;  // of the thread against its grips, where no frames came
constexpr double kLongestUnseen_s = 0.5;
// The thread's motion against its grips is a swing: what it does now says nothing of where it is a little
// later.
constexpr double kLongestExtrapolation_s = 0.15;
constexpr double kBelieveJumpAfter_s = 0.3;

// Point at arc length s: samples come at equal steps.
Vector3d point_at(const std::vector<scenes::ThreadSample>& samples, double s_m) {
    const double last = static_cast<double>(samples.size() - 1);
    const double u = std::clamp(s_m / samples.back().s_m * last, 0.0, last);
    const auto i = std::min(static_cast<size_t>(u), samples.size() - 2);
    const double share = u - static_cast<double>(i);
    return (1.0 - share) * samples[i].p_C + share * samples[i + 1].p_C;
}

template <class... Values>
std::string text(const char* format, Values... values) {
    char line[160];
    std::snprintf(line, sizeof line, format, values...);
    return line;
}

}  // namespace

double cut_arc_length_m(const CutPlace& place, double length_m) {
    const double s = place.from_end0_m   ? *place.from_end0_m
                     : place.from_end1_m ? length_m - *place.from_end1_m
                                         : place.fraction * length_m;
    return std::clamp(s, 0.0, length_m);
}

ThreadPredictor::ThreadPredictor(const ScissorsOptions& options)
    : options_(options), relative_(kRelative), grips_(kGrips), spread_(kGrips) {}

void ThreadPredictor::forget() {
    relative_ = MotionFilter(kRelative);
    jumped_since_s_ = -1.0;
}

void ThreadPredictor::observe_grips(const ScissorsInput& input) {
    for (size_t end = 0; end < 2; ++end) {
        grip_points_[end].reset();
        if (!input.holders[end]) continue;
        grip_points_[end] = (input.holders[end]->value.X_CT * options_.X_TG[end]).translation();
        if (input.grip_offsets[end]) *grip_points_[end] += input.grip_offsets[end]->offset_C_m;
    }
    if (weight_ < 0.0 || (!input.holders[0] && !input.holders[1])) return;
    double time_s = 1e18;
    Vector3d p = Vector3d::Zero();
    for (size_t end = 0; end < 2; ++end) {
        if (!input.holders[end]) continue;
        const ArmState& state = input.holders[end]->value;
        time_s = std::min(time_s, state.time_s);
        p += (end == 1 ? weight_ : 1.0 - weight_) * (state.X_CT * options_.X_TG[end]).translation();
    }
    if (count_ > 0 && time_s < history_[head_].time_s + kGripPeriod_s) return;
    Vector3d apart = Vector3d::Zero();
    if (grip_points_[0] && grip_points_[1]) {
        for (size_t end = 0; end < 2; ++end)
            apart +=
                (end == 1 ? 1.0 : -1.0) * (input.holders[end]->value.X_CT * options_.X_TG[end]).translation();
    }
    remember({time_s, p, apart});
}

void ThreadPredictor::remember(const GripSample& grips) {
    head_ = (head_ + 1) % kHistory;
    count_ = std::min(count_ + 1, kHistory);
    history_[head_] = grips;
    const Matrix3d R = kGripSigma_m * kGripSigma_m * Matrix3d::Identity();
    const auto follow = [&](MotionFilter& filter, const Vector3d& p) {
        if (filter.started())
            filter.update(grips.time_s, p, R);
        else
            filter.start(grips.time_s, p, R);
    };
    follow(grips_, grips.p);
    follow(spread_, grips.apart);
}

ThreadPredictor::GripSample ThreadPredictor::grips_at(double time_s) const {
    if (count_ == 0) return {time_s, Vector3d::Zero(), Vector3d::Zero()};
    const GripSample& newest = history_[head_];
    if (time_s >= newest.time_s) return {time_s, grips_.at(time_s).p, spread_.at(time_s).p};
    for (size_t age = 1; age < count_; ++age) {
        const GripSample &before = past(age), &after = past(age - 1);
        if (before.time_s > time_s) continue;
        const double share = (time_s - before.time_s) / (after.time_s - before.time_s);
        return {time_s, (1.0 - share) * before.p + share * after.p,
                (1.0 - share) * before.apart + share * after.apart};
    }
    return past(count_ - 1);
}

ThreadPredictor::Verdict ThreadPredictor::refuse(Verdict verdict, std::string why) {
    rejection_ = std::move(why);
    return verdict;
}

bool ThreadPredictor::ends_at_grips(const scenes::ThreadEstimate& estimate) {
    for (size_t end = 0; end < 2; ++end) {
        if (!grip_points_[end]) continue;
        const auto& sample = end == 0 ? estimate.samples.front() : estimate.samples.back();
        const double gap = (sample.p_C - *grip_points_[end]).norm();
        if (gap <= options_.max_end_gap_m) continue;
        rejection_ =
            text("end %zu of the tracked thread is %.1f mm from the jaws that hold it, expected at most %.1f",
                 end, 1e3 * gap, 1e3 * options_.max_end_gap_m);
        return false;
    }
    return true;
}

bool ThreadPredictor::plausible(const scenes::ThreadEstimate& estimate) {
    if (!ends_at_grips(estimate)) return false;
    const double length = estimate.length_m();
    if (length_m_ > 0.0 && std::abs(length / length_m_ - 1.0) > options_.max_length_change) {
        rejection_ = text("the tracked span is %.1f mm long, expected %.1f", 1e3 * length, 1e3 * length_m_);
        return false;
    }
    return true;
}

ThreadPredictor::Verdict ThreadPredictor::observe(const scenes::ThreadEstimate& estimate, Trust trust) {
    const double now = estimate.capture_time_s;
    if (now <= last_capture_s_) return refuse(Verdict::kUnusable, "estimates out of order");
    const double unseen_s = std::min(now - last_capture_s_, kLongestUnseen_s);
    last_capture_s_ = now;
    if (estimate.status != scenes::TrackStatus::kTracking)
        return refuse(Verdict::kUnusable, std::string("tracker ") + scenes::to_string(estimate.status));
    if (estimate.confidence < options_.min_confidence)
        return refuse(Verdict::kUnusable, text("tracker's confidence %.2f, expected %.2f",
                                               estimate.confidence, options_.min_confidence));
    const bool finite = std::all_of(estimate.samples.begin(), estimate.samples.end(), [](const auto& sample) {
        return sample.p_C.allFinite() && sample.sigma_lateral_m >= 0.0 && sample.sigma_depth_m >= 0.0;
    });
    if (estimate.samples.size() < 2 || !finite || !(estimate.length_m() > 2.0 * kTangentReach_m))
        return refuse(Verdict::kUnusable, "tracker gave no curve");
    if (!plausible(estimate)) return Verdict::kImplausible;

    const double length = estimate.length_m(), s = cut_arc_length_m(options_.place, length);
    if (weight_ < 0.0) {
        weight_ = s / length;
        return refuse(Verdict::kUnusable, "first sight");  // from now on the grips are recorded
    }
    const Vector3d p = point_at(estimate.samples, s);
    const auto nearest =
        static_cast<size_t>(s / length * static_cast<double>(estimate.samples.size() - 1) + 0.5);
    const auto& sample = estimate.samples[nearest];
    const Vector3d along =
        (point_at(estimate.samples, s + kTangentReach_m) - point_at(estimate.samples, s - kTangentReach_m))
            .normalized();
    const GripSample grips = grips_at(now);
    const Vector3d relative = p - grips.p;
    Matrix3d R = ray_covariance(p, sample.sigma_lateral_m, sample.sigma_depth_m) +
                 kJitterSigma_m * kJitterSigma_m * Matrix3d::Identity();
    R += kSlideSigma_m * kSlideSigma_m * along * along.transpose();
    if (relative_.started()) {
        const Matrix3d wide = R + kModelSigma_m * kModelSigma_m * Matrix3d::Identity();
        // From where it was seen last, not from where a velocity that ran away would put it.
        const Vector3d moved = relative - relative_.at(relative_.time_s(), drive(grips)).p;
        const double jump = (moved - along.dot(moved) * along).norm();
        const bool surprising = relative_.surprise(now, relative, wide, drive(grips)) >
                                (trust == Trust::kWary ? kWarySurprise : kMaxSurprise);
        if (surprising && jumped_since_s_ < 0.0) jumped_since_s_ = now;
        // However long the thread was out of sight, the grips tell too much for it to be elsewhere.
        if (jump > options_.max_jump_m + kSwing_m_s * unseen_s ||
            (surprising && now - jumped_since_s_ <= kBelieveJumpAfter_s))
            return refuse(Verdict::kJumped, text("the estimate jumped by %.1f mm", 1e3 * jump));
        if (surprising) forget();
    }
    jumped_since_s_ = -1.0;
    const double share = relative_.started() ? kTangentMemory : 1.0;
    tangent_ = ((1.0 - share) * tangent_ + share * along).normalized();
    length_m_ = length_m_ > 0.0 ? 0.98 * length_m_ + 0.02 * length : length;
    if (relative_.started())
        relative_.update(now, relative, R + kGripSigma_m * kGripSigma_m * Matrix3d::Identity(), drive(grips));
    else {
        relative_.start(now, relative, R);
        apart_ = grips.apart;
    }
    tracking_ = relative_.at(now, drive(grips)).known;
    samples_.assign(estimate.samples.begin(), estimate.samples.end());
    rejection_.clear();
    return Verdict::kUsed;
}

ThreadPrediction ThreadPredictor::at(double time_s) const {
    const double farthest = relative_.time_s() + kLongestExtrapolation_s;
    const GripSample grips = grips_at(time_s);
    const MotionFilter::State relative = relative_.at(std::min(time_s, farthest), drive(grips));
    ThreadPrediction prediction;
    prediction.p_C = relative.p + grips.p;
    if (time_s < farthest) prediction.v_C = relative.v;
    if (grips_.started()) prediction.v_C += grips_.at(time_s).v + relative.R * spread_.at(time_s).v;
    prediction.tangent_C = tangent_;
    prediction.tracking = tracking_;
    return prediction;
}

Matrix3d ThreadPredictor::growth(double now_s, double closing_s) const {
    Matrix3d growth = relative_.at(now_s + closing_s, drive(grips_at(now_s))).growth;
    if (grips_.started()) growth += grips_.at(now_s).growth;
    return growth;
}

}  // namespace atropos::robot
