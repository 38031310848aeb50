#include "tracker/path_curve.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/polyline.hpp"
#include "tracker/curve_uncertainty.hpp"

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Where a pixel lies on a path, looked for around an arc length.
struct Foot {
    double arc_px = 0.0;
    Vector2d px, tangent;
    bool seen = false;
};

Foot foot_on(const ImagePath& path, const std::vector<double>& arc, const Vector2d& px, double around_px) {
    constexpr double kWindow_px = 15.0;
    const auto lower = std::lower_bound(arc.begin(), arc.end(), around_px - kWindow_px);
    std::size_t i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, lower - arc.begin() - 1));
    Foot foot;
    double least = 1e18;
    for (; i + 1 < arc.size() && arc[i] <= around_px + kWindow_px; ++i) {
        const RidgePoint &a = path.points[i], &b = path.points[i + 1];
        const Vector2d d = b.px - a.px;
        const double raw = (px - a.px).dot(d) / std::max(d.squaredNorm(), 1e-12);
        const double t = std::clamp(raw, 0.0, 1.0);
        const double distance = (px - a.px - t * d).squaredNorm();
        if (distance >= least) continue;
        least = distance;
        const bool beyond = (i == 0 && raw < -1.0) || (i + 2 == arc.size() && raw > 2.0);
        foot = {arc[i] + t * (arc[i + 1] - arc[i]), a.px + t * d,
                ((1.0 - t) * a.tangent + t * b.tangent).normalized(),
                !beyond && a.strength_levels > 0.0 && b.strength_levels > 0.0};
    }
    return foot;
}

/// The points averaged over neighbours: at 2 px a step the noise of their depth would be most of the length.
scenes::Polyline smooth_line(const std::vector<PairedPoint>& points) {
    constexpr std::ptrdiff_t kHalf = 8;
    const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(points.size());
    scenes::Polyline line;
    for (std::ptrdiff_t i = 0; i < n; ++i) {
        const std::ptrdiff_t half = std::min({kHalf, i, n - 1 - i});
        Vector3d sum = Vector3d::Zero();
        for (std::ptrdiff_t k = i - half; k <= i + half; ++k) sum += points[static_cast<std::size_t>(k)].p_C;
        line.points.push_back(sum / static_cast<double>(2 * half + 1));
    }
    return line;
}

/// One curve on its way to the paths.
class PathFit {
  public:
    PathFit(const RectifiedView& view, const std::array<ImagePath, 2>& paths, const PathCurveOptions& options)
        : view_(view),
          rig_(view.with_row_offset(options.row_offset_px)),
          paths_(paths),
          options_(options),
          samples_(3 * options.control_points) {
        for (std::size_t eye = 0; eye < 2; ++eye) arc_[eye] = paths[eye].arc_lengths_px();
    }

    PathCurve run(const std::vector<PairedPoint>& points) {
        const scenes::Polyline line = smooth_line(points);
        const std::vector<double> along = line.arc_lengths_m();
        start_from(line);
        priors_ = priors();
        expect(points, along);
        for (auto& lines : problem_.lines) lines.resize(static_cast<std::size_t>(samples_));
        problem_.length_m = curve_.length_m;
        problem_.length_sigma_m = 0.3 * curve_.length_m;
        curve_.row_offset_px = options_.row_offset_px;
        problem_.robust_px = 3.0;
        curve_.cost = refine(points, 4);
        problem_.robust_px = 0.6;
        curve_.cost = refine(points, 4);
        // The offset by a parabola through three costs, each from the curve as it is.
        for (const double step : {0.4, 0.2}) {
            const double middle = curve_.row_offset_px;
            const PathCurve here = curve_;
            double cost[3];
            for (int k = 0; k < 3; ++k) {
                curve_ = here;
                set_row_offset(middle + step * (k - 1));
                refine(points, 3);
                cost[k] = refine(points, 3);
            }
            const double bend = cost[0] - 2.0 * cost[1] + cost[2];
            const double move = bend > 1e-9         ? 0.5 * (cost[0] - cost[2]) / bend
                                : cost[0] < cost[2] ? -1.0
                                                    : 1.0;
            curve_ = here;
            set_row_offset(middle + step * std::clamp(move, -1.5, 1.5));
            curve_.cost = refine(points, 4);
        }
        curve_.cost = refine(points, 4);
        conclude();
        return curve_;
    }

  private:
    void set_row_offset(double px) {
        curve_.row_offset_px = px;
        rig_ = view_.with_row_offset(px);
    }

    // One look and the fit to it; the cost, the offset's own included.
    double refine(const std::vector<PairedPoint>& points, int iterations) {
        CurveRefinement refinement(options_.control_points, samples_, priors_, rig_);
        problem_.expected = curve_.Q;
        measure(refinement);
        anchor_ends(points);
        const double offset = curve_.row_offset_px / options_.row_offset_sigma_px;
        return refinement.refine(problem_, iterations, curve_.Q, curve_.length_m) + 0.5 * offset * offset;
    }

    // Control points on the line itself, at the means of the knots they reach (Schoenberg's approximation):
    // never wild, whatever the noise of the points.
    void start_from(const scenes::Polyline& line) {
        const CubicBasis basis(options_.control_points);
        std::vector<double> knots{0.0, 0.0, 0.0};
        for (double u : basis.basis().distinct_knots()) knots.push_back(u);
        knots.insert(knots.end(), 3, 1.0);
        curve_.length_m = line.length_m();
        curve_.Q.resize(3, options_.control_points);
        for (int k = 0; k < options_.control_points; ++k) {
            const auto u = knots.begin() + k;
            curve_.Q.col(k) = line.point_at(curve_.length_m * (u[1] + u[2] + u[3]) / 3.0);
        }
    }

    // Bending of the scale that the path shows in the left image, at the thread's distance.
    CurvePriors priors() {
        const Vector3d& middle = curve_.Q.col(curve_.Q.cols() / 2);
        const double px_per_m = rig_.left.fx_px / middle.z();
        double bend2 = 0.0, length = 0.0;
        // Chords long enough that the noise of points does not pass for bending.
        constexpr double kChord_px = 20.0;
        const auto& points = paths_[0].points;
        const auto at = [&](double s) {
            const auto i = std::lower_bound(arc_[0].begin(), arc_[0].end(), s) - arc_[0].begin();
            return points[static_cast<std::size_t>(std::min<std::ptrdiff_t>(i, std::ssize(points) - 1))].px;
        };
        for (double s = kChord_px; s + kChord_px < arc_[0].back(); s += kChord_px) {
            const Vector2d a = at(s) - at(s - kChord_px), b = at(s + kChord_px) - at(s);
            const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
            bend2 += turn * turn / kChord_px;
            length += kChord_px;
        }
        const double bend_per_px = std::sqrt(bend2 / std::max(length, 1.0));
        CurvePriors priors;
        priors.stretch_sigma = 0.01;
        priors.curvature_sigma_per_m = std::max(30.0, 2.0 * bend_per_px * px_per_m);
        priors.curvature_change_sigma_per_m2 =
            std::max(4000.0, priors.curvature_sigma_per_m * px_per_m / 12.0);
        end_sigma_m_ = 1.0 / px_per_m;
        return priors;
    }

    // Places along the paths, of each sample, from the points the curve was fitted to.
    void expect(const std::vector<PairedPoint>& points, const std::vector<double>& along) {
        for (std::size_t eye = 0; eye < 2; ++eye) {
            expected_px_[eye].assign(static_cast<std::size_t>(samples_), -1.0);
            std::size_t i = 0;
            for (int j = 0; j < samples_; ++j) {
                const double s = along.back() * (j + 0.5) / samples_;
                while (i + 2 < along.size() && along[i + 1] < s) ++i;
                const double a = points[i].arc_px[eye], b = points[i + 1].arc_px[eye];
                if (a < 0.0 || b < 0.0) continue;
                const double t =
                    std::clamp((s - along[i]) / std::max(along[i + 1] - along[i], 1e-12), 0.0, 1.0);
                expected_px_[eye][static_cast<std::size_t>(j)] = a + t * (b - a);
            }
        }
    }

    void measure(const CurveRefinement& refinement) {
        for (std::size_t eye = 0; eye < 2; ++eye)
            for (std::size_t j = 0; j < static_cast<std::size_t>(samples_); ++j) {
                LineMeasurement& line = problem_.lines[eye][j];
                double& expected = expected_px_[eye][j];
                line.kind = LineMeasurement::Kind::kHidden;
                if (expected < 0.0) continue;
                const Vector3d p_C = refinement.samples()[j].point(curve_.Q);
                const Vector3d p = eye == 0 ? p_C : Vector3d(rig_.X_RC * p_C);
                if (p.z() < 0.001) continue;
                const Vector2d px = (eye == 0 ? rig_.left : rig_.right).project(p);
                const Foot foot = foot_on(paths_[eye], arc_[eye], px, expected);
                expected = foot.arc_px;
                line.kind = foot.seen ? LineMeasurement::Kind::kSeen : LineMeasurement::Kind::kMissing;
                line.point_px = foot.px;
                line.normal = {-foot.tangent.y(), foot.tangent.x()};
                line.sigma_px = options_.line_sigma_px;
            }
    }

    // The ends lie on the rays through the ends of what was paired, at the depth the curve has there.
    void anchor_ends(const std::vector<PairedPoint>& points) {
        for (std::size_t end = 0; end < 2; ++end) {
            const Vector3d q = end == 0 ? curve_.Q.col(0) : curve_.Q.col(curve_.Q.cols() - 1);
            const Vector3d ray = (end == 0 ? points.front() : points.back()).p_C;
            problem_.ends[end] = end_prior({ray * (q.z() / ray.z()), MeasuredTip::Kind::kHeld}, end_sigma_m_);
        }
    }

    void conclude() {
        CurveRefinement refinement(options_.control_points, samples_, priors_, rig_);
        double squares = 0.0;
        int seen = 0, both = 0;
        for (std::size_t j = 0; j < static_cast<std::size_t>(samples_); ++j) {
            int eyes = 0;
            for (std::size_t eye = 0; eye < 2; ++eye) {
                const LineMeasurement& line = problem_.lines[eye][j];
                if (line.kind != LineMeasurement::Kind::kSeen) continue;
                const Vector3d p_C = refinement.samples()[j].point(curve_.Q);
                const Vector2d px = eye == 0 ? rig_.project_left(p_C) : rig_.project_right(p_C);
                const double r = line.normal.dot(px - line.point_px);
                squares += r * r;
                ++seen;
                ++eyes;
            }
            if (eyes == 2) ++both;
        }
        curve_.residual_px = seen > 0 ? std::sqrt(squares / seen) : 0.0;
        curve_.seen_share = static_cast<double>(both) / samples_;
        Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(curve_.Q.size(), curve_.Q.size());
        double length_variance = 0.0;
        std::vector<double> arc;
        refinement.covariance(problem_, curve_.Q, curve_.length_m, covariance, length_variance);
        sample_with_uncertainty(refinement.basis(), curve_.Q, covariance, arc, curve_.samples);
        curve_.length_m = curve_.samples.back().s_m;
    }

    const RectifiedView& view_;
    scenes::StereoRig rig_;
    const std::array<ImagePath, 2>& paths_;
    PathCurveOptions options_;
    int samples_;
    std::array<std::vector<double>, 2> arc_;
    std::array<std::vector<double>, 2> expected_px_;
    CurvePriors priors_;
    double end_sigma_m_ = 0.001;
    CurveProblem problem_;
    PathCurve curve_;
};

}  // namespace

PathCurve fit_to_paths(const RectifiedView& view, const std::array<ImagePath, 2>& paths,
                       const std::vector<PairedPoint>& points, const PathCurveOptions& options) {
    return PathFit(view, paths, options).run(points);
}

}  // namespace atropos::tracker
