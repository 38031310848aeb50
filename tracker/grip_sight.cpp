#include "tracker/grip_sight.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "tracker/occlusion_mask.hpp"

namespace atropos::tracker {
namespace {

constexpr double kStep_m = 0.0001;
constexpr double kInside_m = 0.009;
constexpr double kOutside_m = 0.006;
constexpr int kPoints = 151;
constexpr int kEnd = 90;      ///< index of the curve's end
constexpr int kLeastGap = 8;  ///< steps
constexpr int kMargin = 15;   ///< steps before an edge that are looked at
constexpr double kLeastTail_m = 0.0007;
constexpr double kMostTail = 4.0;  ///< log odds: a long tail tells no more of where it begins
constexpr double kWider_m = 0.0005;
constexpr double kMostSlope = 2.2;
constexpr double kOdds = 0.25;  ///< log odds of "visible" a step, where the thread is seen fully
constexpr double kEdgeSigma_m = 0.00015;
constexpr double kFreeSigma_m = 0.0003;    ///< of an end with nothing about it
constexpr double kFarSigma_m = 0.002;      ///< of one that lies still further on
constexpr double kShapeSigma_m = 0.00025;  ///< an outline that is not that of the capsules, lopsided

double at(int index) {
    return (index - kEnd) * kStep_m;
}

}  // namespace

GripSight::GripSight(const scenes::StereoRig& rig, const ValleyFilterOptions& filter, double thread_width_m)
    : rig_(rig),
      filter_([&filter] {
          ValleyFilterOptions sharp = filter;  // edges along the thread must not be smeared
          sharp.taps = 3;
          return sharp;
      }()),
      thread_width_m_(thread_width_m),
      threshold_levels_(filter.threshold_levels),
      path_C_(kPoints),
      tangent_C_(kPoints),
      depth_levels_(kPoints),
      sum_(kPoints + 1),
      tail_(kPoints + 1) {
    sorted_.reserve(kPoints);
}

// The curve from inside up to its end, and straight on.
void GripSight::follow(const CubicBasis& basis, const Eigen::Matrix3Xd& Q, double length_m, std::size_t end) {
    for (int i = 0; i < kPoints; ++i) {
        const double inside = std::min(std::max(-at(i) / length_m, 0.0), 1.0);
        const CubicBasisValues place = basis.at(end == 0 ? inside : 1.0 - inside);
        const std::size_t j = static_cast<std::size_t>(i);
        tangent_C_[j] = (end == 0 ? -1.0 : 1.0) * place.tangent(Q).normalized();
        path_C_[j] = place.point(Q) + std::max(at(i), 0.0) * tangent_C_[j];
    }
}

// The hidden stretch about the end, and by how much its borders would move if the jaws were wider.
GripSight::Outline GripSight::predict(const Eigen::Vector3d& eye_C,
                                      std::span<const scenes::Capsule> jaws_C) const {
    const auto stretch = [&](double margin_m) {
        const OcclusionMask mask(jaws_C, eye_C, margin_m, 0.0);
        const auto hidden = [&](int i) { return mask.hides(path_C_[static_cast<std::size_t>(i)]); };
        int inner = kEnd, outer = kEnd;
        if (!hidden(kEnd)) return std::pair(0, kPoints);
        while (inner > 0 && hidden(inner - 1)) --inner;
        while (outer < kPoints && hidden(outer)) ++outer;
        return std::pair(inner, outer);
    };
    const auto [inner, outer] = stretch(0.0);
    const auto [wider_inner, wider_outer] = stretch(kWider_m);
    Outline outline;
    const auto border = [](int index, int wider) -> std::optional<Border> {
        // An outline that runs along the thread is no mark on it.
        const double slope = std::max(std::abs(wider - index) * kStep_m / kWider_m, 1.0);
        if (slope > kMostSlope) return std::nullopt;
        return Border{at(index) - 0.5 * kStep_m, slope};
    };
    if (wider_inner > 0) outline.inner = border(inner, wider_inner);
    if (wider_outer < kPoints) outline.outer = border(outer, wider_outer);
    return outline;
}

// How deep a valley is seen at each place of the path, and what that says for and against its being visible.
void GripSight::weigh(const ImageView& image, std::size_t eye, std::span<const scenes::Capsule> others_C) {
    const scenes::Camera& camera = eye == 0 ? rig_.left : rig_.right;
    const Eigen::Vector3d eye_C =
        eye == 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(rig_.X_RC.inverse().translation());
    const OcclusionMask mask(others_C, eye_C, 0.001, 0.003);
    const double scale = camera.width_px / 640.0;
    sorted_.clear();
    for (std::size_t i = 0; i < path_C_.size(); ++i) {
        depth_levels_[i] = -1.0;
        const Eigen::Vector3d p = eye == 0 ? path_C_[i] : Eigen::Vector3d(rig_.X_RC * path_C_[i]);
        const Eigen::Vector3d t = eye == 0 ? tangent_C_[i] : rig_.X_RC.linear() * tangent_C_[i];
        if (p.z() < 0.005 || mask.hides(path_C_[i])) continue;
        Eigen::Matrix<double, 2, 3> J_px;
        NormalLine line;
        line.p_px = camera.project(p, J_px);
        const Eigen::Vector2d along = J_px * t;
        // Seen nearly end on, a place along the thread is no place in the image.
        if (!camera.contains(line.p_px) || along.norm() < 0.4 * camera.fx_px / p.z()) continue;
        line.tangent = along.normalized();
        line.normal = {-line.tangent.y(), line.tangent.x()};
        // The tail goes its own way.
        const double beyond_px = std::max(0.0, at(static_cast<int>(i))) * camera.fx_px / p.z();
        std::array<Valley, ValleyFilter::kMaxValleys> valleys;
        const int count = filter_.find(image, line, 2.0 * scale + 0.25 * beyond_px,
                                       thread_width_m_ * camera.fx_px / p.z(), valleys, 0.25);
        depth_levels_[i] = count > 0 ? valleys[0].depth_levels : 0.0;
        if (at(static_cast<int>(i)) < -0.002) sorted_.push_back(depth_levels_[i]);
    }
    double full = 2.0 * threshold_levels_;
    if (!sorted_.empty()) {
        const auto quantile =
            sorted_.begin() + static_cast<std::ptrdiff_t>(0.6 * static_cast<double>(sorted_.size()));
        std::nth_element(sorted_.begin(), quantile, sorted_.end());
        full = std::max(full, *quantile);
    }
    sum_[0] = 0.0;
    for (std::size_t i = 0; i < path_C_.size(); ++i) {
        const double odds =
            depth_levels_[i] < 0.0 ? 0.0 : kOdds * std::clamp(2.0 * depth_levels_[i] / full - 1.0, -1.0, 1.0);
        sum_[i + 1] = sum_[i] + odds;
    }
    double best = sum_.back();
    for (std::size_t i = sum_.size(); i-- > 0;) {
        best = std::max(best, sum_[i]);
        tail_[i] = best - sum_[i];
    }
}

// Well seen before, not seen after.
bool GripSight::vanishes_at(int index) const {
    const auto between = [this](int from, int to) {
        return (sum_[static_cast<std::size_t>(to)] - sum_[static_cast<std::size_t>(from)]) /
               ((to - from) * kOdds);
    };
    return between(index - kMargin, index) >= 0.4 && between(index, index + kLeastGap) <= -0.3;
}

std::optional<GripSighting> GripSight::look_free(const std::array<ImageView, 2>& images,
                                                 const CubicBasis& basis, const Eigen::Matrix3Xd& Q,
                                                 double length_m, std::size_t end,
                                                 std::span<const scenes::Capsule> instruments_C) {
    follow(basis, Q, length_m, end);
    GripSighting sighting;
    int seen = 0;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        weigh(images[eye], eye, instruments_C);
        const int edge = static_cast<int>(std::max_element(sum_.begin(), sum_.end()) - sum_.begin());
        if (edge < kMargin) continue;
        const bool goes_on = edge + kLeastGap > kPoints;  // beyond what was looked at
        if (!goes_on && !vanishes_at(edge)) continue;
        sighting.offset_m += at(edge) - 0.5 * kStep_m;
        sighting.sigma_m = std::max(sighting.sigma_m, goes_on ? kFarSigma_m : kFreeSigma_m);
        ++seen;
    }
    if (seen == 0) return std::nullopt;
    sighting.offset_m /= seen;
    return sighting;
}

// Visible up to A, hidden up to B, visible for some length: the A and B of the largest log odds.
GripSight::Edges GripSight::find(const Outline& predicted, const GripQuery& query) {
    const double expected_m = predicted.inner->at_m + query.expected_m - query.excess_m;
    const double variance =
        query.sigma_m * query.sigma_m + query.excess_variance_m2 + kShapeSigma_m * kShapeSigma_m;
    const double width_m =
        predicted.outer ? predicted.outer->at_m - predicted.inner->at_m + 2.0 * query.excess_m : 0.0;
    const double width_variance = 4.0 * (query.excess_variance_m2 + kShapeSigma_m * kShapeSigma_m);
    double best = -1e18;
    int best_A = -1, best_B = -1;
    // Index i stands between places i - 1 and i.
    for (int A = kMargin; A + kLeastGap <= kPoints; ++A) {
        const double off = at(A) - 0.5 * kStep_m - expected_m;
        const double own = sum_[static_cast<std::size_t>(A)] - 0.5 * off * off / variance;
        if (own > best) {
            best = own;
            best_A = A;
            best_B = -1;
        }
        if (!predicted.outer) continue;
        for (int B = A + kLeastGap; B < kPoints; ++B) {
            const double tail = tail_[static_cast<std::size_t>(B)];
            if (tail < kLeastTail_m / kStep_m * kOdds) continue;
            const double wide = (B - A) * kStep_m - width_m;
            if (wide * wide > 6.0 * width_variance) continue;
            const double both = own + std::min(tail, kMostTail) - 0.5 * wide * wide / width_variance;
            if (both > best) {
                best = both;
                best_A = A;
                best_B = B;
            }
        }
    }
    Edges edges;
    if (best_A < 0) return edges;
    if (!vanishes_at(best_A)) return edges;
    edges.inner_m = at(best_A) - 0.5 * kStep_m;
    if (best_B > 0) edges.outer_m = at(best_B) - 0.5 * kStep_m;
    return edges;
}

std::optional<GripSighting> GripSight::look(const std::array<ImageView, 2>& images, const CubicBasis& basis,
                                            const Eigen::Matrix3Xd& Q, double length_m,
                                            const GripQuery& query) {
    follow(basis, Q, length_m, query.end);
    jaws_C_.clear();
    others_C_.clear();
    const Eigen::Vector3d shift = path_C_[kEnd] - query.measured_C;
    for (scenes::Capsule capsule : query.instruments_C) {
        if (scenes::clearance_m(capsule, query.measured_C) > kSameArm_m) {
            others_C_.push_back(capsule);
            continue;
        }
        capsule.a += shift;
        capsule.b += shift;
        jaws_C_.push_back(capsule);
    }
    // Least squares of offset and excess: an inner edge is at predicted + offset - excess, an outer one at
    // predicted + offset + excess.
    Eigen::Matrix2d N = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    N(1, 1) = 1.0 / query.excess_variance_m2;
    g[1] = query.excess_m / query.excess_variance_m2;
    int inner = 0, outer = 0;
    double apart_m = 0.0;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const Eigen::Vector3d eye_C =
            eye == 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(rig_.X_RC.inverse().translation());
        const Outline predicted = predict(eye_C, jaws_C_);
        if (!predicted.inner) continue;
        weigh(images[eye], eye, others_C_);
        const Edges seen = find(predicted, query);
        if (!seen.inner_m) continue;
        const auto add = [&](double seen_m, const Border& border, double sign) {
            const double residual = seen_m - border.at_m;
            const double weight = 1.0 / (kEdgeSigma_m * kEdgeSigma_m * border.slope * border.slope);
            N(0, 0) += weight;
            N(0, 1) += sign * border.slope * weight;
            N(1, 1) += border.slope * border.slope * weight;
            g[0] += weight * residual;
            g[1] += sign * border.slope * weight * residual;
        };
        ++inner;
        add(*seen.inner_m, *predicted.inner, -1.0);
        if (!seen.outer_m) continue;
        ++outer;
        add(*seen.outer_m, *predicted.outer, 1.0);
        apart_m += (*seen.outer_m - predicted.outer->at_m - *seen.inner_m + predicted.inner->at_m) /
                   (predicted.inner->slope + predicted.outer->slope);
    }
    if (inner == 0) return std::nullopt;
    N(1, 0) = N(0, 1);
    const Eigen::Matrix2d covariance = N.inverse();
    GripSighting sighting;
    sighting.offset_m = (covariance * g)[0];
    sighting.sigma_m = std::sqrt(covariance(0, 0) + kShapeSigma_m * kShapeSigma_m);
    const double surprise = sighting.offset_m - query.expected_m;
    if (surprise * surprise > 9.0 * (sighting.sigma_m * sighting.sigma_m + query.sigma_m * query.sigma_m))
        return std::nullopt;
    if (outer > 0) {
        sighting.excess_m = apart_m / outer;
        sighting.excess_sigma_m = std::hypot(kEdgeSigma_m, kShapeSigma_m);
    }
    return sighting;
}

}  // namespace atropos::tracker
