#include "tracker/loss_test.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {

FitQuality judge_fit(const std::array<std::vector<LineMeasurement>, 2>& lines,
                     std::span<const CubicBasisValues> samples, const Eigen::Matrix3Xd& Q, double length_m,
                     const scenes::StereoRig& rig, const LossTestOptions& options) {
    const std::size_t n = samples.size();
    const std::size_t window = std::max<std::size_t>(1, n / 8);
    FitQuality quality;
    quality.worst_window = 1.0;
    double supported = 0.0, visible = 0.0, squares = 0.0;
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const scenes::Camera& camera = eye == 0 ? rig.left : rig.right;
        double in_window = 0.0;
        const auto share = [&](std::size_t j, double* residual_px) {
            const LineMeasurement& line = lines[eye][j];
            if (line.kind == LineMeasurement::Kind::kHidden) return 0.5;
            if (line.kind == LineMeasurement::Kind::kMissing) return 0.0;
            Eigen::Vector3d p = samples[j].point(Q);
            if (eye == 1) p = rig.X_RC * p;
            const double r = line.normal.dot(camera.project(p) - line.point_px);
            if (residual_px) *residual_px = r;
            return std::abs(r) < options.residual_px ? 1.0 : 0.0;
        };
        for (std::size_t j = 0; j < n; ++j) {
            double r = 0.0;
            const double s = share(j, &r);
            if (lines[eye][j].kind != LineMeasurement::Kind::kHidden) {
                visible += 1.0;
                supported += s;
                squares += s * r * r;
            }
            in_window += s;
            if (j >= window) in_window -= share(j - window, nullptr);
            if (j + 1 >= window)
                quality.worst_window =
                    std::min(quality.worst_window, in_window / static_cast<double>(window));
        }
    }
    double stretch = 0.0;
    for (const CubicBasisValues& sample : samples)
        stretch += std::pow(sample.tangent(Q).norm() / length_m - 1.0, 2);
    quality.support = visible > 0.0 ? supported / visible : 0.0;
    quality.visible = visible / (2.0 * static_cast<double>(n));
    quality.rms_stretch = std::sqrt(stretch / static_cast<double>(n));
    quality.rms_residual_px = supported > 0.0 ? std::sqrt(squares / supported) : 0.0;
    return quality;
}

bool is_lost(const FitQuality& quality, const LossTestOptions& options) {
    return quality.worst_window < options.worst_window || quality.rms_stretch > options.rms_stretch ||
           quality.end_off_m > options.end_off_m || !std::isfinite(quality.rms_residual_px);
}

}  // namespace atropos::tracker
