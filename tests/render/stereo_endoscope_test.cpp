#include "render/stereo_endoscope.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <thread>
#include <vector>

#include "render_scenes.hpp"

namespace atropos::render {
namespace {

using scenes::Label;

scenes::StereoRig rig_for(bool distorted) {
    scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    if (distorted)
        rig.left.distortion = rig.right.distortion = {-0.12, 0.05, 0.001, -0.0005, 0.0, 0.0, 0.0, 0.0};
    return rig;
}

class DepthTruth : public testing::TestWithParam<std::tuple<std::string, bool>> {};

TEST_P(DepthTruth, is_a_slanted_plane_to_a_micrometre) {
    const auto [preset, distorted] = GetParam();
    const scenes::StereoRig rig = rig_for(distorted);
    StereoEndoscope endoscope(endoscope_preset(preset), rig);
    scenes::RenderItem plane = item_at(square(0.15f), {0.0, 0.0, 0.1}, Label::kTissue);
    plane.X_WM.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1.0, 0.4, 0.0).normalized()));
    const std::vector<scenes::RenderItem> items = {plane};
    FrameInput input;
    input.items = items;
    const StereoFrame frame = endoscope.render(input);
    const Eigen::Vector3d n = plane.X_WM.linear().col(2);
    const auto check = [&](const EyeFrame& eye, const scenes::Camera& camera, const Eigen::Isometry3d& X_EC) {
        double worst_m = 0.0;
        for (int y = 0; y < camera.height_px; y += 3) {
            for (int x = 0; x < camera.width_px; x += 3) {
                const Eigen::Vector3d ray = camera.normalised(Eigen::Vector2d(x, y)).homogeneous();
                const Eigen::Vector3d n_E = X_EC.linear() * n, p_E = X_EC * plane.X_WM.translation();
                worst_m =
                    std::max(worst_m, std::abs(eye.depth_m.at<float>(y, x) - n_E.dot(p_E) / n_E.dot(ray)));
            }
        }
        std::printf("plane: %.2e mm\n", 1e3 * worst_m);
        // Between vertices a distorted image bends by up to 0.005 px, here worth 0.6 um a hundredth of a
        // pixel.
        EXPECT_LE(worst_m, distorted ? 2e-6 : 1e-6);
    };
    check(frame.left, rig.left, Eigen::Isometry3d::Identity());
    check(frame.right, rig.right, rig.X_RC);
}

INSTANTIATE_TEST_SUITE_P(Presets, DepthTruth,
                         testing::Combine(testing::Values(std::string("fast"), std::string("quality")),
                                          testing::Bool()));

TEST(StereoEndoscope, labels_every_pixel_of_a_known_scene) {
    const scenes::StereoRig rig = rig_for(false);
    for (const char* preset : {"fast", "quality"}) {
        StereoEndoscope endoscope(endoscope_preset(preset), rig);
        const std::vector<scenes::RenderItem> items = {
            item_at(square(0.02f), {0.0, 0.0, 0.1}, Label::kTissue),
            item_at(square(0.01f), {0.005, 0.002, 0.08}, Label::kPSM1)};
        FrameInput input;
        input.items = items;
        const StereoFrame frame = endoscope.render(input);
        const auto check = [&](const EyeFrame& eye, const Eigen::Isometry3d& X_EC) {
            int wrong = 0;
            for (int y = 0; y < rig.left.height_px; ++y) {
                for (int x = 0; x < rig.left.width_px; ++x) {
                    const Eigen::Vector2d n = rig.left.normalised(Eigen::Vector2d(x, y));
                    Label expected = Label::kBackground;
                    for (const scenes::RenderItem& item : items) {
                        const Eigen::Vector3d c = X_EC * item.X_WM.translation();
                        const Eigen::Vector2d d = n * c.z() - c.head<2>();
                        const double half_m = item.label == Label::kTissue ? 0.02 : 0.01;
                        if (d.cwiseAbs().maxCoeff() <= half_m) expected = item.label;
                    }
                    wrong += eye.labels.at<std::uint8_t>(y, x) != static_cast<std::uint8_t>(expected);
                }
            }
            EXPECT_EQ(wrong, 0) << preset;
        };
        check(frame.left, Eigen::Isometry3d::Identity());
        check(frame.right, rig.X_RC);
    }
}

TEST(StereoEndoscope, gives_the_same_bytes_from_both_back_ends_and_with_or_without_its_cache) {
    const scenes::StereoRig rig = rig_for(true);
    scenes::RenderItem floor = item_at(square(0.15f, 40), {0.0, 0.0, 0.1}, Label::kTissue);
    floor.at_rest = true;
    floor.X_WM.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
    const std::vector<scenes::RenderItem> items = {floor,
                                                   item_at(sphere(0.01, 24), {0.01, 0.0, 0.1}, Label::kPSM1)};
    FrameInput input;
    input.items = items;
    for (const int supersampling : {1, 2}) {
        EndoscopeOptions options;
        options.supersampling = supersampling;
        options.backend = Backend::kOSMesa;
        StereoEndoscope osmesa(options, rig);
        const StereoFrame first = osmesa.render(input);
        osmesa.render(input);
        EXPECT_TRUE(same_bytes(first, osmesa.render(input))) << "cached";
        options.backend = Backend::kEgl;
        StereoEndoscope egl(options, rig);
        EXPECT_TRUE(same_bytes(first, egl.render(input))) << "EGL";
    }
}

// Only what moved is drawn, read and blurred again: tools that come, move over each other and the picture's
// rim and leave, one that no label tells from the tissue, and a camera that moves and stops.
TEST(StereoEndoscope, draws_over_its_layer_at_rest_what_it_would_draw_anew) {
    const scenes::StereoRig rig = rig_for(true);
    scenes::RenderItem floor = item_at(square(0.15f, 40), {0.0, 0.0, 0.11}, Label::kTissue);
    floor.at_rest = true;
    const auto ball = sphere(0.008, 16);
    for (const int supersampling : {1, 2}) {
        EndoscopeOptions options;
        options.supersampling = supersampling;
        StereoEndoscope kept(options, rig);
        options.cache_layer_at_rest = false;
        StereoEndoscope anew(options, rig);
        for (int frame = 0; frame < 14; ++frame) {
            std::vector<scenes::RenderItem> items;
            items.reserve(4);
            items.push_back(floor);
            if (frame % 5 != 4)
                items.push_back(item_at(ball, {0.008 * frame - 0.06, 0.0, 0.09}, Label::kPSM1));
            if (frame > 3) items.push_back(item_at(ball, {0.0, 0.02 - 0.003 * frame, 0.1}, Label::kPSM2));
            if (frame == 6 || frame == 7) items.push_back(item_at(ball, {-0.01, 0.01, 0.1}, Label::kTissue));
            FrameInput input;
            input.items = items;
            if (frame > 8) input.X_WC.translation().x() = 0.001 * std::min(frame, 10);
            EXPECT_TRUE(same_bytes(kept.render(input), anew.render(input))) << "frame " << frame;
        }
    }
}

TEST(StereoEndoscope, draws_the_same_in_two_threads_at_once) {
    const scenes::StereoRig rig = rig_for(true);
    const std::vector<scenes::RenderItem> items = {
        item_at(square(0.15f, 40), {0.0, 0.0, 0.11}, Label::kTissue),
        item_at(sphere(0.01, 24), {0.01, 0.0, 0.1}, Label::kPSM1)};
    FrameInput input;
    input.items = items;
    const StereoFrame alone = StereoEndoscope(endoscope_preset("fast"), rig).render(input);
    std::array<StereoFrame, 2> together;
    std::vector<std::jthread> threads;
    for (StereoFrame& frame : together)
        threads.emplace_back([&] {
            StereoEndoscope endoscope(endoscope_preset("fast"), rig);
            for (int i = 0; i < 5; ++i) frame = endoscope.render(input);
        });
    threads.clear();
    for (const StereoFrame& frame : together) EXPECT_TRUE(same_bytes(alone, frame));
}

TEST(StereoEndoscope, refuses_options_out_of_range) {
    EndoscopeOptions options;
    options.supersampling = 3;
    EXPECT_THROW(StereoEndoscope(options, rig_for(false)), std::invalid_argument);
    EXPECT_THROW(endoscope_preset("best"), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::render
