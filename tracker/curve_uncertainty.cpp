#include "tracker/curve_uncertainty.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {

void sample_with_uncertainty(const CubicBasis& basis, const Eigen::Matrix3Xd& Q,
                             const Eigen::MatrixXd& covariance, std::vector<double>& arc,
                             std::vector<scenes::ThreadSample>& samples) {
    constexpr int kSteps = 400;
    arc.resize(kSteps + 1);
    arc[0] = 0.0;
    Eigen::Vector3d before = Q.col(0);
    for (int i = 1; i <= kSteps; ++i) {
        const Eigen::Vector3d here = basis.at(static_cast<double>(i) / kSteps).point(Q);
        arc[static_cast<std::size_t>(i)] = arc[static_cast<std::size_t>(i - 1)] + (here - before).norm();
        before = here;
    }
    samples.resize(kEstimateSamples);
    std::size_t at = 0;
    for (int i = 0; i < kEstimateSamples; ++i) {
        const double s = arc.back() * i / (kEstimateSamples - 1);
        while (at + 2 < arc.size() && arc[at + 1] < s) ++at;
        const double share = std::clamp((s - arc[at]) / std::max(arc[at + 1] - arc[at], 1e-12), 0.0, 1.0);
        const CubicBasisValues place = basis.at((static_cast<double>(at) + share) / kSteps);

        scenes::ThreadSample& sample = samples[static_cast<std::size_t>(i)];
        sample.s_m = s;
        sample.p_C = place.point(Q);
        Eigen::Matrix3d cov = Eigen::Matrix3d::Zero();
        for (int a = 0; a < 4; ++a)
            for (int b = 0; b < 4; ++b)
                cov += place.value[static_cast<std::size_t>(a)] * place.value[static_cast<std::size_t>(b)] *
                       covariance.block<3, 3>(3 * (place.first + a), 3 * (place.first + b));
        // The offset to the nearest point of the true curve has no part along the tangent.
        const Eigen::Vector3d tangent = place.tangent(Q).normalized();
        sample.sigma_along_m = std::sqrt(std::max(tangent.dot(cov * tangent), 0.0));
        const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - tangent * tangent.transpose();
        const Eigen::Matrix3d offset = across * cov * across;
        const Eigen::Vector3d ray = sample.p_C.normalized();
        const double depth = ray.dot(offset * ray);
        sample.sigma_depth_m = std::sqrt(std::max(depth, 0.0));
        sample.sigma_lateral_m = std::sqrt(std::max(offset.trace() - depth, 0.0));
    }
}

}  // namespace atropos::tracker
