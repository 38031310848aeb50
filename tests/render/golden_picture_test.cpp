#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>

#include "render/instrument.hpp"
#include "render/sensor.hpp"
#include "render/tissue.hpp"
#include "render_scenes.hpp"

namespace atropos::render {
namespace {

const std::filesystem::path kGolden = ATROPOS_GOLDEN;

/// Tissue, a needle driver with open jaws and a hanging violet thread.
cv::Mat draw(const std::string& preset, std::string& renderer) {
    const scenes::StereoRig rig = scenes::rig_preset("paper").rig.scaled(0.375);
    StereoEndoscope endoscope(endoscope_preset(preset), rig);
    TissueOptions options;
    options.texture_px = 256;
    options.cell_m = 0.002;
    const Tissue tissue = make_tissue(options, 7);
    tissue.add_textures(endoscope);
    const Eigen::AngleAxisd half_turn(M_PI, Eigen::Vector3d::UnitX());
    std::vector<scenes::RenderItem> items = {
        tissue.item(Eigen::Translation3d(0.0, 0.0, 0.12) * Eigen::Isometry3d(half_turn))};
    const InstrumentModel tool = load_instrument(ATROPOS_MESHES "/needle_driver");
    Eigen::Isometry3d X_WT =
        Eigen::Translation3d(-0.01, 0.0, 0.095) *
        Eigen::Isometry3d(Eigen::AngleAxisd(-0.9, Eigen::Vector3d(0.0, 1.0, 0.3).normalized()));
    for (int link = 0; link < 4; ++link) {
        const double jaw_rad = link == 2 ? 0.3 : link == 3 ? -0.3 : 0.0;
        tool.append(link, X_WT * Eigen::AngleAxisd(jaw_rad, Eigen::Vector3d::UnitY()), scenes::Label::kPSM1,
                    items);
    }
    ThreadRibbon thread;
    thread.look = thread_look("violet", "braided");
    for (int i = 0; i <= 60; ++i) {
        const double t = i / 30.0 - 1.0;
        thread.curve_W.points.emplace_back(0.028 * t, 0.012 * (1.0 - t * t), 0.095 + 0.006 * t);
    }
    const std::vector<ThreadRibbon> ribbons = {thread};
    FrameInput input;
    input.items = items;
    input.ribbons = ribbons;
    renderer = endoscope.description();
    const StereoImages images = Sensor(sensor_preset("ideal"), rig, 1).develop(endoscope.render(input), 0);
    cv::Mat pair;
    cv::hconcat(images.left, images.right, pair);
    return pair;
}

class GoldenPicture : public testing::TestWithParam<std::string> {};

// The bound is for other versions of Mesa: they may round otherwise, and edges without anti-aliasing jump by
// a pixel. ATROPOS_WRITE_GOLDEN=1 draws the pictures anew; look at them before you commit them.
TEST_P(GoldenPicture, is_drawn_again) {
    std::string renderer;
    const cv::Mat picture = draw(GetParam(), renderer);
    const auto file = kGolden / (GetParam() + ".png"), name = kGolden / (GetParam() + ".txt");
    if (std::getenv("ATROPOS_WRITE_GOLDEN")) {
        std::filesystem::create_directories(kGolden);
        cv::imwrite(file.string(), picture);
        std::ofstream(name) << renderer << "\n";
    }
    const cv::Mat golden = cv::imread(file.string());
    ASSERT_EQ(golden.size(), picture.size());
    std::ifstream stream(name);
    const std::string golden_renderer{std::istreambuf_iterator<char>(stream), {}};
    const double mean = cv::norm(picture, golden, cv::NORM_L1) / static_cast<double>(3 * picture.total());
    std::printf("golden by %s  now by %s\n  mean difference %.4f\n", golden_renderer.c_str(),
                renderer.c_str(), mean);
    EXPECT_LE(mean, 0.5);
    cv::Mat difference, far;
    cv::absdiff(picture, golden, difference);
    cv::inRange(difference, cv::Scalar::all(0), cv::Scalar::all(12), far);
    EXPECT_LE(1.0 - cv::countNonZero(far) / static_cast<double>(far.total()), 0.005)
        << "pixels more than 12 levels off";
}

INSTANTIATE_TEST_SUITE_P(Presets, GoldenPicture,
                         testing::Values(std::string("fast"), std::string("quality")));

}  // namespace
}  // namespace atropos::render
