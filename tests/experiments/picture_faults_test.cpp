#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "experiments/endoscope_view.hpp"
#include "experiments/scissors_pilot.hpp"
#include "experiments/testbed.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace {

using ::testing::HasSubstr;

constexpr double kFaultAt_s = 2.0;  // the scissors are on their way

/// The default scene with the command at 0.5 s, driven by the pilot alone. `fault` may change the pictures,
/// or take them away by returning false.
struct Episode {
    using Fault = std::function<bool(double time_s, cv::Mat& left, cv::Mat& right)>;

    explicit Episode(std::uint64_t seed)
        : scene(scenes::load_scene(ATROPOS_SCENES "/auto_scissors.yaml",
                                   {"seed=" + std::to_string(seed), "cut.at_s=0.5"})),
          testbed(scene),
          endoscope(testbed),
          pilot(scene, testbed.told_rig(), readings(), endoscope.instruments(),
                testbed.arm(kScissorsArm).controller()) {}

    ArmReadings readings() const {
        return {read(testbed.arm(0)), read(testbed.arm(1)), read(testbed.arm(2))};
    }
    bool is_whole() const { return testbed.thread().span.intact; }

    void run(double duration_s, const Fault& fault) {
        int frame = 0;
        for (long tick = 0; tick < std::lround(1e3 * duration_s) && !pilot.status().finished; ++tick) {
            if (tick == std::lround(1e3 * frame / scene.camera.fps_hz)) {
                View view = endoscope.capture(testbed, frame);
                const bool cut = pilot.status().verified == robot::CutEvidence::kCut;
                if (fault(testbed.time_s(), view.left, view.right) &&
                    pilot.see(frame, testbed.time_s(), view.left, view.right, readings()) && cut)
                    ++tracked_after_cut;
                ++frame;
            }
            pilot.step(testbed.time_s(), readings());
            testbed.tick();
        }
    }

    scenes::SceneConfig scene;
    Testbed testbed;
    EndoscopeView endoscope;
    ScissorsPilot pilot;
    int tracked_after_cut = 0;
};

/// Three faults on one seed each, on as many as ATROPOS_TEST_SEEDS says when it is set.
std::vector<std::uint64_t> seeds_from(std::uint64_t first) {
    const char* wanted = std::getenv("ATROPOS_TEST_SEEDS");
    std::vector<std::uint64_t> seeds(wanted ? std::strtoul(wanted, nullptr, 10) : 1);
    std::iota(seeds.begin(), seeds.end(), first);
    return seeds;
}

TEST(PictureFaults, a_black_eye_ends_the_cut_and_the_reason_says_that_the_tracker_is_lost) {
    for (const std::uint64_t seed : seeds_from(3)) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Episode episode(seed);
        episode.run(6.0, [](double time_s, cv::Mat& left, cv::Mat&) {
            if (time_s > kFaultAt_s) left.setTo(0);
            return true;
        });
        EXPECT_TRUE(episode.is_whole());
        EXPECT_TRUE(episode.pilot.status().aborted);
        EXPECT_THAT(episode.pilot.status().reason, HasSubstr("tracker lost"));
        std::printf("seed %d: %s\n", static_cast<int>(seed), episode.pilot.status().reason.c_str());
    }
}

TEST(PictureFaults, pictures_of_another_thread_are_not_taken_for_this_one) {
    for (const std::uint64_t seed : seeds_from(4)) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Episode episode(seed);
        episode.run(6.0, [](double time_s, cv::Mat& left, cv::Mat& right) {
            if (time_s > kFaultAt_s) {
                cv::flip(left, left, 0);
                cv::flip(right, right, 0);
            }
            return true;
        });
        EXPECT_TRUE(episode.is_whole());
        EXPECT_TRUE(episode.pilot.status().aborted) << episode.pilot.status().reason;
        std::printf("seed %d: %s\n", static_cast<int>(seed), episode.pilot.status().reason.c_str());
    }
}

TEST(PictureFaults, half_a_second_without_pictures_delays_the_cut_and_no_more) {
    for (const std::uint64_t seed : seeds_from(5)) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        Episode episode(seed);
        episode.run(8.0, [](double time_s, cv::Mat&, cv::Mat&) {
            return time_s < kFaultAt_s || time_s > kFaultAt_s + 0.5;
        });
        EXPECT_FALSE(episode.is_whole());
        EXPECT_TRUE(episode.pilot.status().succeeded) << episode.pilot.status().reason;
        EXPECT_EQ(episode.pilot.status().verified, robot::CutEvidence::kCut);
        EXPECT_EQ(episode.tracked_after_cut, 0);
        std::printf("seed %d: %s\n", static_cast<int>(seed), episode.pilot.status().reason.c_str());
    }
}

}  // namespace
}  // namespace atropos::experiments
