#include "tracker/line_look.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;

Vector2d normal(const RidgePoint& at) {
    return {-at.tangent.y(), at.tangent.x()};
}

}  // namespace

LineLook::LineLook(const ImageView& image, const ImagePath& path, scenes::ThreadPolarity polarity)
    : image_(image), bright_(polarity == scenes::ThreadPolarity::kBright) {
    constexpr int kReach = 24, kGround = 18, kSlack = 8;  // steps
    std::array<double, kReach + 1> level{};               // both sides together
    for (std::size_t k = 0; k < path.points.size(); k += 3) {
        const RidgePoint& point = path.points[k];
        NormalProfile profile;
        profile.read(image, {point.px, normal(point), point.tangent}, kStep_px, kReach, 3, 1.0);
        if (profile.first > -kReach || profile.last < kReach) continue;
        for (int i = 0; i <= kReach; ++i)
            level[static_cast<std::size_t>(i)] +=
                (bright_ ? -1.0 : 1.0) * static_cast<double>(profile[i] + profile[-i]);
    }
    double ground = 0.0;
    for (int i = kGround; i <= kReach; ++i)
        ground += level[static_cast<std::size_t>(i)] / (kReach - kGround + 1);
    const double darkest = *std::min_element(level.begin(), level.begin() + kSlack);
    int half = kGround;
    while (half > 2 && level[static_cast<std::size_t>(half - 1)] > 0.5 * (ground + darkest)) --half;
    half_width_ = std::min(half - 1, 9);
}

LineSight LineLook::at(const RidgePoint& at, double search_px) const {
    constexpr double kFarther = 0.08;                      // a step farther off, the less worth
    constexpr double kDarkest_levels = 60.0;               // ground below which shares are noise
    const int inner = half_width_ + 4, outer = inner + 4;  // the ground, from the middle
    const int box = std::max(1, (half_width_ + 1) / 2);
    const int reach = static_cast<int>(search_px / kStep_px);
    NormalProfile profile;
    profile.read(image_, {at.px, normal(at), at.tangent}, kStep_px, reach + outer, 5, 1.0);
    std::array<double, 2 * NormalProfile::kMaxHalf + 2> total{};  // running sum
    const auto until = [&](int i) -> double& { return total[static_cast<std::size_t>(i - profile.first)]; };
    for (int i = profile.first; i <= profile.last; ++i)
        until(i + 1) = until(i) + (bright_ ? -1.0 : 1.0) * static_cast<double>(profile[i]);
    const auto mean = [&](int from, int to) { return (until(to + 1) - until(from)) / (to - from + 1); };
    const auto level = [&](int i) { return mean(i - box, i + box); };
    LineSight best;
    double highest = 0.0;
    for (int i = std::max(-reach, profile.first + outer); i <= std::min(reach, profile.last - outer); ++i) {
        const double before = level(i - 1), here = level(i), after = level(i + 1);
        if (here > before || here > after) continue;  // not the bottom of a valley
        const double ground = std::min(mean(i - outer, i - inner), mean(i + inner, i + outer));
        const double contrast = (ground - here) / (bright_ ? 128.0 : std::max(ground, kDarkest_levels));
        const double worth = contrast * (1.0 - kFarther * std::abs(i));
        if (worth <= highest) continue;
        highest = worth;
        const double bend = before - 2.0 * here + after;
        const double shift = bend > 1e-6 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
        best = {kStep_px * (i + shift), contrast};
    }
    return best;
}

double LineLook::beside(const RidgePoint& point, double search_px) const {
    constexpr double kAside_px = 8.0;
    double sum = 0.0;
    for (const double side : {-kAside_px, kAside_px}) {
        RidgePoint there = point;
        there.px += side * normal(point);
        sum += at(there, search_px).contrast;
    }
    return 0.5 * sum;
}

std::array<double, 2> LineLook::sides(const RidgePoint& at) const {
    const int inner = half_width_ + 4, outer = inner + 4;
    NormalProfile profile;
    profile.read(image_, {at.px, normal(at), at.tangent}, kStep_px, outer, 5, 1.0);
    if (profile.first > -outer || profile.last < outer) return {0.0, 0.0};
    std::array<double, 2> level{};
    for (int i = inner; i <= outer; ++i) {
        level[0] += static_cast<double>(profile[-i]) / (outer - inner + 1);
        level[1] += static_cast<double>(profile[i]) / (outer - inner + 1);
    }
    return level;
}

}  // namespace atropos::tracker
