#include "tracker/nuisance_belief.hpp"

namespace atropos::tracker {
namespace {

using Vector = Nuisances::Vector;

/// One number of each kind.
Vector of_kinds(double tip_m, double row_px, double roll_rad, double length_m) {
    return Nuisances{
        {Eigen::Vector3d::Constant(tip_m), Eigen::Vector3d::Constant(tip_m)}, {row_px, roll_rad}, length_m}
        .vector();
}

constexpr double kEyeOff = 0.01;       ///< of the rigs: their calibration is worth only its stated sigma
constexpr double kRightEye = 0.02;     ///< of that sigma: what the other rigs are off by
constexpr double kLengthWrong = 0.03;  ///< of the lengths that are given
constexpr double kWrongLength = 0.1;   ///< sigma of those, share of the length
constexpr double kSeenLength = 0.03;   ///< sigma of a length that a start has found

SlowBelief<Nuisances::kCount>::Options belief_options(double scale) {
    SlowBelief<Nuisances::kCount>::Options options;
    options.hypotheses.resize(1);
    options.forget_s = of_kinds(20.0, 60.0, 60.0, 0.3);
    options.floor = of_kinds(0.00015, 0.01 * scale, 0.00003, 0.0003);
    options.useless = of_kinds(0.02, 20.0 * scale, 0.07, 0.02);
    return options;
}

/// Chi-squares of 1, 2 and 3 at 99 %.
constexpr double kChi1 = 6.63, kChi2 = 9.21, kChi3 = 11.3;

template <int N>
bool leaps(const Vector& innovation, const Nuisances::Matrix& S, int at, double gate) {
    const Eigen::Matrix<double, N, 1> part = innovation.segment<N>(at);
    return part.dot(S.block<N, N>(at, at).inverse() * part) > gate;
}

}  // namespace

NuisanceBelief::NuisanceBelief(const scenes::TrackerConfig& config, double scale)
    : config_(config.refined),
      given_length_m_(config.thread.length_m),
      scale_(scale),
      belief_(belief_options(scale)) {
    expect_length(0.1);
}

void NuisanceBelief::reset() {
    belief_.reset();
}

// A calibration is right or off, a length that is given right or wrong: what the frames say decides.
void NuisanceBelief::expect_length(double measured_m) {
    const bool known = given_length_m_ > 0.0;
    const double length_m = known ? given_length_m_ : measured_m;
    const auto guess = [&](bool eye_off, bool length_wrong) {
        const double eye = eye_off ? 1.0 : kRightEye;
        const double length_sigma_m = !known         ? kSeenLength * length_m
                                      : length_wrong ? kWrongLength * length_m
                                                     : config_.length_sigma_m;
        const double weight =
            (eye_off ? kEyeOff : 1.0 - kEyeOff) * (length_wrong ? kLengthWrong : 1.0 - kLengthWrong);
        return Belief::Hypothesis{of_kinds(config_.tip_bias_sigma_m, eye * config_.row_sigma_px * scale_,
                                           eye * config_.roll_sigma_rad, length_sigma_m)
                                      .cwiseMax(1e-9),
                                  weight};
    };
    std::vector<Belief::Hypothesis> guesses = {guess(false, false), guess(true, false)};
    if (known) guesses.insert(guesses.end(), {guess(false, true), guess(true, true)});
    belief_.forget(Nuisances::kLength, length_m, guesses);
}

const double* NuisanceBelief::load(const double* in) {
    expect_length(in[Nuisances::kLength]);  // of the centre, which comes first
    return belief_.load(in);
}

NuisancePrior NuisanceBelief::prior() const {
    return {mean(), belief_.information()};
}

NuisancePrior NuisanceBelief::doubting_prior() const {
    return {Nuisances::from(belief_.least_sure_mean()), belief_.least_sure_covariance().inverse()};
}

void NuisanceBelief::learn(const NuisancePrior& told, const Nuisances& fitted,
                           const Nuisances::Matrix& covariance, const Nuisances::Matrix& by_noise) {
    // None of them leaps; a wrongly seen end does.
    belief_.learn(evidence_of<Nuisances::kCount>(told.mean.vector(), told.information, fitted.vector(),
                                                 covariance, by_noise),
                  [](const Vector& innovation, const Nuisances::Matrix& S) {
                      return leaps<3>(innovation, S, Nuisances::kTip0, kChi3) ||
                             leaps<3>(innovation, S, Nuisances::kTip1, kChi3) ||
                             leaps<2>(innovation, S, Nuisances::kRow, kChi2) ||
                             leaps<1>(innovation, S, Nuisances::kLength, kChi1);
                  });
}

}  // namespace atropos::tracker
