#pragma once

#include <array>
#include <span>
#include <vector>

#include "tracker/valley_filter.hpp"

namespace atropos::tracker {

/// Valleys that one sample of the curve could belong to.
struct ValleyCandidates {
    std::array<Valley, ValleyFilter::kMaxValleys> valleys{};
    int count = 0;
    double expected_depth_levels = 0.0;  ///< of this place in earlier frames; 0 = not known
};

struct ValleyAssociationOptions {
    double search_px = 12.0;       ///< offset that costs `distance_cost`
    double distance_cost = 0.25;   ///< distance from the prediction
    double jump_px = 1.0;          ///< change of offset between neighbours that costs 1
    double jump_limit = 1.5;       ///< most that a jump can cost
    double missing_cost = 0.55;    ///< of a sample without a valley
    double appearance_cost = 0.4;  ///< of a depth that differs by a factor e from the expected one
};

/// Chooses one valley, or none, for each sample along one eye's curve: the offsets of neighbours should
/// agree, so that a thread is followed as a whole and a crossing vessel is not. Exact, by dynamic
/// programming.
class ValleyAssociation {
  public:
    /// Index of the chosen valley of each sample, -1 = none; valid until the next call.
    std::span<const int> choose(std::span<const ValleyCandidates> samples, double threshold_levels,
                                const ValleyAssociationOptions& options);

  private:
    static constexpr int kStates = ValleyFilter::kMaxValleys + 1;  // the last: none
    std::vector<std::array<double, kStates>> cost_;
    std::vector<std::array<signed char, kStates>> from_;
    std::vector<int> chosen_;
};

}  // namespace atropos::tracker
