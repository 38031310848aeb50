#include "tracker/thread_contrast.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace atropos::tracker {
namespace {

constexpr int kPlaces = 80;

double median(std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/// Standard deviation of a profile's values for that of a pixel: linear interpolation leaves 2/3 of the
/// variance and 1/6 between neighbours, along the normal and between taps.
double left_by_averaging(int taps) {
    const double across = 2.0 / 3.0;
    const double along = (taps * 2.0 / 3.0 + (taps - 1) * 2.0 / 6.0) / (taps * taps);
    return std::sqrt(across * along);
}

}  // namespace

std::optional<ThreadContrast> thread_contrast(const std::array<ImageView, 2>& images,
                                              const scenes::Polyline& truth_C, const scenes::StereoRig& rig,
                                              double width_m, const ValleyFilterOptions& options) {
    const ValleyFilter filter(options);
    std::vector<double> contrasts, noises;
    const scenes::Polyline places = truth_C.resampled(kPlaces);
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const scenes::Camera& camera = eye == 0 ? rig.left : rig.right;
        const Eigen::Isometry3d X_EC = eye == 0 ? Eigen::Isometry3d::Identity() : rig.X_RC;
        for (std::size_t i = 0; i + 1 < places.points.size(); ++i) {
            const Eigen::Vector3d p = X_EC * places.points[i], next = X_EC * places.points[i + 1];
            if (p.z() <= 0.0 || next.z() <= 0.0) continue;
            NormalLine line;
            line.p_px = camera.project(p);
            line.tangent = (camera.project(next) - line.p_px).normalized();
            line.normal = {-line.tangent.y(), line.tangent.x()};
            ValleyFilter::Localisation found;
            if (!camera.contains(line.p_px) ||
                !filter.localise(images[eye], line, width_m * camera.fx_px / p.z(), found))
                continue;
            contrasts.push_back(found.contrast_levels);
            noises.push_back(found.noise_levels / left_by_averaging(options.taps));
        }
    }
    if (contrasts.empty()) return std::nullopt;
    return ThreadContrast{median(contrasts), median(noises)};
}

}  // namespace atropos::tracker
