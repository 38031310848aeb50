#include "tracker/discrete_search.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "tracker/label_set.hpp"

namespace atropos::tracker {
namespace {

double ms_since(std::chrono::steady_clock::time_point begin) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

DiscreteSearch::DiscreteSearch(scenes::TrackerMethod method, scenes::LabelOptimiser optimiser,
                               const scenes::TrackerConfig::Labels& labels, int control_points,
                               int labels_per_node)
    : options_(labels),
      node_labels_(control_points, labels_per_node),
      chain_(control_points, labels_per_node),
      optimiser_(make_chain_optimiser(optimiser)),
      unit_labels_(label_set(labels.r, 1.0)),
      scaled_(unit_labels_.size()) {
    if (method == scenes::TrackerMethod::kE1)
        potentials_ = std::make_unique<PotentialsE1>();
    else
        potentials_ = std::make_unique<PotentialsE2>();
    // Along each direction the labels come in pairs of growing distance: the last pair of r.
    for (int l = 2 * labels.r - 1; l < labels_per_node; l += 2 * labels.r)
        outermost_.insert(outermost_.end(), {l, l + 1});
}

void DiscreteSearch::place_labels(std::span<const Eigen::Vector3d> control_points, double s_m,
                                  const std::array<Eye, 2>& eyes) {
    same_at_every_node_ = options_.shape == scenes::LabelShape::kCube;
    for (std::size_t k = 0; k < control_points.size(); ++k) {
        const Eigen::Matrix3d axes = options_.shape == scenes::LabelShape::kRays
                                         ? ray_axes(control_points[k], options_.depth_factor)
                                         : Eigen::Matrix3d::Identity();
        for (std::size_t l = 0; l < scaled_.size(); ++l) scaled_[l] = axes * (s_m * unit_labels_[l]);
        node_labels_.set(static_cast<int>(k), scaled_, eyes);
    }
}

cv::Rect DiscreteSearch::reach(const EnergyContext& context, std::size_t eye_index,
                               std::span<const Eigen::Vector3d> control_points, int j) const {
    const Eye& eye = context.eyes[eye_index];
    const Eigen::Vector3d seen = context.seen(eye_index, control_points, j);
    Eigen::Vector2d low = eye.pixel(seen);
    Eigen::Vector2d high = low;
    for (int k = 0, placed = 0; k < context.sampling.control_points(); ++k) {
        if (context.sampling.R(k, j) == 0.0 || (same_at_every_node_ && placed++ > 0)) continue;
        for (const int l : outermost_) {
            const Eigen::Vector2d pixel = eye.pixel(seen + node_labels_.seen(k, l, eye_index));
            low = low.cwiseMin(pixel);
            high = high.cwiseMax(pixel);
        }
    }
    // A lens bends the hull's edges a little; floats round. Far outside any image is far enough.
    Eigen::Vector2d margin(1.0, 1.0);
    if (eye.is_distorted()) margin += 0.1 * (high - low);
    const auto clamped = [](double value) { return static_cast<int>(std::clamp(value, -1e6, 1e6)); };
    const int x0 = clamped(std::floor(low.x() - margin.x())), y0 = clamped(std::floor(low.y() - margin.y()));
    return {x0, y0, clamped(std::ceil(high.x() + margin.x())) - x0 + 1,
            clamped(std::ceil(high.y() + margin.y())) - y0 + 1};
}

double DiscreteSearch::minimise(const EnergyContext& context, scenes::WorkerPool& pool,
                                std::vector<Eigen::Vector3d>& control_points, std::span<int> labelling,
                                StageTimings& timings) {
    const auto begin = std::chrono::steady_clock::now();
    potentials_->fill(context, control_points, node_labels_, pool, chain_);
    timings.potentials_ms += ms_since(begin);

    const auto filled = std::chrono::steady_clock::now();
    const double cost = optimiser_->minimise(chain_, labelling);
    for (std::size_t k = 0; k < control_points.size(); ++k)
        control_points[k] += node_labels_.displacement(static_cast<int>(k), labelling[k]);
    timings.optimiser_ms += ms_since(filled);
    return cost;
}

void show_step(TrackObserver& observer, int step, const DiscreteSearch& search,
               std::span<const int> labelling, std::span<const Eigen::Vector3d> control_points) {
    observer.curve("step " + std::to_string(step), control_points);
    ChainDp exact;
    const std::span<const float> marginals = exact.min_marginals(search.chain());
    for (std::size_t k = 0; k < labelling.size(); ++k) {
        const std::size_t label = static_cast<std::size_t>(labelling[k]);
        observer.node(
            step, static_cast<int>(k), labelling[k],
            search.labels().displacement(static_cast<int>(k), labelling[k]),
            static_cast<double>(marginals[k * static_cast<std::size_t>(search.chain().stride()) + label]));
    }
}

}  // namespace atropos::tracker
