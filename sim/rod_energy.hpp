#pragma once

#include <Eigen/Geometry>
#include <cmath>

namespace atropos::sim {

// Energies of a discrete elastic rod (Bergou et al. 2008, 2010), naturally straight, of round section.

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) {
    Eigen::Matrix3d m;
    m << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    return m;
}

/// Stretching of one edge: energy EA/2 (|e|/l - 1)^2 l.
struct Stretch {
    Eigen::Vector3d force;  ///< dE/de, along the edge: its tension
    double along;           ///< stiffness along the edge
    double across;          ///< stiffness across it, never negative so that the Hessian stays definite
    Eigen::Vector3d direction;

    Stretch(const Eigen::Vector3d& e, double rest_m, double EA_N) {
        const double length = e.norm();
        direction = e / length;
        const double tension = EA_N * (length / rest_m - 1.0);
        force = tension * direction;
        along = EA_N / rest_m;
        across = std::max(tension, 0.0) / length;
    }
    static double energy(const Eigen::Vector3d& e, double rest_m, double EA_N) {
        const double strain = e.norm() / rest_m - 1.0;
        return 0.5 * EA_N * strain * strain * rest_m;
    }
    Eigen::Matrix3d hessian() const {
        return (along - across) * direction * direction.transpose() + across * Eigen::Matrix3d::Identity();
    }
};

/// Curvature binormal at the node between two edges, kb = 2 e0 x e1 / (l0 l1 + e0 . e1), and its derivatives.
/// Rest lengths stand in the denominator: the thread hardly stretches, and the derivative stays short.
struct CurvatureBinormal {
    Eigen::Vector3d kb;
    double denominator;

    CurvatureBinormal(const Eigen::Vector3d& e0, const Eigen::Vector3d& e1, double l0, double l1) {
        // A fold back onto itself would divide by zero; 4 % of l0 l1 is a turn of 163 degrees at one node.
        denominator = std::max(l0 * l1 + e0.dot(e1), 0.04 * l0 * l1);
        kb = 2.0 * e0.cross(e1) / denominator;
    }
    Eigen::Matrix3d by_e0(const Eigen::Vector3d& e1) const {
        return (-2.0 * cross_matrix(e1) - kb * e1.transpose()) / denominator;
    }
    Eigen::Matrix3d by_e1(const Eigen::Vector3d& e0) const {
        return (2.0 * cross_matrix(e0) - kb * e0.transpose()) / denominator;
    }
};

/// Carries `m` from a curve's tangent `t0` to `t1` without turning about either (parallel transport).
inline Eigen::Vector3d transport(const Eigen::Vector3d& m, const Eigen::Vector3d& t0,
                                 const Eigen::Vector3d& t1) {
    const Eigen::Vector3d b = t0.cross(t1);
    const double d = 1.0 + t0.dot(t1);
    if (d < 1e-9) return m;
    return m + b.cross(m) + b.cross(b.cross(m)) / d;
}

/// Angle from `a` to `b` about the unit axis `t`, in (-pi, pi].
inline double signed_angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& t) {
    return std::atan2(a.cross(b).dot(t), a.dot(b) - a.dot(t) * b.dot(t));
}

}  // namespace atropos::sim
