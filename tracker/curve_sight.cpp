#include "tracker/curve_sight.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr double kBehind_m = 0.003;
constexpr double kLeastSigma_px =
    0.015;                           ///< texture under the thread, lens model: what noise does not explain
constexpr double kUsualNoise = 1.5;  ///< of a profile's noise over the middle one

/// Of a valley's place before it is localised: curves that trust it more swing aside in depth near their
/// ends.
constexpr double kValleySigma_px = 0.1;
constexpr double kSignificance = 3.5;  ///< sigmas of contrast that make a bar

bool is_valley(const LineMeasurement& m) {
    return m.kind == LineMeasurement::Kind::kSeen && m.depth_levels > 0.0;
}

/// 0 of none; changes the order.
double median(std::vector<double>& values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

CurveSight::CurveSight(const scenes::TrackerConfig& config, const scenes::StereoRig& rig)
    : config_(config),
      rig_(rig),
      scale_(rig.left.width_px / 640.0),
      filter_({.polarity = config.thread.polarity,
               .threshold_levels = config.refined.contrast_levels,
               .blur_px = config.refined.blur_px,
               .taps = 5,
               .tap_step_px = std::max(1.0, scale_)}) {
    const std::size_t samples = static_cast<std::size_t>(config.refined.samples);
    for (auto& depths : expected_depth_levels_) depths.assign(samples, 0.0);
    candidates_.resize(samples);
    lines_.resize(samples);
    widths_px_.resize(samples);
    left_over_levels_.resize(samples);
    noises_.reserve(2 * samples);
}

void CurveSight::look(const std::array<ImageView, 2>& images, std::span<const CubicBasisValues> samples,
                      const Eigen::Matrix3Xd& Q, std::span<const scenes::Capsule> instruments_C,
                      const Look& look, std::array<std::vector<LineMeasurement>, 2>& lines) {
    for (std::size_t eye = 0; eye < 2; ++eye) {
        const Eigen::Vector3d eye_C =
            eye == 0 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(rig_.X_RC.inverse().translation());
        const OcclusionMask mask(instruments_C, eye_C, 2.0 * config_.refined.instrument_sigma_m, kBehind_m);
        look_with(eye, images[eye], samples, Q, mask, look, lines[eye]);
        if (look.closely) localise(images[eye], lines[eye]);
    }
}

// Candidates of one sample; whether it can be seen.
bool CurveSight::look_across(std::size_t eye, const ImageView& image, std::size_t j,
                             const CubicBasisValues& sample, const Eigen::Matrix3Xd& Q,
                             const OcclusionMask& mask, const Look& look) {
    const scenes::Camera& camera = eye == 0 ? rig_.left : rig_.right;
    const Eigen::Vector3d p_C = sample.point(Q);
    const Eigen::Vector3d p = eye == 0 ? p_C : Eigen::Vector3d(rig_.X_RC * p_C);
    if (p.z() < 0.005) return false;
    Eigen::Vector3d tangent = sample.tangent(Q);
    if (eye == 1) tangent = rig_.X_RC.linear() * tangent;
    Eigen::Matrix<double, 2, 3> J_px;
    NormalLine& line = lines_[j];
    line.p_px = camera.project(p, J_px);
    const Eigen::Vector2d along = J_px * tangent;
    const double speed = along.norm();
    // Seen end on, the thread has no direction in the image.
    if (!camera.contains(line.p_px) || speed < 0.15 * J_px.leftCols<2>().norm() * tangent.norm() * 0.7)
        return false;
    if (mask.hides(p_C)) return false;
    line.tangent = along / speed;
    line.normal = {-line.tangent.y(), line.tangent.x()};
    widths_px_[j] = config_.thread.width_m * camera.fx_px / p.z();
    ValleyCandidates& candidates = candidates_[j];
    candidates.count = filter_.find(image, line, look.search_px * scale_, widths_px_[j], candidates.valleys,
                                    look.threshold_share);
    if (mask.empty()) return true;
    // A valley that lies on an instrument is its rim or its gloss.
    const Eigen::Matrix2d px_to_m = J_px.leftCols<2>().inverse();
    int kept = 0;
    for (int c = 0; c < candidates.count; ++c) {
        const Valley& valley = candidates.valleys[static_cast<std::size_t>(c)];
        Eigen::Vector3d shift = Eigen::Vector3d::Zero();
        shift.head<2>() = px_to_m * (valley.offset_px * line.normal);
        if (eye == 1) shift = rig_.X_RC.linear().transpose() * shift;
        if (!mask.hides(p_C + shift)) candidates.valleys[static_cast<std::size_t>(kept++)] = valley;
    }
    candidates.count = kept;
    return true;
}

// One valley, or none, for each sample. Parts of the thread that were never seen are taken for as dark as the
// rest of it: a first choice tells how dark that is.
std::span<const int> CurveSight::choose(const Look& look) {
    ValleyAssociationOptions options;
    options.search_px = look.search_px * scale_;
    options.jump_px = scale_ * 80.0 / static_cast<double>(candidates_.size());
    const double threshold = look.threshold_share * config_.refined.contrast_levels;
    const auto is_unknown = [](const ValleyCandidates& c) { return c.expected_depth_levels <= 0.0; };
    std::span<const int> chosen = association_.choose(candidates_, threshold, options);
    if (std::none_of(candidates_.begin(), candidates_.end(), is_unknown)) return chosen;
    chosen_depths_.clear();
    for (std::size_t j = 0; j < chosen.size(); ++j)
        if (chosen[j] >= 0)
            chosen_depths_.push_back(
                candidates_[j].valleys[static_cast<std::size_t>(chosen[j])].depth_levels);
    const double usual = median(chosen_depths_);
    for (ValleyCandidates& c : candidates_)
        if (is_unknown(c)) c.expected_depth_levels = usual;
    return association_.choose(candidates_, threshold, options);
}

void CurveSight::look_with(std::size_t eye, const ImageView& image, std::span<const CubicBasisValues> samples,
                           const Eigen::Matrix3Xd& Q, const OcclusionMask& mask, const Look& look,
                           std::vector<LineMeasurement>& measured) {
    for (std::size_t j = 0; j < samples.size(); ++j) {
        candidates_[j].count = 0;
        candidates_[j].expected_depth_levels = expected_depth_levels_[eye][j];
        measured[j].kind = look_across(eye, image, j, samples[j], Q, mask, look)
                               ? LineMeasurement::Kind::kMissing
                               : LineMeasurement::Kind::kHidden;
    }
    const std::span<const int> chosen = choose(look);
    for (std::size_t j = 0; j < samples.size(); ++j) {
        if (chosen[j] < 0) continue;
        const Valley& valley = candidates_[j].valleys[static_cast<std::size_t>(chosen[j])];
        LineMeasurement& m = measured[j];
        m.kind = LineMeasurement::Kind::kSeen;
        m.point_px = lines_[j].p_px + valley.offset_px * lines_[j].normal;
        m.normal = lines_[j].normal;
        m.depth_levels = valley.depth_levels;
        m.sigma_px = kValleySigma_px;
    }
}

// Replaces the valleys' positions by the least-squares ones, with sigmas from the image's own noise. Where no
// valley stood out, the bar itself is looked for on the curve: a slope of the ground hides faint valleys, but
// the bar's model holds a slope.
void CurveSight::localise(const ImageView& image, std::vector<LineMeasurement>& measured) {
    noises_.clear();
    for (std::size_t j = 0; j < measured.size(); ++j) {
        LineMeasurement& m = measured[j];
        if (m.kind == LineMeasurement::Kind::kHidden) continue;
        NormalLine line = lines_[j];
        if (m.kind == LineMeasurement::Kind::kSeen)
            line.p_px = m.point_px;
        else
            m.depth_levels = 0.0;  // no valley: nothing to learn
        m.kind = LineMeasurement::Kind::kMissing;
        ValleyFilter::Localisation found;
        if (!filter_.localise(image, line, widths_px_[j], found) ||
            std::abs(found.offset_px) > 0.5 * widths_px_[j] + 1.0 ||
            found.contrast_levels <
                std::max(config_.refined.contrast_levels, kSignificance * found.contrast_sigma_levels))
            continue;
        m.kind = LineMeasurement::Kind::kSeen;
        m.normal = line.normal;
        m.point_px = line.p_px + found.offset_px * line.normal;
        m.sigma_px = found.sigma_px_per_noise_level;
        left_over_levels_[j] = found.noise_levels;
        noises_.push_back(found.noise_levels);
    }
    if (noises_.empty()) return;
    const double usual = median(noises_);
    for (std::size_t j = 0; j < measured.size(); ++j) {
        LineMeasurement& m = measured[j];
        if (m.kind != LineMeasurement::Kind::kSeen) continue;
        m.sigma_px = std::hypot(m.sigma_px * usual, kLeastSigma_px);
        // What no bar explains pulls the bar aside: another line that joins, a rim, gloss.
        const double ratio = left_over_levels_[j] / usual;
        if (ratio > kUsualNoise) m.sigma_px *= (ratio / kUsualNoise) * (ratio / kUsualNoise);
    }
}

void CurveSight::reset() {
    for (auto& depths : expected_depth_levels_) std::fill(depths.begin(), depths.end(), 0.0);
}

// The contrast of each part of the thread, so that something else is known as such. What crosses the thread
// is not learned: no part differs from the rest by more than a factor of two.
void CurveSight::learn(const std::array<std::vector<LineMeasurement>, 2>& lines) {
    for (std::size_t eye = 0; eye < 2; ++eye) {
        chosen_depths_.clear();
        for (const LineMeasurement& m : lines[eye])
            if (is_valley(m)) chosen_depths_.push_back(m.depth_levels);
        const double usual = median(chosen_depths_);
        for (std::size_t j = 0; j < lines[eye].size(); ++j) {
            const LineMeasurement& m = lines[eye][j];
            double& depth = expected_depth_levels_[eye][j];
            if (!is_valley(m)) continue;
            const double seen = std::clamp(m.depth_levels, 0.5 * usual, 2.0 * usual);
            depth = depth > 0.0 ? 0.9 * depth + 0.1 * seen : seen;
        }
    }
}

void CurveSight::save(double* out) const {
    for (const auto& depths : expected_depth_levels_) out = std::copy(depths.begin(), depths.end(), out);
}

void CurveSight::load(const double* in) {
    for (auto& depths : expected_depth_levels_) {
        std::copy_n(in, depths.size(), depths.begin());
        in += depths.size();
    }
}

}  // namespace atropos::tracker
