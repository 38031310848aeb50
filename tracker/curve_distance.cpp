#include "tracker/curve_distance.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace atropos::tracker {
namespace {

constexpr int kDeepest = 12;  // halvings; kinks of the distance keep Simpson's rule from converging sooner

struct Panel {
    double begin, end;
    double at_begin, at_middle, at_end;
    double simpson() const { return (end - begin) / 6.0 * (at_begin + 4.0 * at_middle + at_end); }
};

template <typename Function>
double integrate(const Function& f, const Panel& panel, double tolerance, int depth) {
    const double middle = 0.5 * (panel.begin + panel.end);
    const Panel left{panel.begin, middle, panel.at_begin, f(0.5 * (panel.begin + middle)), panel.at_middle};
    const Panel right{middle, panel.end, panel.at_middle, f(0.5 * (middle + panel.end)), panel.at_end};
    const double change = left.simpson() + right.simpson() - panel.simpson();
    if (depth == 0 || std::abs(change) <= 15.0 * tolerance)
        return left.simpson() + right.simpson() + change / 15.0;
    return integrate(f, left, 0.5 * tolerance, depth - 1) + integrate(f, right, 0.5 * tolerance, depth - 1);
}

/// Integral of f over [0, 1] from `panels` equal ones.
template <typename Function>
double integrate_unit(const Function& f, int panels, double tolerance) {
    double sum = 0.0;
    double at_begin = f(0.0);
    for (int i = 0; i < panels; ++i) {
        const double begin = static_cast<double>(i) / panels;
        const double end = static_cast<double>(i + 1) / panels;
        const Panel panel{begin, end, at_begin, f(0.5 * (begin + end)), f(end)};
        sum += integrate(f, panel, tolerance / panels, kDeepest);
        at_begin = panel.at_end;
    }
    return sum;
}

void require_points(const scenes::Polyline& line) {
    if (line.points.empty()) throw std::invalid_argument("a curve without points, expected one or more");
}

}  // namespace

double curve_distance(const scenes::Polyline& curve, const scenes::Polyline& truth) {
    require_points(curve);
    require_points(truth);
    const std::vector<double> s_m = curve.arc_lengths_m();
    const double length = s_m.back();
    if (length == 0.0) return truth.nearest(curve.points.front()).distance_m;
    double sum = 0.0;  // link by link: the curve has a kink between them
    for (std::size_t i = 0; i + 1 < curve.points.size(); ++i) {
        const double share = (s_m[i + 1] - s_m[i]) / length;
        if (share == 0.0) continue;
        const auto distance = [&](double t) {
            return truth.nearest(curve.points[i] + t * (curve.points[i + 1] - curve.points[i])).distance_m;
        };
        sum += share * integrate_unit(distance, 1, 1e-10 * length);
    }
    return sum;
}

double curve_distance(const NurbsCurve& curve, const scenes::Polyline& truth) {
    require_points(truth);
    const auto distance = [&](double u) { return truth.nearest(curve.point(u)).distance_m; };
    return integrate_unit(distance, 64, 1e-10 * truth.length_m());
}

double symmetric_curve_distance(const scenes::Polyline& first, const scenes::Polyline& second) {
    return 0.5 * (curve_distance(first, second) + curve_distance(second, first));
}

ArcLengthDistance arc_length_distance(const scenes::Polyline& curve, const scenes::Polyline& truth,
                                      int count) {
    require_points(curve);
    require_points(truth);
    const scenes::Polyline a = curve.resampled(count);
    const scenes::Polyline b = truth.resampled(count);
    ArcLengthDistance result{
        0.0, 0.0, (curve.point_at(0.5 * curve.length_m()) - truth.point_at(0.5 * truth.length_m())).norm()};
    for (std::size_t i = 0; i < a.points.size(); ++i) {
        const double d = (a.points[i] - b.points[i]).norm();
        result.mean_m += d / static_cast<double>(a.points.size());
        result.max_m = std::max(result.max_m, d);
    }
    return result;
}

scenes::Polyline image_of(const scenes::Polyline& curve_C, const scenes::StereoRig& rig, int eye) {
    scenes::Polyline image;
    image.points.reserve(curve_C.points.size());
    for (const Eigen::Vector3d& p_C : curve_C.points) {
        const Eigen::Vector2d px = eye == 0 ? rig.project_left(p_C) : rig.project_right(p_C);
        image.points.emplace_back(px.x(), px.y(), 0.0);
    }
    return image;
}

double image_distance_px(const scenes::Polyline& curve_C, const scenes::Polyline& truth_C,
                         const scenes::StereoRig& rig) {
    double sum = 0.0;
    for (int eye = 0; eye < 2; ++eye)
        sum += 0.5 * curve_distance(image_of(curve_C, rig, eye), image_of(truth_C, rig, eye));
    return sum;
}

double symmetric_image_distance_px(const scenes::Polyline& curve_C, const scenes::Polyline& truth_C,
                                   const scenes::StereoRig& rig) {
    return 0.5 * (image_distance_px(curve_C, truth_C, rig) + image_distance_px(truth_C, curve_C, rig));
}

}  // namespace atropos::tracker
