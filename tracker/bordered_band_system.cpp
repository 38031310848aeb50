#include "tracker/bordered_band_system.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {

BorderedBandSystem::BorderedBandSystem(int control_points, int border)
    : n_(3 * control_points),
      A_(static_cast<std::size_t>(n_)),
      L_(static_cast<std::size_t>(n_)),
      g_(n_),
      B_(n_, border),
      Y_(n_, border),
      h_(border),
      C_(border, border),
      schur_inverse_(border, border) {
    set_zero();
}

void BorderedBandSystem::set_zero() {
    for (auto& row : A_) row.fill(0.0);
    g_.setZero();
    B_.setZero();
    C_.setZero();
    h_.setZero();
}

void BorderedBandSystem::add(int first_control_point, const Block& J, double r, double weight) {
    const int at = 3 * first_control_point;
    for (int i = 0; i < kBand; ++i) {
        const double w = weight * J[i];
        auto& row = A_[static_cast<std::size_t>(at + i)];
        for (int j = 0; j <= i; ++j) row[static_cast<std::size_t>(kBand - 1 - i + j)] += w * J[j];
        g_[at + i] -= w * r;
    }
}

void BorderedBandSystem::add(int first_control_point, const Block& J, const Border& border_J, double r,
                             double weight) {
    add(first_control_point, J, r, weight);
    for (int c = 0; c < border(); ++c) {
        const double w = weight * border_J[c];
        if (w == 0.0) continue;
        B_.col(c).segment<kBand>(3 * first_control_point) += w * J;
        C_.col(c) += w * border_J;
        h_[c] -= w * r;
    }
}

void BorderedBandSystem::add_border(const BorderMatrix& information, const Border& error) {
    C_ += information;
    h_.noalias() -= information * error;
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

template <class Column>
void BorderedBandSystem::substitute(Column&& x) const {
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

// Factors A and inverts what is left of C without the curve.
bool BorderedBandSystem::eliminate_curve(double damping) {
    if (!factor(damping)) return false;
    Y_ = B_;
    for (int c = 0; c < border(); ++c) substitute(Y_.col(c));
    BorderMatrix schur = C_ - B_.transpose() * Y_;
    schur.diagonal() += damping * C_.diagonal();
    const Eigen::LLT<BorderMatrix> llt(schur);
    if (llt.info() != Eigen::Success) return false;
    schur_inverse_ = llt.solve(BorderMatrix::Identity(border(), border()));
    return schur_inverse_.allFinite();
}

bool BorderedBandSystem::solve(double damping, Eigen::VectorXd& step, Border& border_step) {
    if (!eliminate_curve(damping)) return false;
    step = g_;
    substitute(step);
    border_step = schur_inverse_ * (h_ - B_.transpose() * step);
    step.noalias() -= Y_ * border_step;
    return step.allFinite() && border_step.allFinite();
}

bool BorderedBandSystem::covariance(Covariance& out) {
    if (!eliminate_curve(0.0)) return false;
    // Forward substitution of unit vectors gives L^-1; the inverse is its own transpose times itself.
    out.curve.setZero(n_, n_);
    for (int j = 0; j < n_; ++j) {
        auto column = out.curve.col(j);
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
    out.border = schur_inverse_;
    out.across.noalias() = -Y_ * schur_inverse_;
    out.curve.noalias() -= out.across * Y_.transpose();
    return true;
}

}  // namespace atropos::tracker
