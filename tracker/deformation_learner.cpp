#include "tracker/deformation_learner.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <stdexcept>
#include <string>

namespace atropos::tracker {
namespace {

constexpr int kSettled = 3;  ///< frames of a track until its velocity is known

/// The displacement in the thread's frame; `flip` z, and from the other end.
Eigen::VectorXd seen_as(const Eigen::Matrix3Xd& d, bool mirrored, bool reversed) {
    Eigen::Matrix3Xd seen = d;
    if (reversed) {
        seen = d.rowwise().reverse().eval();
        seen.row(0) *= -1.0;
    }
    if (mirrored) seen.row(2) *= -1.0;
    return seen.reshaped();
}

}  // namespace

DeformationLearner::DeformationLearner(int control_points)
    : K_(control_points), scatter_(Eigen::MatrixXd::Zero(3 * control_points, 3 * control_points)) {
    motion_.velocity_m_s.setZero(3, control_points);
}

void DeformationLearner::begin_track() {
    last_.resize(3, 0);
    followed_ = 0;
}

void DeformationLearner::add(const Eigen::Matrix3Xd& Q, double time_s) {
    if (Q.cols() != K_)
        throw std::invalid_argument(std::to_string(Q.cols()) + " control points, expected " +
                                    std::to_string(K_) + " as before");
    if (last_.cols() == 0) {
        motion_.velocity_m_s.setZero();
        ++tracks_;
    } else {
        const double dt = time_s - last_time_s_;
        if (!(dt > 0.0)) throw std::invalid_argument("the time does not rise, expected frames in order");
        Eigen::Matrix3Xd expected;
        motion_.predict(last_, {Q.col(0) - last_.col(0), Q.col(K_ - 1) - last_.col(K_ - 1)}, dt, expected);
        if (++followed_ >= kSettled) {
            const Eigen::Matrix3Xd d = thread_frame(last_).transpose() * (Q - expected) / dt;
            for (const bool mirrored : {false, true})
                for (const bool reversed : {false, true}) {
                    const Eigen::VectorXd seen = seen_as(d, mirrored, reversed);
                    scatter_.noalias() += 0.25 * seen * seen.transpose();
                }
            time_sum_s_ += dt;
            ++frames_;
        }
        motion_.follow(Q, expected, dt);
    }
    last_ = Q;
    last_time_s_ = time_s;
}

DeformationPrior DeformationLearner::learn(int modes) const {
    if (frames_ < 3 * K_)
        throw std::invalid_argument(std::to_string(frames_) + " frames to learn from, expected " +
                                    std::to_string(3 * K_) + " or more");
    const double step_s = time_sum_s_ / frames_;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(step_s * step_s / frames_ * scatter_);
    const Eigen::VectorXd variances = solver.eigenvalues().reverse().cwiseMax(0.0);
    // The ends go where they are carried: their six directions vary in nothing.
    const int free = 3 * (K_ - 2);
    if (modes < 1 || modes >= free)
        throw std::invalid_argument(std::to_string(modes) + " modes, expected 1 to " +
                                    std::to_string(free - 1));
    DeformationPrior prior;
    prior.control_points = K_;
    prior.frame_rate_hz = 1.0 / step_s;
    prior.tracks = tracks_;
    prior.frames = frames_;
    prior.modes = solver.eigenvectors().rowwise().reverse().leftCols(modes);
    prior.sigmas_m = variances.head(modes).cwiseSqrt();
    prior.rest_sigma_m = std::sqrt(variances.segment(modes, free - modes).mean());
    if (!(prior.rest_sigma_m > 1e-9))
        throw std::invalid_argument(
            "control points that only do what is predicted, expected recorded tracks");
    // Signs are anyone's: the largest part of each mode is positive.
    for (int m = 0; m < modes; ++m) {
        long largest = 0;
        prior.modes.col(m).cwiseAbs().maxCoeff(&largest);
        if (prior.modes(largest, m) < 0.0) prior.modes.col(m) *= -1.0;
    }
    return prior;
}

}  // namespace atropos::tracker
