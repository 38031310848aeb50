#include "tracker/thread_initialiser.hpp"

#include "tracker/start_descent.hpp"

namespace atropos::tracker {
namespace {

constexpr double kMinimumSupport = 0.5;  // of the samples, for a curve to count as found
constexpr double kPreferBulge = 0.1;     // of the samples
constexpr std::size_t kBulgeFirstLevel =
    2;  // a good bulge is near: the far-reaching labels would only lose it

}  // namespace

std::vector<Eigen::Vector3d> straight_line(int degree, int control_points, const Eigen::Vector3d& from,
                                           const Eigen::Vector3d& to) {
    const BsplineBasis basis(degree, control_points);
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < control_points; ++k) {
        double abscissa = 0.0;  // Greville's: control points there give C(u) = from + u (to - from)
        for (int i = 1; i <= degree; ++i) abscissa += basis.knots()[static_cast<std::size_t>(k + i)] / degree;
        points.emplace_back(from + abscissa * (to - from));
    }
    return points;
}

std::optional<std::vector<Eigen::Vector3d>> initial_curve_between_tips(const scenes::TrackerConfig& config,
                                                                       const scenes::StereoRig& rig,
                                                                       const StereoFrame& frame,
                                                                       scenes::WorkerPool& pool,
                                                                       std::size_t levels) {
    if (!frame.tips[0] || !frame.tips[1]) return std::nullopt;
    const Eigen::Vector3d& from = frame.tips[0]->p_C;
    const Eigen::Vector3d& to = frame.tips[1]->p_C;
    StartDescent descent(config, rig, frame, levels, pool);
    const std::vector<Eigen::Vector3d> line =
        straight_line(config.curve.degree, config.curve.control_points, from, to);
    const StartDescent::Found straight = descent.run(line, 0);
    StartDescent::Found best;
    if (config.thread.length_m > (to - from).norm())
        for (const std::vector<Eigen::Vector3d>& bulge : descent.best_bulges(line)) {
            StartDescent::Found found = descent.run(bulge, kBulgeFirstLevel);
            if (found.energy < best.energy) best = std::move(found);
        }
    // What began as a straight line may have bent in depth where nothing is seen of that: a bulge hangs in a
    // plane.
    if (straight.seen > best.seen + kPreferBulge) best = straight;
    if (best.seen < kMinimumSupport) return std::nullopt;
    return best.curve;
}

}  // namespace atropos::tracker
