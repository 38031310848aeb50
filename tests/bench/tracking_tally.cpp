#include "tests/bench/tracking_tally.hpp"

#include <algorithm>
#include <numeric>

#include "tracker/curve_distance.hpp"

namespace atropos::bench {

double Values::mean() const {
    if (values_.empty()) return 0.0;
    return std::accumulate(values_.begin(), values_.end(), 0.0) / static_cast<double>(values_.size());
}

double Values::quantile(double share) const {
    if (values_.empty()) return 0.0;
    std::vector<double> sorted = values_;
    const auto at =
        sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    return *at;
}

double Values::percent_below(double limit) const {
    if (values_.empty()) return 0.0;
    const auto below = std::count_if(values_.begin(), values_.end(), [=](double v) { return v < limit; });
    return 100.0 * static_cast<double>(below) / static_cast<double>(values_.size());
}

bool TrackingTally::count(bool frame_failed) {
    failed += frame_failed;
    events += frame_failed && !failed_before_;
    return failed_before_ = frame_failed;
}

bool TrackingTally::add(const scenes::ThreadEstimate& estimate, const scenes::Polyline& truth_C,
                        const scenes::StereoRig& rig) {
    ++frames;
    if (estimate.status == scenes::TrackStatus::kLost || estimate.samples.empty()) {
        ++lost;
        return count(true);
    }
    coasting += estimate.status == scenes::TrackStatus::kCoasting;
    const scenes::Polyline image[2] = {tracker::image_of(truth_C, rig, 0),
                                       tracker::image_of(truth_C, rig, 1)};
    const std::size_t n = estimate.samples.size();
    const scenes::Polyline even = truth_C.resampled(static_cast<int>(n));
    double mm = 0.0, px = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
        const scenes::ThreadSample& sample = estimate.samples[i];
        const Eigen::Vector3d tangent =
            (even.points[std::min(i + 1, n - 1)] - even.points[std::max<std::size_t>(i, 1) - 1]).normalized();
        along_sigmas.add(std::abs(tangent.dot(sample.p_C - even.points[i])) / sample.sigma_along_m);
        const scenes::Polyline::Nearest nearest = truth_C.nearest(sample.p_C);
        const Eigen::Vector3d offset = sample.p_C - nearest.point, ray = sample.p_C.normalized();
        const double depth_m = ray.dot(offset);
        depth_sigmas.add(std::abs(depth_m) / sample.sigma_depth_m);
        lateral_sigmas.add((offset - depth_m * ray).norm() / sample.sigma_lateral_m);
        mm += 1e3 * nearest.distance_m / static_cast<double>(n);
        const Eigen::Vector2d left = rig.project_left(sample.p_C), right = rig.project_right(sample.p_C);
        px += 0.5 / static_cast<double>(n) *
              (image[0].nearest({left.x(), left.y(), 0.0}).distance_m +
               image[1].nearest({right.x(), right.y(), 0.0}).distance_m);
    }
    scenes::Polyline seen;
    for (const scenes::ThreadSample& sample : estimate.samples) seen.points.push_back(sample.p_C);
    double back_mm = 0.0;
    for (const Eigen::Vector3d& p : even.points)
        back_mm += 1e3 * seen.nearest(p).distance_m / static_cast<double>(n);
    symmetric_mm.add(0.5 * (mm + back_mm));
    px *= 640.0 / rig.left.width_px;
    error_mm.add(mm);
    error_px.add(px);
    middle_mm.add(1e3 * (estimate.samples[n / 2].p_C - truth_C.point_at(0.5 * truth_C.length_m())).norm());
    silent += estimate.status == scenes::TrackStatus::kTracking && (mm > 3.0 || px > 5.0);
    return count(px > 5.0);
}

}  // namespace atropos::bench
