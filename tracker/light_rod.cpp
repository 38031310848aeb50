#include "tracker/light_rod.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>

namespace atropos::tracker {
namespace {

constexpr int kIterations = 20;
constexpr double kTolerance = 1e-6;  ///< of an edge's length
constexpr double kTaut = 0.999;      ///< of the rod's length: no shape is near
constexpr double kFarthest = 0.3;    ///< of the rod's length, that a node moves

/// Inverse of I + stiffness D'D, D second differences, over the nodes that are free.
Eigen::MatrixXd mobility_of(int nodes, double stiffness, LightRod::Held held) {
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(nodes - 2, nodes);
    for (int i = 0; i + 2 < nodes; ++i) D.block<1, 3>(i, i) << 1.0, -2.0, 1.0;
    const Eigen::MatrixXd M = Eigen::MatrixXd::Identity(nodes, nodes) + stiffness * D.transpose() * D;
    const int first = held[0] ? 1 : 0, free = nodes - first - (held[1] ? 1 : 0);
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(nodes, nodes);
    inverse.block(first, first, free, free) =
        M.block(first, first, free, free).llt().solve(Eigen::MatrixXd::Identity(free, free));
    return inverse;
}

}  // namespace

LightRod::LightRod(int nodes, double reach) : nodes_(nodes) {
    if (nodes < 3) throw std::invalid_argument("a rod of fewer than three nodes, expected three or more");
    for (const bool first : {false, true})
        for (const bool last : {false, true})
            mobility_[static_cast<std::size_t>((first ? 1 : 0) + (last ? 2 : 0))] =
                mobility_of(nodes, std::pow(reach * (nodes - 1), 4.0), {first, last});
}

void LightRod::pull(const Eigen::Vector3d& by_m, Held held, Eigen::Matrix3Xd& x) const {
    const Eigen::VectorXd share = mobility(held).rowwise().sum();
    x.noalias() += by_m * share.transpose();
}

bool LightRod::keep_lengths(const Eigen::Matrix3Xd& before, Held held, Eigen::Matrix3Xd& x) const {
    const int edges = nodes_ - 1;
    const Eigen::VectorXd lengths = (before.rightCols(edges) - before.leftCols(edges)).colwise().norm();
    const double length = lengths.sum();
    if (held[0] && held[1] && (x.rightCols<1>() - x.leftCols<1>()).norm() > kTaut * length) return false;
    const Eigen::MatrixXd& W = mobility(held);
    // By pairs of edges: what pulling together the ends of one does to those of the other.
    const Eigen::MatrixXd G = W.topLeftCorner(edges, edges) + W.bottomRightCorner(edges, edges) -
                              W.topRightCorner(edges, edges) - W.bottomLeftCorner(edges, edges);
    Eigen::Matrix3Xd moved = x, tangents(3, edges), pulls(3, nodes_);
    Eigen::VectorXd excess(edges);
    for (int i = 0; i < kIterations; ++i) {
        tangents = moved.rightCols(edges) - moved.leftCols(edges);
        const Eigen::VectorXd now = tangents.colwise().norm();
        if (!(now.minCoeff() > 1e-12)) return false;
        excess = now - lengths;
        if (excess.cwiseAbs().maxCoeff() <= kTolerance * length / edges) {
            x = moved;
            return true;
        }
        tangents.array().rowwise() /= now.array().transpose();
        const Eigen::MatrixXd A = G.cwiseProduct(tangents.transpose() * tangents);
        const Eigen::LLT<Eigen::MatrixXd> llt(A);
        if (llt.info() != Eigen::Success) return false;
        const Eigen::VectorXd tension = llt.solve(excess);
        pulls.setZero();
        pulls.leftCols(edges) += tangents * tension.asDiagonal();
        pulls.rightCols(edges) -= tangents * tension.asDiagonal();
        moved.noalias() += pulls * W;
        if (!((moved - x).colwise().norm().maxCoeff() <= kFarthest * length)) return false;
    }
    return false;
}

}  // namespace atropos::tracker
