#include "tracker/end_to_end_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>
#include <tuple>

#include "tracker/instrument_shadow.hpp"

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kReach_px = 2;           ///< from a pixel to a line that may pass there
constexpr double kLeastStep_px = 1.5;  ///< a shorter one has no direction in the image
constexpr int kTurns = 3;              ///< to each side
constexpr int kHeadings = 24;          ///< to begin with
constexpr double kFirstSlope_rad = 0.35;
constexpr double kSteepest_rad = 1.3;
constexpr double kNearest_m = 0.02;  ///< to the eye

/// Unit direction at a point in C: across its viewing ray by `heading`, away from the eye by `slope`.
Vector3d direction(const Vector3d& p_C, double heading_rad, double slope_rad) {
    const Vector3d ray = p_C.normalized();
    const Vector3d right = Vector3d::UnitY().cross(ray).normalized(), down = ray.cross(right);
    return std::cos(slope_rad) * (std::cos(heading_rad) * right + std::sin(heading_rad) * down) +
           std::sin(slope_rad) * ray;
}

/// For each pixel that is not hidden, the ridge point nearest to it within reach.
void spread(const RidgePointMap& map, std::vector<std::int32_t>& nearest) {
    nearest = map.at_pixel;
    std::vector<double> off2(nearest.size(), 1e9);
    for (int v = 0; v < map.height; ++v)
        for (int u = 0; u < map.width; ++u) {
            const std::int32_t i = map.index(u, v);
            if (i < 0) continue;
            const Vector2d& px = map.points[static_cast<std::size_t>(i)].px;
            for (int y = std::max(0, v - kReach_px); y <= std::min(map.height - 1, v + kReach_px); ++y)
                for (int x = std::max(0, u - kReach_px); x <= std::min(map.width - 1, u + kReach_px); ++x) {
                    const std::size_t at = static_cast<std::size_t>(y * map.width + x);
                    const double d2 = (px - Vector2d(x, y)).squaredNorm();
                    if (map.at_pixel[at] == RidgePointMap::kHidden || d2 >= off2[at]) continue;
                    off2[at] = d2;
                    nearest[at] = i;
                }
        }
}

}  // namespace

EndToEndSearch::EndToEndSearch(const scenes::StereoRig& rig, const EndToEndOptions& options)
    : rig_(rig), options_(options), detector_(options.ridge) {}

Vector3d EndToEndSearch::in_eye(std::size_t eye, const Vector3d& p_C) const {
    return eye == 0 ? p_C : rig_.X_RC * p_C;
}

Vector2d EndToEndSearch::project(std::size_t eye, const Vector3d& p_C) const {
    return camera(eye).project(in_eye(eye, p_C));
}

void EndToEndSearch::look(const StereoFrame& frame) {
    for (std::size_t eye = 0; eye < 2; ++eye) {
        EyeRidges& e = eyes_[eye];
        detector_.detect(channel_view(eye == 0 ? frame.left : frame.right, options_.channel, e.buffer),
                         e.map);
        hide_instruments(frame.instruments, camera(eye), eye == 0 ? Eigen::Isometry3d::Identity() : rig_.X_RC,
                         options_.instrument_margin_px, e.map);
        spread(e.map, e.nearest);
    }
}

// Index of the ridge point nearest to a place in the image; kHidden outside of it, too.
std::int32_t EndToEndSearch::ridge_at(std::size_t eye, const Vector2d& px) const {
    const EyeRidges& e = eyes_[eye];
    const int u = static_cast<int>(std::lround(px.x())), v = static_cast<int>(std::lround(px.y()));
    if (u < 0 || v < 0 || u >= e.map.width || v >= e.map.height) return RidgePointMap::kHidden;
    return e.nearest[static_cast<std::size_t>(v * e.map.width + u)];
}

double EndToEndSearch::cost_of_step(std::size_t eye, const Vector2d& from_px, const Vector2d& px) const {
    const std::int32_t i = ridge_at(eye, px);
    if (i == RidgePointMap::kHidden) return options_.hidden_cost;
    if (i < 0) return options_.unseen_cost;
    const RidgePoint& point = eyes_[eye].map.points[static_cast<std::size_t>(i)];
    const Vector2d normal(-point.tangent.y(), point.tangent.x());
    const double off = normal.dot(px - point.px) / options_.line_sigma_px;
    const Vector2d way = px - from_px;
    double cost = 0.5 * off * off +
                  options_.faint_cost * std::max(0.0, 1.0 - point.strength_levels / options_.usual_levels);
    if (const double way_px = way.norm(); way_px > kLeastStep_px) {
        const double sine = normal.dot(way) / way_px;
        cost += options_.direction_weight * sine * sine;
    }
    return std::min(cost, options_.unseen_cost);
}

// Whether the images leave the step among what may still be best.
bool EndToEndSearch::take_step(const Place& from, double dearest, Place& to) const {
    to.p_C += options_.step_m * direction(from.p_C, to.heading_rad, to.slope_rad);
    if (to.p_C.z() < kNearest_m) return false;
    to.hidden = false;
    for (std::size_t eye : {0, 1}) {
        to.px[eye] = project(eye, to.p_C);
        to.hidden |= ridge_at(eye, to.px[eye]) == RidgePointMap::kHidden;
        to.cost += cost_of_step(eye, from.px[eye], to.px[eye]);
        if (to.cost > dearest) return false;
    }
    return true;
}

void EndToEndSearch::grow(const Vector3d& goal_C, double reach_m) {
    children_.clear();
    double best = std::numeric_limits<double>::infinity();
    const std::vector<Place>& parents = steps_.back();
    for (std::size_t i = 0; i < parents.size(); ++i)
        for (int turn = -kTurns; turn <= kTurns; ++turn)
            for (int rise = -1; rise <= 1; ++rise) {
                Place to = parents[i];
                to.parent = static_cast<std::int32_t>(i);
                to.heading_rad += turn * options_.turn_rad;
                to.slope_rad += rise * options_.slope_rad;
                if (std::abs(to.slope_rad) > kSteepest_rad) continue;
                const double bend =
                    std::hypot(turn * options_.turn_rad, rise * options_.slope_rad) / options_.usual_turn_rad;
                const double slope = to.slope_rad / options_.usual_slope_rad;
                to.cost += 0.5 * (bend * bend + slope * slope);
                const double dearest = best + options_.margin;
                if (to.cost > dearest || !take_step(parents[i], dearest, to)) continue;
                if ((goal_C - to.p_C).norm() > reach_m) continue;
                best = std::min(best, to.cost);
                children_.push_back(to);
            }
}

// The cheapest of those that are at about the same place and go the same way.
void EndToEndSearch::keep_best() {
    order_.resize(children_.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::stable_sort(order_.begin(), order_.end(), [&](std::int32_t a, std::int32_t b) {
        return children_[static_cast<std::size_t>(a)].cost < children_[static_cast<std::size_t>(b)].cost;
    });
    std::vector<Place> kept;
    std::set<std::tuple<int, int, int, int, int>> taken;
    for (const std::int32_t i : order_) {
        const Place& place = children_[static_cast<std::size_t>(i)];
        const Vector2d &left = place.px[0], &right = place.px[1];
        const auto cell = [](double value, double size) {
            return static_cast<int>(std::floor(value / size));
        };
        const double turns = place.heading_rad / (2.0 * std::numbers::pi);
        const double size = place.hidden ? options_.hidden_cells : 1.0;  // nothing there tells ways apart
        if (!taken
                 .emplace(cell(left.x(), 2.0 * size), cell(left.y(), 2.0 * size),
                          cell(left.x() - right.x(), size), cell(turns - std::floor(turns), size / 16.0),
                          cell(place.slope_rad, 0.4 * size))
                 .second)
            continue;
        kept.push_back(place);
        if (static_cast<int>(kept.size()) >= options_.breadth) break;
    }
    steps_.push_back(std::move(kept));
}

// Where lines pass near a place in both eyes, it moves to them across its way.
void EndToEndSearch::snap(Place& place) const {
    const double sigma_m = options_.snap_m;
    Eigen::Matrix3d H = Eigen::Matrix3d::Identity() / (sigma_m * sigma_m);
    Vector3d g = Vector3d::Zero();
    for (std::size_t eye : {0, 1}) {
        Eigen::Matrix<double, 2, 3> J;
        const Vector2d px = camera(eye).project(in_eye(eye, place.p_C), J);
        const std::int32_t i = ridge_at(eye, px);
        if (i < 0) continue;
        const RidgePoint& point = eyes_[eye].map.points[static_cast<std::size_t>(i)];
        const Vector2d normal(-point.tangent.y(), point.tangent.x());
        if (eye == 1) J = (J * rig_.X_RC.linear()).eval();
        const Vector3d across = J.transpose() * normal / options_.line_sigma_px;
        H += across * across.transpose();
        g += across * normal.dot(point.px - px) / options_.line_sigma_px;
    }
    place.p_C += H.ldlt().solve(g);
    for (std::size_t eye : {0, 1}) place.px[eye] = project(eye, place.p_C);
}

// In every direction: nothing is known of how an instrument holds the thread.
void EndToEndSearch::begin(const Vector3d& p_C) {
    steps_.clear();
    std::vector<Place>& first = steps_.emplace_back();
    for (int h = 0; h < kHeadings; ++h)
        for (int s = -3; s <= 3; ++s)
            first.push_back({.p_C = p_C,
                             .heading_rad = 2.0 * std::numbers::pi * h / kHeadings,
                             .slope_rad = kFirstSlope_rad * s,
                             .px = {project(0, p_C), project(1, p_C)}});
}

/// The cheapest of the last places, a step, that is near the goal; into `arrival` if it is cheaper.
void EndToEndSearch::arrive(const Vector3d& goal_C, Arrival& arrival) const {
    const std::vector<Place>& places = steps_.back();
    const auto steps = static_cast<double>(steps_.size() - 1);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const double off_m = (places[i].p_C - goal_C).norm();
        if (off_m > options_.largest_end_off_m) continue;
        const double off = off_m / options_.end_sigma_m;
        const double cost = (places[i].cost + 0.5 * off * off) / steps;
        if (cost < arrival.cost) arrival = {cost, steps_.size() - 1, i};
    }
}

scenes::Polyline EndToEndSearch::way_to(const Arrival& arrival) const {
    scenes::Polyline line;
    std::size_t i = arrival.place;
    for (std::size_t n = arrival.step + 1; n-- > 0;) {
        line.points.push_back(steps_[n][i].p_C);
        i = static_cast<std::size_t>(std::max(0, steps_[n][i].parent));
    }
    std::reverse(line.points.begin(), line.points.end());
    return line;
}

std::optional<scenes::Polyline> EndToEndSearch::find(const StereoFrame& frame, double length_m) {
    check_frame(frame, rig_);
    if (!frame.tips[0] || !frame.tips[1] || !(length_m > 0.0)) return std::nullopt;
    look(frame);
    begin(frame.tips[0]->p_C);
    const Vector3d& goal_C = frame.tips[1]->p_C;
    const double least_m = (1.0 - options_.length_error) * length_m;
    const double most_m = (1.0 + options_.length_error) * length_m;
    Arrival arrival;
    for (double s_m = options_.step_m; s_m <= most_m; s_m += options_.step_m) {
        grow(goal_C, most_m - s_m + options_.largest_end_off_m);
        if (children_.empty()) break;
        keep_best();
        for (Place& place : steps_.back()) snap(place);
        if (s_m >= least_m) arrive(goal_C, arrival);
    }
    if (arrival.cost > options_.dearest) return std::nullopt;
    scenes::Polyline line = way_to(arrival);
    line.points.push_back(goal_C);
    return line;
}

}  // namespace atropos::tracker
