#include <gtest/gtest.h>

#include "experiments/scissors_pilot.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace {

robot::ScissorsOptions options_of(const std::string& scene) {
    return scissors_options(scenes::load_scene(std::string(ATROPOS_SCENES "/") + scene));
}

TEST(ScissorsOptions, where_nothing_is_known_of_its_error_take_the_tracker_at_its_word) {
    const robot::ScissorsOptions usual = options_of("auto_scissors.yaml"),
                                 paper = options_of("auto_scissors_paper.yaml");
    EXPECT_GT(usual.min_confidence, 0.0);
    EXPECT_EQ(paper.min_confidence, 0.0);
    EXPECT_EQ(paper.sigmas, 0.0);
    EXPECT_GT(paper.max_jump_m, usual.max_jump_m);
}

TEST(ScissorsOptions, expect_more_of_an_offset_from_worse_arms) {
    const auto sigma_m = [](const char* accuracy) {
        return scissors_options(scenes::load_scene(ATROPOS_SCENES "/auto_scissors.yaml",
                                                   {std::string("arms.accuracy=") + accuracy}))
            .registration_sigma_m;
    };
    EXPECT_LT(sigma_m("perfect"), sigma_m("calibrated"));
    EXPECT_LT(sigma_m("calibrated"), sigma_m("uncalibrated"));
}

}  // namespace
}  // namespace atropos::experiments
