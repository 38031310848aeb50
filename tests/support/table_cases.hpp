#pragma once

#include <optional>
#include <string_view>

#include "tests/support/tracking_trial.hpp"

namespace atropos::support {

/// A camera of Table I's reproduction and what each method is told there.
struct TableCase {
    SyntheticSequenceOptions options;  ///< protocol P, acceleration 1
    scenes::TrackerConfig e1;
    scenes::TrackerConfig e2;
};

/// "default" (640x360 at 100 mm), "A" (full HD at 70 mm) or "B" (640x360 at 220 mm): the readings of Table
/// I's units in docs/method.md; "converging", "distorted": the default one with other eyes of equal focal
/// length and baseline. Throws std::invalid_argument.
TableCase table_case(std::string_view camera);

/// A random curve at rest whose ends are `chord_over_length` of its length apart, no clutter.
SyntheticSequenceOptions start_options(std::uint64_t seed, double chord_over_length);

/// Symmetric 2D error of the curve that a tracker finds from both ends and the length alone, px; nothing when
/// it says that it finds none.
std::optional<double> error_from_straight_line_px(const SyntheticSequenceOptions& options);

}  // namespace atropos::support
