#include "tracker/cramer_rao_bound.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/random_stream.hpp"
#include "tests/support/inextensible_curve.hpp"
#include "tracker/cubic_basis.hpp"
#include "tracker/nurbs_curve.hpp"

namespace atropos::tracker {
namespace {

double bound_mm(const scenes::StereoRig& rig, BoundOptions options = {}) {
    const scenes::Polyline truth_C = support::InextensibleCurve({}).at(0.0);
    return 1e3 * cramer_rao_bound(truth_C, rig, {}, options).mean_3d_m;
}

TEST(CramerRaoBound, is_a_tenth_of_a_millimetre_at_the_reference_camera) {
    const double mm = bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.005));
    RecordProperty("bound_mm", std::to_string(mm));
    EXPECT_GT(mm, 0.05);
    EXPECT_LT(mm, 0.16);
}

TEST(CramerRaoBound, falls_with_resolution_and_baseline_and_grows_with_noise) {
    const double usual = bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.005));
    EXPECT_LT(bound_mm(scenes::parallel_rig(1920, 1080, 1725.0, 0.005)), 0.5 * usual);
    EXPECT_LT(bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.010)), 0.8 * usual);
    EXPECT_GT(bound_mm(scenes::parallel_rig(640, 360, 575.0, 0.005), {.contrast_levels = 14.0}), 2.0 * usual);
}

/// The same bound by brute force: pictures of a blurred bar, pixel by pixel, and priors, all differentiated
/// by central differences of the control points.
class BruteForce {
  public:
    BruteForce(const scenes::StereoRig& rig, const BoundOptions& options, double length_m)
        : rig_(rig), options_(options), length_m_(length_m), places_(basis_.at_midpoints(80)) {}

    double mean_3d_m(const Eigen::VectorXd& Q) const {
        constexpr double kStep_m = 1e-6;
        const int n = static_cast<int>(Q.size());
        Eigen::MatrixXd J(residuals(Q, length_m_).size(), n + 1);
        for (int i = 0; i <= n; ++i) {
            const Eigen::VectorXd step =
                i < n ? Eigen::VectorXd(kStep_m * Eigen::VectorXd::Unit(n, i)) : Eigen::VectorXd::Zero(n);
            const double longer_m = i < n ? 0.0 : kStep_m;
            J.col(i) =
                (residuals(Q + step, length_m_ + longer_m) - residuals(Q - step, length_m_ - longer_m)) /
                (2.0 * kStep_m);
        }
        const Eigen::MatrixXd covariance = (J.transpose() * J).inverse().topLeftCorner(n, n);
        const Eigen::MatrixXd root = covariance.llt().matrixL();
        scenes::RandomStream random(7, "draws");
        constexpr int kDraws = 4000;
        double sum = 0.0;
        for (int draw = 0; draw < kDraws; ++draw) {
            Eigen::VectorXd z(n);
            for (int i = 0; i < n; ++i) z[i] = random.normal();
            const Eigen::VectorXd error = root * z;
            for (const CubicBasisValues& place : places_) {
                const Eigen::Vector3d tangent = place.tangent(points(Q)).normalized();
                const Eigen::Vector3d off = place.point(points(error));
                sum += (off - tangent.dot(off) * tangent).norm();
            }
        }
        return sum / (kDraws * static_cast<double>(places_.size()));
    }

  private:
    static Eigen::Matrix3Xd points(const Eigen::VectorXd& Q) { return Q.reshaped(3, Q.size() / 3); }

    Eigen::VectorXd residuals(const Eigen::VectorXd& q, double length_m) const {
        const Eigen::Matrix3Xd Q = points(q);
        std::vector<double> r;
        for (int eye = 0; eye < 2; ++eye) add_picture(Q, eye, r);
        for (const CubicBasisValues& place : places_)
            r.push_back((place.tangent(Q).norm() / length_m - 1.0) / options_.stretch_sigma);
        r.push_back((length_m - length_m_) / options_.length_sigma_m);
        for (int axis = 0; axis < 3; ++axis)
            for (const auto end : {Eigen::Index{0}, Q.cols() - 1})
                r.push_back(Q(axis, end) / options_.tip_sigma_m);
        return Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size()));
    }

    void add_picture(const Eigen::Matrix3Xd& Q, int eye, std::vector<double>& r) const {
        std::vector<Eigen::Vector2d> px;
        for (int i = 0; i <= 24; ++i) {
            const Eigen::Vector3d p = basis_.at(i / 24.0).point(Q);
            px.push_back(eye == 0 ? rig_.project_left(p) : rig_.project_right(p));
        }
        const double half_px = 0.5 * options_.width_m * rig_.left.fx_px / 0.1;
        const double s = std::sqrt(options_.blur_px * options_.blur_px + 1.0 / 12.0);
        for (int v = 0; v < rig_.left.height_px; ++v)
            for (int u = 0; u < rig_.left.width_px; ++u) {
                double nearest = 1e9;
                for (std::size_t i = 0; i + 1 < px.size(); ++i) {
                    const Eigen::Vector2d d = px[i + 1] - px[i], to = Eigen::Vector2d(u, v) - px[i];
                    const double t = std::clamp(to.dot(d) / d.squaredNorm(), 0.0, 1.0);
                    nearest = std::min(nearest, (to - t * d).squaredNorm());
                }
                const double d = std::sqrt(nearest), k = 1.0 / (std::numbers::sqrt2 * s);
                const double bar = 0.5 * (std::erf((half_px - d) * k) + std::erf((half_px + d) * k));
                r.push_back(options_.contrast_levels * bar / options_.noise_levels);
            }
    }

    scenes::StereoRig rig_;
    BoundOptions options_;
    double length_m_;
    CubicBasis basis_{5};
    std::vector<CubicBasisValues> places_;
};

TEST(CramerRaoBound, is_that_of_pictures_differentiated_pixel_by_pixel) {
    const scenes::StereoRig rig = scenes::parallel_rig(96, 96, 300.0, 0.010);
    const BoundOptions options{.width_m = 0.0005, .control_points = 5};
    scenes::Polyline truth_C;
    for (int i = 0; i <= 100; ++i) {
        const double t = i / 100.0 - 0.5;
        truth_C.points.emplace_back(0.004 * t + 0.0016, 0.022 * t, 0.1 + 0.004 * t * t);
    }
    const NurbsCurve curve = fit_curve(truth_C, {.control_points = 5, .length_weight = 0.3});
    Eigen::VectorXd Q(15);
    for (int k = 0; k < 5; ++k) Q.segment<3>(3 * k) = curve.control_points()[static_cast<std::size_t>(k)];
    const double brute_m = BruteForce(rig, options, truth_C.length_m()).mean_3d_m(Q);
    EXPECT_NEAR(cramer_rao_bound(truth_C, rig, {}, options).mean_3d_m, brute_m, 0.05 * brute_m);
}

}  // namespace
}  // namespace atropos::tracker
