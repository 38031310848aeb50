#pragma once

#include <array>
#include <string>

#include "tests/support/table_cases.hpp"

namespace atropos::bench {

/// One sequence of one camera: how E1 [0] and E2 [1] did, and how the thread moved.
struct Trial {
    std::array<std::vector<support::FrameScore>, 2> scores;
    support::KnotMotion motion;
};

/// The trial as `folder` keeps it, or a new one that it then keeps. Trials are written whole or not at all.
Trial stored_trial(const std::string& folder, const std::string& camera, int acceleration, int seed,
                   int frames);

}  // namespace atropos::bench
