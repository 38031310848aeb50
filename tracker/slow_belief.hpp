#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace atropos::tracker {

/// `A` without what rounding put below zero.
template <int N>
Eigen::Matrix<double, N, N> clamped_below_zero(const Eigen::Matrix<double, N, N>& A) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, N, N>> eigen(0.5 * (A + A.transpose()));
    return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
           eigen.eigenvectors().transpose();
}

/// What one fit says of N numbers, apart from what it was told of them.
template <int N>
struct Evidence {
    using Vector = Eigen::Matrix<double, N, 1>;
    using Matrix = Eigen::Matrix<double, N, N>;

    Matrix information = Matrix::Zero();  ///< M; of images and all other priors
    Matrix new_part = Matrix::Zero();     ///< of M: by noise that is another one in each frame
    Vector expected = Vector::Zero();     ///< what it was told
    Vector score = Vector::Zero();        ///< M (what it says - expected)
};

/// Evidence from a fit that was told `expected` with the information `told` and came to `fitted` with
/// `covariance`; `by_noise` is the part of the covariance that noise alone makes. With H' all of the fit but
/// that prior, H = H' + S^-1: the marginal information of H' is M = Sigma^-1 - S^-1, and
/// M N' M = Sigma^-1 N Sigma^-1 for the noise's share N of the covariance.
template <int N>
Evidence<N> evidence_of(const Eigen::Matrix<double, N, 1>& expected, const Eigen::Matrix<double, N, N>& told,
                        const Eigen::Matrix<double, N, 1>& fitted,
                        const Eigen::Matrix<double, N, N>& covariance,
                        const Eigen::Matrix<double, N, N>& by_noise) {
    const Eigen::Matrix<double, N, N> inverse = covariance.inverse();
    return {inverse - told, inverse * by_noise * inverse, expected, inverse * (fitted - expected)};
}

/// N numbers that hardly change, such as what an arm is off by, from what each frame's fit says of them: the
/// mean of what the frames say, weighted by their information.
///
/// A fit is wrong in two ways. Noise makes it wrong anew in each frame: that part of the mean's covariance
/// shrinks with the number of frames. What was assumed of the curve (bending, length, where jaws end) makes
/// it wrong in the same way in frame after frame: that part stays, so that a hundred frames that agree count
/// as one look, not as a hundred.
template <int N>
class SlowBelief {
  public:
    using Vector = Eigen::Matrix<double, N, 1>;
    using Matrix = Eigen::Matrix<double, N, N>;

    /// A guess at how far the centre is off: sigmas, and how likely that is beforehand.
    struct Hypothesis {
        Vector sigma = Vector::Ones();
        double weight = 1.0;
    };

    struct Options {
        Vector centre = Vector::Zero();      ///< the mean before anything was seen
        std::vector<Hypothesis> hypotheses;  ///< of how far from it; the last is the least sure
        Vector forget_s = Vector::Ones();    ///< age at which what was said counts for 1/e
        Vector floor = Vector::Zero();       ///< what the mean of many frames still is off by
        Vector useless = Vector::Ones();     ///< evidence that is worse than this says nothing
    };

    /// With one hypothesis at least.
    explicit SlowBelief(const Options& options) : options_(options) { reset(); }

    void reset() {
        said_ = options_.centre;
        sum_.setZero();
        new_sum_.setZero();
        frames_.setZero();
        conclude();
    }

    /// Begins anew with number `i` alone.
    void forget(int i, double centre, const std::vector<Hypothesis>& hypotheses) {
        options_.hypotheses = hypotheses;
        options_.centre[i] = said_[i] = centre;
        for (Matrix* M : {&sum_, &new_sum_}) {
            M->row(i).setZero();
            M->col(i).setZero();
        }
        frames_[i] = 0.0;
        conclude();
    }

    void wait(double dt_s) {
        const Vector keep = (-0.5 * dt_s * options_.forget_s.cwiseInverse()).array().exp();
        sum_ = (keep.asDiagonal() * sum_ * keep.asDiagonal()).eval();
        new_sum_ = (keep.asDiagonal() * new_sum_ * keep.asDiagonal()).eval();
        frames_.array() *= keep.array().square();
        conclude();
    }

    const Vector& mean() const { return mean_; }
    const Matrix& covariance() const { return covariance_; }
    const Matrix& information() const { return information_; }
    const Vector& least_sure_mean() const { return least_sure_mean_; }
    const Matrix& least_sure_covariance() const { return least_sure_covariance_; }

    /// Takes from a fit what it says. `is_bad(surprise, covariance)`
    /// refuses evidence.
    template <class IsBad>
    void learn(const Evidence<N>& evidence, IsBad&& is_bad) {
        const Matrix M = in_units(evidence.information);
        const Vector to_unit = options_.useless.cwiseInverse();
        const Vector score = options_.useless.cwiseProduct(evidence.score);  // M (what is said - mean)
        const Matrix M_inverse = (clamped_below_zero<N>(M) + Matrix::Identity()).inverse();
        const Vector surprise = options_.useless.cwiseProduct(
            M_inverse * (score + M * to_unit.cwiseProduct(evidence.expected - least_sure_mean_)));
        if (is_bad(surprise, (options_.useless.asDiagonal() * M_inverse * options_.useless.asDiagonal() +
                              least_sure_covariance_)
                                 .eval()))
            return;
        sum_ += clamped_below_zero<N>(M);
        new_sum_ += in_units(evidence.new_part);
        frames_.array() += 1.0;
        const Vector beyond = score + M * to_unit.cwiseProduct(evidence.expected - said_);
        said_ += options_.useless.cwiseProduct((sum_ + Matrix::Identity()).inverse() * beyond);
        conclude();
    }

    static constexpr int kStateSize = 3 * N + 2 * N * N;
    double* save(double* out) const {
        for (const Vector* v : {&options_.centre, &said_, &frames_}) out = std::copy_n(v->data(), N, out);
        out = std::copy_n(sum_.data(), N * N, out);
        return std::copy_n(new_sum_.data(), N * N, out);
    }
    const double* load(const double* in) {
        for (Vector* v : {&options_.centre, &said_, &frames_}) {
            std::copy_n(in, N, v->data());
            in += N;
        }
        std::copy_n(in, N * N, sum_.data());
        std::copy_n(in + N * N, N * N, new_sum_.data());
        conclude();
        return in + 2 * N * N;
    }

  private:
    Matrix in_units(const Matrix& M) const {
        return options_.useless.asDiagonal() * M * options_.useless.asDiagonal();
    }

    // With A and S the means over the frames of the information and of its new part, what was said has the
    // covariance A^-1 (S / n + A - S) A^-1.
    void conclude() {
        const Vector rate = frames_.cwiseMax(1.0).cwiseInverse();
        const Vector root = rate.cwiseSqrt();
        const Matrix A = root.asDiagonal() * sum_ * root.asDiagonal();
        const Matrix S = root.asDiagonal() * new_sum_ * root.asDiagonal();
        const Matrix inner = rate.asDiagonal() * new_sum_ * rate.asDiagonal() + clamped_below_zero<N>(A - S) +
                             1e-9 * Matrix::Identity();
        const Matrix said = A * inner.inverse() * A;
        Matrix floor = Matrix::Zero();
        floor.diagonal() = options_.floor.cwiseQuotient(options_.useless).cwiseAbs2();
        const Matrix bounded = (Matrix::Identity() + said * floor).inverse() * said;
        const Vector to_unit = options_.useless.cwiseInverse();
        const Matrix learned =
            to_unit.asDiagonal() * (0.5 * (bounded + bounded.transpose())) * to_unit.asDiagonal();
        weigh(learned);
    }

    // Each hypothesis explains what was said, the better the less it has to bend for it; their mixture is
    // believed.
    void weigh(const Matrix& learned) {
        const Vector off = said_ - options_.centre;
        mean_.setZero();
        covariance_.setZero();
        Matrix squares = Matrix::Zero();
        double total = 0.0, best = 0.0;
        for (std::size_t h = 0; h < options_.hypotheses.size(); ++h) {
            const Hypothesis& hypothesis = options_.hypotheses[h];
            const Vector sigma = hypothesis.sigma;
            Matrix information = learned;
            information.diagonal() += sigma.cwiseAbs2().cwiseInverse();
            const Matrix covariance = information.inverse();
            const Vector moved = covariance * learned * off;
            const Matrix spread = Matrix::Identity() + sigma.asDiagonal() * learned * sigma.asDiagonal();
            const double misfit = off.dot(learned * (off - moved)) + std::log(spread.determinant());
            if (h == 0) best = misfit;
            const double weight = hypothesis.weight * std::exp(std::min(0.5 * (best - misfit), 300.0));
            total += weight;
            mean_ += weight * moved;
            covariance_ += weight * covariance;
            squares += weight * moved * moved.transpose();
            least_sure_mean_ = options_.centre + moved;
            least_sure_covariance_ = covariance;
        }
        mean_ /= total;
        covariance_ = (covariance_ + squares) / total - mean_ * mean_.transpose();
        mean_ += options_.centre;
        information_ = covariance_.inverse();
    }

    Options options_;
    Vector said_;     ///< by the frames, in the mean
    Matrix sum_;      ///< of the frames' information, in units of what is useless
    Matrix new_sum_;  ///< and of its new part
    Vector frames_;   ///< how many that were
    Vector mean_, least_sure_mean_;
    Matrix covariance_, information_, least_sure_covariance_;
};

}  // namespace atropos::tracker
