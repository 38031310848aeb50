#include "tracker/thread_tracker.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/tracking_trial.hpp"

namespace atropos::tracker {
namespace {

using support::FrameScore;
using support::SyntheticSequenceOptions;

TEST(ThreadTracker, follows_a_thread_over_clutter_with_both_energies) {
    for (const auto method : {scenes::TrackerMethod::kE1, scenes::TrackerMethod::kE2}) {
        scenes::TrackerConfig config;
        config.method = method;
        const support::TrialSummary found =
            support::summary(support::run_trial(config, SyntheticSequenceOptions{.seed = 7}, 10));
        EXPECT_LT(found.mean_2d_px, 1.0);
        EXPECT_EQ(found.failed_percent, 0.0);
    }
}

}  // namespace
}  // namespace atropos::tracker
