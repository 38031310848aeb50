#pragma once

#include <Eigen/Core>
#include <array>

#include "tracker/eye_correction.hpp"

namespace atropos::tracker {

/// What is unknown beside the curve, and hardly changes from frame to frame: what the two arms measure their
/// ends off by, what the right eye is off by, and the thread's length.
struct Nuisances {
    /// Where each begins in `vector()`.
    enum At { kTip0 = 0, kTip1 = 3, kRow = 6, kRoll = 7, kLength = 8, kCount = 9 };
    using Vector = Eigen::Matrix<double, kCount, 1>;
    using Matrix = Eigen::Matrix<double, kCount, kCount>;

    std::array<Eigen::Vector3d, 2> tip_bias_C = {Eigen::Vector3d::Zero(),
                                                 Eigen::Vector3d::Zero()};  ///< added to what is measured, m
    EyeCorrection eye;
    double length_m = 0.0;

    static constexpr int tip(std::size_t end) { return end == 0 ? kTip0 : kTip1; }

    Vector vector() const {
        Vector v;
        v << tip_bias_C[0], tip_bias_C[1], eye.row_px, eye.roll_rad, length_m;
        return v;
    }
    static Nuisances from(const Vector& v) {
        return {{v.segment<3>(kTip0), v.segment<3>(kTip1)}, {v[kRow], v[kRoll]}, v[kLength]};
    }
};

/// What is known of them before a frame.
struct NuisancePrior {
    Nuisances mean;
    Nuisances::Matrix information = 1e18 * Nuisances::Matrix::Identity();
};

}  // namespace atropos::tracker
