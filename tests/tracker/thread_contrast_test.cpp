#include "tracker/thread_contrast.hpp"

#include <gtest/gtest.h>

#include "tests/support/synthetic_sequence.hpp"

namespace atropos::tracker {
namespace {

ThreadContrast measured(const support::SyntheticSequenceOptions& options) {
    const support::SyntheticFrame drawn = support::SyntheticSequence(options).frame(0);
    cv::Mat buffers[2];
    return thread_contrast({channel_view(drawn.left, scenes::ImageChannel::kGray, buffers[0]),
                            channel_view(drawn.right, scenes::ImageChannel::kGray, buffers[1])},
                           drawn.truth_C, options.rig, options.width_m, {})
        .value();
}

TEST(ThreadContrast, is_what_the_pictures_were_drawn_with) {
    const ThreadContrast found = measured({.seed = 51, .clutter = false});
    EXPECT_NEAR(found.contrast_levels, 60.0, 6.0);
    EXPECT_GT(found.noise_levels, 3.6);  // and what the bar's model does not hold of so dark a thread
    EXPECT_LT(found.noise_levels, 5.4);
}

TEST(ThreadContrast, of_a_faint_thread_in_more_noise) {
    const ThreadContrast found =
        measured({.seed = 52, .contrast = 30.0, .noise_levels = 8.0, .clutter = false});
    EXPECT_NEAR(found.contrast_levels, 30.0, 4.0);
    EXPECT_NEAR(found.noise_levels, 8.0, 1.2);
}

}  // namespace
}  // namespace atropos::tracker
