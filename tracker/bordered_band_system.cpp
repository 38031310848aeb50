#include "tracker/bordered_band_system.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {

BorderedBandSystem::BorderedBandSystem(int control_points)
    : n_(3 * control_points),
      A_(static_cast<std::size_t>(n_)),
      L_(static_cast<std::size_t>(n_)),
      b_(n_),
      g_(n_),
      y_(n_) {
    set_zero();
}

void BorderedBandSystem::set_zero() {
    for (auto& row : A_) row.fill(0.0);
    b_.setZero();
    g_.setZero();
    c_ = h_ = 0.0;
}

void BorderedBandSystem::add(int first_control_point, const Block& J, double border_J, double r,
                             double weight) {
    const int at = 3 * first_control_point;
    for (int i = 0; i < kBand; ++i) {
        const double w = weight * J[i];
        auto& row = A_[static_cast<std::size_t>(at + i)];
        for (int j = 0; j <= i; ++j) row[static_cast<std::size_t>(kBand - 1 - i + j)] += w * J[j];
        g_[at + i] -= w * r;
        b_[at + i] += w * border_J;
    }
    c_ += weight * border_J * border_J;
    h_ -= weight * border_J * r;
}

bool BorderedBandSystem::factor(double damping) {
    for (int i = 0; i < n_; ++i) {
        auto& row = L_[static_cast<std::size_t>(i)];
        row = A_[static_cast<std::size_t>(i)];
        row[kBand - 1] *= 1.0 + damping;
        for (int j = std::max(0, i - kBand + 1); j <= i; ++j) {
            const auto& other = L_[static_cast<std::size_t>(j)];
            double sum = row[static_cast<std::size_t>(kBand - 1 - i + j)];
            for (int k = std::max(0, i - kBand + 1); k < j; ++k)
                sum -= row[static_cast<std::size_t>(kBand - 1 - i + k)] *
                       other[static_cast<std::size_t>(kBand - 1 - j + k)];
            if (j < i) {
                row[static_cast<std::size_t>(kBand - 1 - i + j)] = sum / other[kBand - 1];
            } else {
                if (!(sum > 0.0)) return false;
                row[kBand - 1] = std::sqrt(sum);
            }
        }
    }
    return true;
}

void BorderedBandSystem::substitute(Eigen::VectorXd& x) const {
    for (int i = 0; i < n_; ++i) {
        const auto& row = L_[static_cast<std::size_t>(i)];
        double sum = x[i];
        for (int k = std::max(0, i - kBand + 1); k < i; ++k)
            sum -= row[static_cast<std::size_t>(kBand - 1 - i + k)] * x[k];
        x[i] = sum / row[kBand - 1];
    }
    for (int i = n_ - 1; i >= 0; --i) {
        const auto& row = L_[static_cast<std::size_t>(i)];
        x[i] /= row[kBand - 1];
        for (int k = std::max(0, i - kBand + 1); k < i; ++k)
            x[k] -= row[static_cast<std::size_t>(kBand - 1 - i + k)] * x[i];
    }
}

bool BorderedBandSystem::solve(double damping, Eigen::VectorXd& step, double& border_step) {
    if (!factor(damping)) return false;
    step = g_;
    substitute(step);
    y_ = b_;
    substitute(y_);
    const double schur = c_ * (1.0 + damping) - b_.dot(y_);
    if (!(schur > 0.0)) return false;
    border_step = (h_ - b_.dot(step)) / schur;
    step -= border_step * y_;
    return step.allFinite() && std::isfinite(border_step);
}

bool BorderedBandSystem::covariance(Eigen::MatrixXd& covariance, double& border_variance) {
    if (!factor(0.0)) return false;
    y_ = b_;
    substitute(y_);
    const double schur = c_ - b_.dot(y_);
    if (!(schur > 0.0)) return false;
    border_variance = 1.0 / schur;
    // Forward substitution of unit vectors gives L^-1; the inverse is its own transpose times itself.
    covariance.setZero();
    for (int j = 0; j < n_; ++j) {
        auto column = covariance.col(j);
        column[j] = 1.0 / L_[static_cast<std::size_t>(j)][kBand - 1];
        for (int i = j + 1; i < n_; ++i) {
            const auto& row = L_[static_cast<std::size_t>(i)];
            double sum = 0.0;
            for (int k = std::max(j, i - kBand + 1); k < i; ++k)
                sum -= row[static_cast<std::size_t>(kBand - 1 - i + k)] * column[k];
            column[i] = sum / row[kBand - 1];
        }
        for (int i = n_ - 1; i >= 0; --i) {
            const auto& row = L_[static_cast<std::size_t>(i)];
            column[i] /= row[kBand - 1];
            for (int k = std::max(0, i - kBand + 1); k < i; ++k)
                column[k] -= row[static_cast<std::size_t>(kBand - 1 - i + k)] * column[i];
        }
    }
    covariance.noalias() += border_variance * y_ * y_.transpose();
    return true;
}

}  // namespace atropos::tracker
