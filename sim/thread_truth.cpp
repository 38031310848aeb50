#include "sim/thread_truth.hpp"

#include <algorithm>

namespace atropos::sim {

using Eigen::Vector3d;

namespace {

/// dp/ds at node i of the parabola through it and its neighbours (or the three last ones at an end).
Vector3d derivative(const std::vector<Vector3d>& p, const std::vector<double>& s, size_t i) {
    const size_t n = p.size();
    if (n < 3) return (p[1] - p[0]) / (s[1] - s[0]);
    const size_t m = std::clamp<size_t>(i, 1, n - 2);
    const double h0 = s[m] - s[m - 1], h1 = s[m + 1] - s[m];
    const Vector3d d0 = (p[m] - p[m - 1]) / h0, d1 = (p[m + 1] - p[m]) / h1;
    const Vector3d bend = (d1 - d0) / (h0 + h1);
    if (i == m - 1) return d0 - h0 * bend;
    if (i == m + 1) return d1 + h1 * bend;
    return d0 + h0 * bend;
}

struct Hermite {
    size_t i;
    double u, h;
    Vector3d a, b;
    Hermite(const Strand& strand, double s_m) {
        const std::vector<double>& s = strand.s_m;
        const double clamped = std::clamp(s_m, s.front(), s.back());
        const auto above = std::upper_bound(s.begin(), s.end(), clamped) - s.begin();
        i = static_cast<size_t>(
            std::clamp<std::ptrdiff_t>(above - 1, 0, static_cast<std::ptrdiff_t>(s.size()) - 2));
        h = s[i + 1] - s[i];
        u = (clamped - s[i]) / h;
        a = h * derivative(strand.p_W, s, i);
        b = h * derivative(strand.p_W, s, i + 1);
    }
};

}  // namespace

std::vector<Vector3d> node_tangents(const std::vector<Vector3d>& p, const std::vector<double>& s_m) {
    std::vector<Vector3d> tangents;
    for (size_t i = 0; i < p.size(); ++i) tangents.push_back(derivative(p, s_m, i).normalized());
    return tangents;
}

Vector3d ThreadTruth::sample(int strand, double s_m) const {
    const Strand& piece = strands.at(static_cast<size_t>(strand));
    const Hermite c(piece, s_m);
    const double u = c.u, v = 1.0 - u;
    return v * v * (1 + 2 * u) * piece.p_W[c.i] + u * u * (1 + 2 * v) * piece.p_W[c.i + 1] + u * v * v * c.a -
           u * u * v * c.b;
}

Vector3d ThreadTruth::tangent(int strand, double s_m) const {
    const Strand& piece = strands.at(static_cast<size_t>(strand));
    const Hermite c(piece, s_m);
    const double u = c.u, v = 1.0 - u;
    const Vector3d chord = piece.p_W[c.i + 1] - piece.p_W[c.i];
    return (6 * u * v * chord + v * (v - 2 * u) * c.a + u * (u - 2 * v) * c.b).normalized();
}

double ThreadTruth::tension_N(int strand, double s_m) const {
    const Strand& piece = strands.at(static_cast<size_t>(strand));
    const Hermite c(piece, s_m);
    return (1.0 - c.u) * piece.tension_N[c.i] + c.u * piece.tension_N[c.i + 1];
}

int ThreadTruth::strand_at(double s_m) const {
    for (size_t k = 0; k < strands.size(); ++k)
        if (s_m <= strands[k].s_m.back()) return static_cast<int>(k);
    return static_cast<int>(strands.size()) - 1;
}

}  // namespace atropos::sim
