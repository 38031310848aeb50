#include "sim/self_contact.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "scenes/capsule.hpp"

namespace atropos::sim {

namespace {

constexpr int kBlock = 8;    // edges a bounding box of the broad phase
constexpr int kSweeps = 60;  // of projected Gauss-Seidel
constexpr int kMinEdgesApart = 3;
constexpr double kMinDiametersApart = 1.5;

struct Box {
    Eigen::Vector3d low, high;
};

std::vector<Box> block_boxes(const std::vector<Eigen::Vector3d>& x, int edges) {
    std::vector<Box> boxes;
    for (int start = 0; start < edges; start += kBlock) {
        Box box{x[static_cast<size_t>(start)], x[static_cast<size_t>(start)]};
        for (int i = start + 1; i <= std::min(start + kBlock, edges); ++i) {
            box.low = box.low.cwiseMin(x[static_cast<size_t>(i)]);
            box.high = box.high.cwiseMax(x[static_cast<size_t>(i)]);
        }
        boxes.push_back(box);
    }
    return boxes;
}

bool apart(const Box& a, const Box& b, double reach_m) {
    return ((a.low - b.high).array() > reach_m).any() || ((b.low - a.high).array() > reach_m).any();
}

}  // namespace

std::vector<EdgePair> near_edge_pairs(const ThreadState& state, const std::vector<Eigen::Vector3d>& x,
                                      double diameter_m, double reach_m) {
    const int edges = state.edge_count();
    const std::vector<Box> boxes = block_boxes(x, edges);
    struct Ball {  // around an edge
        Eigen::Vector3d centre;
        double radius_m;
    };
    std::vector<Ball> balls;
    balls.reserve(x.size());
    for (size_t i = 0; i + 1 < x.size(); ++i)
        balls.push_back({0.5 * (x[i] + x[i + 1]), 0.5 * (x[i + 1] - x[i]).norm()});
    std::vector<EdgePair> pairs;
    const auto consider = [&](int a, int b) {
        const auto ia = static_cast<size_t>(a), ib = static_cast<size_t>(b);
        const double reach = reach_m + balls[ia].radius_m + balls[ib].radius_m;
        if ((balls[ia].centre - balls[ib].centre).squaredNorm() >= reach * reach) return;
        if (!state.has_edge(a) || !state.has_edge(b)) return;
        // Along the material, so that the two faces of a fresh cut do not count as thread through thread.
        if (state.s_m[ib] - state.s_m[ia + 1] < kMinDiametersApart * diameter_m) return;
        pairs.push_back({a, b});
    };
    const int blocks = static_cast<int>(boxes.size());
    for (int p = 0; p < blocks; ++p)
        for (int q = p; q < blocks; ++q) {
            if (apart(boxes[static_cast<size_t>(p)], boxes[static_cast<size_t>(q)], reach_m)) continue;
            for (int a = p * kBlock; a < std::min((p + 1) * kBlock, edges); ++a)
                for (int b = std::max(q * kBlock, a + kMinEdgesApart); b < std::min((q + 1) * kBlock, edges);
                     ++b)
                    consider(a, b);
        }
    std::sort(pairs.begin(), pairs.end(),
              [](const EdgePair& l, const EdgePair& r) { return l.a != r.a ? l.a < r.a : l.b < r.b; });
    return pairs;
}

EdgeApproach edge_approach(const std::vector<Eigen::Vector3d>& x, const EdgePair& pair) {
    const auto a = static_cast<size_t>(pair.a), b = static_cast<size_t>(pair.b);
    const scenes::SegmentDistance d = scenes::segment_distance(x[a], x[a + 1], x[b], x[b + 1]);
    const Eigen::Vector3d w = (1 - d.s) * x[a] + d.s * x[a + 1] - (1 - d.t) * x[b] - d.t * x[b + 1];
    return {d.s, d.t, w, d.distance_m};
}

void SelfContactSolver::find(const std::vector<Eigen::Vector3d>& x,
                             const std::vector<Eigen::Vector3d>& x_start, double diameter_m,
                             double margin_m) {
    previous_.swap(contacts_);
    contacts_.clear();
    size_t known = 0;
    for (const EdgePair& pair : near_) {
        const EdgeApproach at = edge_approach(x, pair);
        if (at.distance_m > diameter_m + margin_m || at.distance_m < 1e-3 * diameter_m) continue;
        Contact contact;
        contact.pair = pair;
        contact.s = at.s;
        contact.t = at.t;
        const Eigen::Vector3d n = at.from_b_to_a / at.distance_m;
        int small = 0;
        n.cwiseAbs().minCoeff(&small);
        const Eigen::Vector3d t1 = n.cross(Eigen::Vector3d::Unit(small)).normalized();
        contact.axes.row(0) = n;
        contact.axes.row(1) = t1;
        contact.axes.row(2) = n.cross(t1);
        contact.gap_m = at.distance_m - diameter_m;
        const auto moved = [&](int node) {
            return x[static_cast<size_t>(node)] - x_start[static_cast<size_t>(node)];
        };
        contact.slid = (1 - at.s) * moved(pair.a) + at.s * moved(pair.a + 1) - (1 - at.t) * moved(pair.b) -
                       at.t * moved(pair.b + 1);
        while (known < previous_.size() &&
               (previous_[known].pair.a < pair.a ||
                (previous_[known].pair.a == pair.a && previous_[known].pair.b < pair.b)))
            ++known;
        if (known < previous_.size() && previous_[known].pair == pair) {
            const Eigen::Vector3d force_W = previous_[known].axes.transpose() * previous_[known].lambda;
            contact.lambda = contact.axes * force_W;
        }
        contacts_.push_back(contact);
    }
}

namespace {

struct Lever {
    int node;
    double weight;
};
std::array<Lever, 4> levers(const SelfContactSolver::Contact& c) {
    return {{{c.pair.a, 1 - c.s}, {c.pair.a + 1, c.s}, {c.pair.b, -(1 - c.t)}, {c.pair.b + 1, -c.t}}};
}

/// Projects onto the friction cone: normal pull is none, tangential force at most friction times normal.
Eigen::Vector3d onto_cone(const Eigen::Vector3d& lambda, double friction) {
    const double normal = std::max(lambda[0], 0.0);
    Eigen::Vector3d result(normal, lambda[1], lambda[2]);
    const double tangential = std::hypot(lambda[1], lambda[2]);
    if (tangential > friction * normal) result.tail<2>() *= friction * normal / tangential;
    return result;
}

}  // namespace

Eigen::VectorXd SelfContactSolver::solve(const BandedLdlt& matrix, const Eigen::VectorXd& free_step,
                                         double friction, const std::vector<char>& fixed) {
    const int n = count(), rows = 3 * n, width = (rows + 3) / 4 * 4;
    columns_.assign(static_cast<size_t>(matrix.rows()) * static_cast<size_t>(width), 0.0);
    int first_node = matrix.rows();
    const auto column = [&](int node, int axis) {
        return columns_.data() + static_cast<std::ptrdiff_t>(3 * node + axis) * width;
    };
    for (int c = 0; c < n; ++c) {
        const Contact& contact = contacts_[static_cast<size_t>(c)];
        for (const Lever& lever : levers(contact)) {
            first_node = std::min(first_node, lever.node);
            if (fixed[static_cast<size_t>(lever.node)]) continue;
            for (int axis = 0; axis < 3; ++axis)
                for (int r = 0; r < 3; ++r)
                    column(lever.node, axis)[3 * c + r] += lever.weight * contact.axes(r, axis);
        }
    }
    matrix.solve(columns_, width, 3 * first_node);

    delassus_.setZero(rows, width);
    Eigen::VectorXd offset(rows), lambda(width);
    lambda.setZero();
    for (int c = 0; c < n; ++c) {
        const Contact& contact = contacts_[static_cast<size_t>(c)];
        Eigen::Vector3d displacement = contact.slid;
        for (const Lever& lever : levers(contact)) {
            displacement += lever.weight * free_step.segment<3>(3 * lever.node);
            if (fixed[static_cast<size_t>(lever.node)]) continue;
            for (int axis = 0; axis < 3; ++axis) {
                const Eigen::Map<const Eigen::RowVectorXd> z(column(lever.node, axis), width);
                for (int r = 0; r < 3; ++r)
                    delassus_.row(3 * c + r) += lever.weight * contact.axes(r, axis) * z;
            }
        }
        offset.segment<3>(3 * c) = contact.axes * displacement;
        offset[3 * c] = contact.gap_m + contact.axes.row(0).dot(displacement - contact.slid);
        lambda.segment<3>(3 * c) = contact.lambda;
    }

    for (int sweep = 0; sweep < kSweeps; ++sweep) {
        double change = 0.0, size = 0.0;
        for (int c = 0; c < n; ++c) {
            Eigen::Vector3d now = lambda.segment<3>(3 * c);
            const Eigen::Vector3d before = now;
            Eigen::Vector3d residual;
            for (int r = 0; r < 3; ++r)
                residual[r] = offset[3 * c + r] + delassus_.row(3 * c + r).dot(lambda);
            // Normal first, then both tangents with the larger of their pivots, which keeps friction
            // isotropic.
            const Eigen::Matrix3d block = delassus_.block<3, 3>(3 * c, 3 * c);
            now[0] = std::max(0.0, now[0] - residual[0] / std::max(block(0, 0), 1e-300));
            residual.tail<2>() += block.block<2, 1>(1, 0) * (now[0] - before[0]);
            const double pivot = std::max({block(1, 1), block(2, 2), 1e-300});
            now.tail<2>() -= residual.tail<2>() / pivot;
            now = onto_cone(now, friction);
            lambda.segment<3>(3 * c) = now;
            change += (now - before).squaredNorm();
            size += now.squaredNorm();
        }
        if (change <= 1e-12 * size) break;
    }

    Eigen::VectorXd force = Eigen::VectorXd::Zero(matrix.rows());
    for (int c = 0; c < n; ++c) {
        Contact& contact = contacts_[static_cast<size_t>(c)];
        contact.lambda = lambda.segment<3>(3 * c);
        const Eigen::Vector3d force_W = contact.axes.transpose() * contact.lambda;
        for (const Lever& lever : levers(contact)) force.segment<3>(3 * lever.node) += lever.weight * force_W;
    }
    return force;
}

}  // namespace atropos::sim
