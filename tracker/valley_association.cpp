#include "tracker/valley_association.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr double kFaint = 0.13;  ///< of a thread's usual depth: hardly seen

double own_cost(const ValleyCandidates& sample, int state, double threshold,
                const ValleyAssociationOptions& options) {
    if (state == ValleyFilter::kMaxValleys) return options.missing_cost;
    const Valley& valley = sample.valleys[static_cast<std::size_t>(state)];
    // A thread that is known to be faint is not a worse valley for it.
    const double hardly_seen = sample.expected_depth_levels > 0.0
                                   ? std::min(threshold, kFaint * sample.expected_depth_levels)
                                   : threshold;
    const double faint = hardly_seen / (valley.depth_levels + hardly_seen);
    const double away = valley.offset_px / options.search_px;
    double cost = faint + options.distance_cost * away * away;
    if (sample.expected_depth_levels > 0.0)
        cost += options.appearance_cost *
                std::min(2.0, std::abs(std::log(valley.depth_levels / sample.expected_depth_levels)));
    return cost;
}

}  // namespace

std::span<const int> ValleyAssociation::choose(std::span<const ValleyCandidates> samples,
                                               double threshold_levels,
                                               const ValleyAssociationOptions& options) {
    constexpr int none = ValleyFilter::kMaxValleys;
    const std::size_t n = samples.size();
    cost_.resize(n);
    from_.resize(n);
    chosen_.assign(n, -1);
    if (n == 0) return chosen_;
    const auto exists = [&](std::size_t j, int state) { return state == none || state < samples[j].count; };
    const auto offset = [&](std::size_t j, int state) {
        return samples[j].valleys[static_cast<std::size_t>(state)].offset_px;
    };
    constexpr double kImpossible = 1e18;
    for (std::size_t j = 0; j < n; ++j)
        for (int state = 0; state <= none; ++state) {
            auto& cost = cost_[j][static_cast<std::size_t>(state)];
            cost = kImpossible;
            if (!exists(j, state)) continue;
            const double own = own_cost(samples[j], state, threshold_levels, options);
            if (j == 0) {
                cost = own;
                continue;
            }
            for (int before = 0; before <= none; ++before) {
                if (!exists(j - 1, before)) continue;
                double jump = 0.0;
                if (state != none && before != none) {
                    const double change = (offset(j, state) - offset(j - 1, before)) / options.jump_px;
                    jump = std::min(change * change, options.jump_limit);
                } else if (state != before) {
                    jump = 0.3 * options.jump_limit;  // a gap must not be a free way to another line
                }
                const double total = cost_[j - 1][static_cast<std::size_t>(before)] + jump + own;
                if (total < cost) {
                    cost = total;
                    from_[j][static_cast<std::size_t>(state)] = static_cast<signed char>(before);
                }
            }
        }
    int state =
        static_cast<int>(std::min_element(cost_[n - 1].begin(), cost_[n - 1].end()) - cost_[n - 1].begin());
    for (std::size_t j = n; j-- > 0;) {
        chosen_[j] = state == none ? -1 : state;
        if (j > 0) state = from_[j][static_cast<std::size_t>(state)];
    }
    return chosen_;
}

}  // namespace atropos::tracker
