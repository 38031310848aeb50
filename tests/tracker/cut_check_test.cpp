#include "tracker/cut_check.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "scenes/random_stream.hpp"
#include "tests/support/synthetic_sequence.hpp"

namespace atropos::tracker {
namespace {

constexpr double kCutAt_m = 0.035;

struct Scene {
    support::SyntheticSequenceOptions options;
    StereoFrame frame;
    scenes::ThreadEstimate estimate;
};

/// A thread over an even ground, and an estimate of it that is off by `error_C`.
Scene scene_of(std::uint64_t seed, const Eigen::Vector3d& error_C) {
    Scene scene;
    scene.options.seed = seed;
    scene.options.clutter = false;
    const support::SyntheticFrame drawn = support::SyntheticSequence(scene.options).frame(0);
    scene.frame.left = drawn.left;
    scene.frame.right = drawn.right;
    scene.frame.instruments = drawn.instruments_C;
    scene.estimate.status = scenes::TrackStatus::kTracking;
    for (int i = 0; i <= 100; ++i) {
        scenes::ThreadSample sample;
        sample.s_m = 0.01 * i * scene.options.length_m;
        sample.p_C = drawn.truth_C.point_at(sample.s_m) + error_C;
        scene.estimate.samples.push_back(sample);
    }
    return scene;
}

/// Paints ground over the thread between two places.
void paint_over(Scene& scene, double from_m, double to_m) {
    scenes::RandomStream random(1, "gap");
    for (const scenes::ThreadSample& sample : scene.estimate.samples) {
        if (sample.s_m < from_m || sample.s_m > to_m) continue;
        for (const bool right : {false, true}) {
            const Eigen::Vector2d px = right ? scene.options.rig.project_right(sample.p_C)
                                             : scene.options.rig.project_left(sample.p_C);
            cv::Mat& image = right ? scene.frame.right : scene.frame.left;
            for (int v = -5; v <= 5; ++v)
                for (int u = -5; u <= 5; ++u)
                    image.at<unsigned char>(static_cast<int>(px.y()) + v, static_cast<int>(px.x()) + u) =
                        static_cast<unsigned char>(random.normal(150.0, 4.0));
        }
    }
}

TEST(CutCheck, sees_an_intact_thread_through_the_errors_of_the_estimate) {
    for (std::uint64_t seed = 51; seed < 56; ++seed) {
        const Scene scene = scene_of(seed, Eigen::Vector3d(0.0005, -0.0005, 0.002));
        const CutCheck check = check_cut(scene.frame, scene.options.rig, scene.estimate, kCutAt_m);
        EXPECT_EQ(check.verdict, CutVerdict::kIntact) << "seed " << seed << " support " << check.support_at;
    }
}

TEST(CutCheck, sees_the_gap_of_a_cut_thread) {
    for (std::uint64_t seed = 51; seed < 56; ++seed) {
        Scene scene = scene_of(seed, Eigen::Vector3d::Zero());
        paint_over(scene, kCutAt_m - 0.0025, kCutAt_m + 0.0025);
        const CutCheck check = check_cut(scene.frame, scene.options.rig, scene.estimate, kCutAt_m);
        EXPECT_EQ(check.verdict, CutVerdict::kCut) << "seed " << seed << " support " << check.support_at;
        EXPECT_GT(check.support_before, 0.4);
        EXPECT_GT(check.support_after, 0.4);
    }
}

TEST(CutCheck, does_not_take_a_thread_that_ends_at_the_place_for_an_intact_one) {
    for (std::uint64_t seed = 51; seed < 56; ++seed) {
        Scene scene = scene_of(seed, Eigen::Vector3d::Zero());
        paint_over(scene, kCutAt_m + 0.0032, kCutAt_m + 0.010);
        const CutCheck check = check_cut(scene.frame, scene.options.rig, scene.estimate, kCutAt_m);
        EXPECT_GT(check.support_at, 0.8);
        EXPECT_LT(check.support_after, 0.5);
        EXPECT_NE(check.verdict, CutVerdict::kIntact) << "seed " << seed;
    }
}

TEST(CutCheck, does_not_take_a_faint_crease_for_the_thread_whose_contrast_it_knows) {
    Scene whole = scene_of(52, Eigen::Vector3d::Zero());
    const double usual_levels =
        check_cut(whole.frame, whole.options.rig, whole.estimate, kCutAt_m).usual_levels;
    Scene crease = whole;
    for (cv::Mat* image : {&crease.frame.left, &crease.frame.right})
        image->forEach<unsigned char>([](unsigned char& level, const int*) {
            level = static_cast<unsigned char>(150 + (level - 150) / 4);
        });
    CutCheckOptions options;
    EXPECT_EQ(check_cut(crease.frame, crease.options.rig, crease.estimate, kCutAt_m, options).verdict,
              CutVerdict::kIntact);
    options.usual_levels = usual_levels;
    EXPECT_EQ(check_cut(crease.frame, crease.options.rig, crease.estimate, kCutAt_m, options).verdict,
              CutVerdict::kCut);
}

TEST(CutCheck, does_not_judge_a_place_behind_an_instrument) {
    Scene scene = scene_of(57, Eigen::Vector3d::Zero());
    const Eigen::Vector3d place_C = scene.estimate.samples[50].p_C;
    scene.frame.instruments.push_back(
        {0.9 * place_C, 0.9 * place_C + Eigen::Vector3d(0.05, 0.0, 0.0), 0.004});
    EXPECT_EQ(check_cut(scene.frame, scene.options.rig, scene.estimate, kCutAt_m).verdict,
              CutVerdict::kUnknown);
}

TEST(CutCheck, does_not_judge_without_an_estimate) {
    Scene scene = scene_of(58, Eigen::Vector3d::Zero());
    scene.estimate.samples.clear();
    EXPECT_EQ(check_cut(scene.frame, scene.options.rig, scene.estimate, kCutAt_m).verdict,
              CutVerdict::kUnknown);
}

}  // namespace
}  // namespace atropos::tracker
