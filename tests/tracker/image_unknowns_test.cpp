#include "tracker/image_unknowns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/table_cases.hpp"

namespace atropos::tracker {
namespace {

const std::vector<Eigen::Vector3d> kPoints = {{-0.02, 0.005, 0.1},  {-0.01, 0.0, 0.11}, {0.0, -0.01, 0.1},
                                              {0.005, 0.0, 0.095},  {0.01, 0.004, 0.1}, {0.015, 0.008, 0.1},
                                              {0.02, 0.006, 0.105}, {0.03, -0.002, 0.1}};

scenes::TrackerConfig in_images() {
    scenes::TrackerConfig config;
    config.parameterisation = scenes::Parameterisation::k2d;
    config.labels.r = 2;
    return config;
}

TEST(ImageUnknowns, of_a_curve_in_space_are_its_images_and_cost_nothing) {
    for (const char* camera : {"default", "converging", "distorted"}) {
        const scenes::StereoRig rig = support::table_case(camera).options.rig;
        ImageUnknowns unknowns(rig, in_images());
        unknowns.begin(kPoints);
        EXPECT_NEAR(unknowns.stereo_energy(), 0.0, 1e-18) << camera;
        NodeLabels labels(8, ImageUnknowns::labels_per_node(2));
        unknowns.place_labels(kPoints, 0.0005, labels);
        for (int k = 0; k < 8; ++k) EXPECT_NEAR(labels.displacement(k, 0).norm(), 0.0, 1e-9) << camera;
    }
}

// Moving both points of a pair alike, or against each other along the epipolar line, keeps the rays together:
// then the images of the displaced point are the displaced images.
TEST(ImageUnknowns, that_respect_the_stereo_constraint_are_images_of_the_displaced_point) {
    const scenes::StereoRig rig = support::table_case("default").options.rig;
    ImageUnknowns unknowns(rig, in_images());
    unknowns.begin(kPoints);
    NodeLabels labels(8, ImageUnknowns::labels_per_node(2));
    unknowns.place_labels(kPoints, 0.0005, labels);
    const std::array<Eye, 2> eyes = make_eyes(rig);
    int consistent = 0, torn = 0;
    for (int k = 0; k < 8; ++k)
        for (int l = 0; l < labels.labels(); ++l) {
            if (labels.cost(k, l) > 1e-9f) {
                ++torn;
                continue;
            }
            ++consistent;
            for (std::size_t eye = 0; eye < 2; ++eye)
                EXPECT_NEAR((eyes[eye].M() * labels.displacement(k, l) - labels.seen(k, l, eye)).norm(), 0.0,
                            1e-6);
        }
    EXPECT_EQ(consistent, 8 * (1 + 3 * 4));  // zero, and the three axes that keep rows together
    EXPECT_EQ(torn, 8 * (1 + 8) * 4);        // what moves the eyes' points to different rows
}

TEST(ImageUnknowns, are_paid_for_by_their_distance_from_the_epipolar_line) {
    const scenes::StereoRig rig = support::table_case("default").options.rig;
    ImageUnknowns unknowns(rig, in_images());
    unknowns.begin(kPoints);
    std::vector<double> state = unknowns.state();
    for (std::size_t k = 0; k < 8; ++k) state[3 * k + 1] += 0.5 * state[3 * k + 2];  // half a pixel down
    unknowns.restore(state);
    EXPECT_NEAR(unknowns.stereo_energy(), 0.25, 1e-9);
}

TEST(ImageUnknowns, track_a_thread_and_repeat_from_a_stored_state) {
    support::SyntheticSequenceOptions options = support::table_case("default").options;
    options.seed = 7;
    const support::SyntheticSequence sequence(options);
    scenes::TrackerConfig config = in_images();
    const auto tracker = make_tracker(config, options.rig);
    const auto other = make_tracker(config, options.rig);
    for (int i = 0; i < 4; ++i) {
        const support::SyntheticFrame drawn = sequence.frame(i);
        const StereoFrame frame = support::stereo_frame(drawn, i);
        if (i == 0) tracker->start(frame, fit_curve(drawn.truth_C, {.length_weight = 1.0}));
        other->restore(tracker->state());
        const TrackResult& result = tracker->track(frame);
        EXPECT_EQ(result.estimate.status, scenes::TrackStatus::kTracking);
        EXPECT_GT(result.support, 0.8);
        EXPECT_EQ(other->track(frame).control_points, result.control_points);
    }
}

}  // namespace
}  // namespace atropos::tracker
