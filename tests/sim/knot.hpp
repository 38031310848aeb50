#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace atropos::sim::testing {

/// Knot determinant |Alexander(-1)| of an open curve whose ends are led far away and joined: 1 unknot, 3
/// trefoil, 9 square or granny knot. From the colouring matrix of one projection: 2 over - under - under at
/// each crossing.
inline int knot_determinant(std::vector<Eigen::Vector3d> p, const Eigen::Vector3d& view) {
    const Eigen::Vector3d w = view.normalized(), u = w.unitOrthogonal(), v = w.cross(u);
    for (auto& q : p) q = Eigen::Vector3d(q.dot(u), q.dot(v), q.dot(w)).eval();
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    double size = 0.0;
    for (const auto& q : p) centre += q / double(p.size());
    for (const auto& q : p) size = std::max(size, (q - centre).norm());
    // Out from both ends, over to the side at a height that clears everything, and together.
    const Eigen::Vector3d a = p.front() + 5 * size * (p.front() - p.back()).normalized();
    const Eigen::Vector3d b = p.back() + 5 * size * (p.back() - p.front()).normalized();
    const Eigen::Vector3d side = 40 * size * Eigen::Vector3d(0.31, 0.83, 20.0);
    p.insert(p.begin(), a);
    p.push_back(b);
    p.push_back(centre + side);
    const size_t n = p.size();
    struct Pass {
        double at;
        int crossing;
        bool over;
    };
    std::vector<Pass> passes;
    int crossings = 0;
    for (size_t i = 0; i < n; ++i)
        for (size_t j = i + 2; j < n; ++j) {
            if (i == 0 && j + 1 == n) continue;
            const Eigen::Vector3d &a0 = p[i], &a1 = p[(i + 1) % n], &b0 = p[j], &b1 = p[(j + 1) % n];
            const Eigen::Vector3d d = a1 - a0, e = b1 - b0, r = b0 - a0;
            const double den = d.x() * e.y() - d.y() * e.x();
            if (den == 0.0) continue;
            const double s = (r.x() * e.y() - r.y() * e.x()) / den, t = (r.x() * d.y() - r.y() * d.x()) / den;
            if (s < 0 || s >= 1 || t < 0 || t >= 1) continue;
            const bool first_over = a0.z() + s * d.z() > b0.z() + t * e.z();
            passes.push_back({double(i) + s, crossings, first_over});
            passes.push_back({double(j) + t, crossings, !first_over});
            ++crossings;
        }
    if (crossings == 0) return 1;
    std::sort(passes.begin(), passes.end(), [](const Pass& l, const Pass& r) { return l.at < r.at; });
    std::vector<int> over(static_cast<size_t>(crossings)), in(over), out(over);
    int arc = 0;
    for (const Pass& pass : passes) {
        const auto c = static_cast<size_t>(pass.crossing);
        if (pass.over) {
            over[c] = arc;
        } else {
            in[c] = arc;
            arc = (arc + 1) % crossings;
            out[c] = arc;
        }
    }
    // Each under-pass ends an arc, so there are as many arcs as crossings.
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(crossings, crossings);
    for (int c = 0; c < crossings; ++c) {
        m(c, over[static_cast<size_t>(c)]) += 2;
        m(c, in[static_cast<size_t>(c)]) -= 1;
        m(c, out[static_cast<size_t>(c)]) -= 1;
    }
    if (crossings == 1) return 1;
    return static_cast<int>(
        std::lround(std::abs(m.topLeftCorner(crossings - 1, crossings - 1).determinant())));
}

}  // namespace atropos::sim::testing
