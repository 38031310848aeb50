#pragma once

#include <Eigen/Geometry>
#include <cmath>

namespace atropos::sim {

// Energies of a discrete elastic rod (Bergou et al. 2008, 2010), naturally straight, of round section.

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
};

/// Derivatives of |kb|^2 / 2 by the two edges, e0 and e1: with B0 = dkb/de0 = (-2 [e1]x - kb e1^T) / D and
/// B1 = dkb/de1 = (2 [e0]x - kb e0^T) / D, where kb is normal to both, multiplied out.
struct BendingGradient {
    Eigen::Vector3d by_e0, by_e1;  ///< B0^T kb, B1^T kb

    BendingGradient(const CurvatureBinormal& c, const Eigen::Vector3d& e0, const Eigen::Vector3d& e1)
        : by_e0(-(2.0 * c.kb.cross(e1) + c.kb.squaredNorm() * e1) / c.denominator),
          by_e1((2.0 * c.kb.cross(e0) - c.kb.squaredNorm() * e0) / c.denominator) {}
};

/// Gauss-Newton: definite whatever the shape.
struct BendingHessian {
    Eigen::Matrix3d H00, H10, H11;  ///< stiffness times B0^T B0, B1^T B0, B1^T B1

    BendingHessian(const CurvatureBinormal& c, const Eigen::Vector3d& e0, const Eigen::Vector3d& e1,
                   double stiffness) {
        const double scale = stiffness / (c.denominator * c.denominator), kb2 = c.kb.squaredNorm();
        const Eigen::Vector3d f0 = scale * e0, f1 = scale * e1;
        const Eigen::Vector3d a0 = 2.0 * c.kb.cross(f0), a1 = 2.0 * c.kb.cross(f1);
        const Eigen::Vector3d u0 = (kb2 - 4.0) * f0 - a0, u1 = (kb2 - 4.0) * f1 + a1;
        const Eigen::Vector3d u10 = kb2 * f0 - a0, f1_4 = 4.0 * f1;
        H00.noalias() = u1 * e1.transpose() + e1 * a1.transpose();
        H11.noalias() = u0 * e0.transpose() - e0 * a0.transpose();
        H10.noalias() = u10 * e1.transpose() + f1_4 * e0.transpose() + e0 * a1.transpose();
        H00.diagonal().array() += f1_4.dot(e1);
        H11.diagonal().array() += 4.0 * f0.dot(e0);
        H10.diagonal().array() -= f1_4.dot(e0);
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
