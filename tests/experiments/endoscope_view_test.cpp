// What the scene's keys of cameras and chips do to pictures and truth.
#include "experiments/endoscope_view.hpp"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

#include "experiments/sequence_generator.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/scene_file.hpp"
#include "tests/experiments/temporary_folder.hpp"

namespace atropos::experiments {
namespace {

using Overrides = std::vector<std::string>;

/// Small pictures through ideal chips; the holding arms carry the thread about.
scenes::SceneConfig scene(Overrides overrides) {
    const Overrides small = {"camera.width_px=320", "sensor.preset=ideal", "arms.speed_mm_s=60",
                             "arms.accuracy=perfect", "tissue.preset=pad"};
    overrides.insert(overrides.begin(), small.begin(), small.end());
    return scenes::load_scene(ATROPOS_SCENES "/auto_scissors.yaml", overrides);
}

View view_of(const Overrides& overrides, int ticks = 0, int frame = 0) {
    Testbed testbed(scene(overrides));
    EndoscopeView endoscope(testbed);
    for (int i = 0; i < ticks; ++i) testbed.tick();
    return endoscope.capture(testbed, frame);
}

double brightness(const cv::Mat& picture, const cv::Rect& part) {
    const cv::Scalar mean = cv::mean(picture(part));
    return mean[0] + mean[1] + mean[2];
}
double brightness(const cv::Mat& picture) {
    return brightness(picture, {0, 0, picture.cols, picture.rows});
}

bool same(const cv::Mat& a, const cv::Mat& b) {
    return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

double highest(const cv::Mat& plane) {
    double value = 0.0;
    cv::minMaxLoc(plane, nullptr, &value);
    return value;
}

TEST(EndoscopeView, exposes_and_gains_as_the_scene_says) {
    const View plain = view_of({}), dark = view_of({"sensor.exposure=0.2"}),
               raised = view_of({"sensor.exposure=0.2", "sensor.auto_gain=on"}),
               raised_too = view_of({"sensor.auto_gain=on"});
    EXPECT_LT(brightness(dark.left), 0.6 * brightness(plain.left));
    EXPECT_GT(brightness(raised.left), 1.3 * brightness(dark.left));
    EXPECT_GT(brightness(raised_too.left), brightness(raised.left));  // 4 times is the most
    EXPECT_TRUE(same(plain.truth.left.linear, dark.truth.left.linear));
}

TEST(EndoscopeView, darkens_corners_adds_noise_and_compresses_as_the_scene_says) {
    const cv::Rect corner(0, 0, 20, 20), middle(150, 80, 20, 20);
    const View plain = view_of({}), vignetted = view_of({"sensor.vignetting=1"}),
               noisy = view_of({"sensor.read_noise=0.03", "sensor.shot_noise=0"}),
               later = view_of({"sensor.read_noise=0.03", "sensor.shot_noise=0"}, 0, 1),
               shot = view_of({"sensor.read_noise=0.03", "sensor.shot_noise=20"}),
               packed = view_of({"sensor.jpeg_quality=20"});
    EXPECT_LT(brightness(vignetted.left, corner) / brightness(plain.left, corner),
              0.95 * brightness(vignetted.left, middle) / brightness(plain.left, middle));
    EXPECT_FALSE(same(noisy.left, plain.left));
    EXPECT_FALSE(same(noisy.left, later.left));
    EXPECT_GT(cv::norm(shot.left, plain.left), 1.2 * cv::norm(noisy.left, plain.left));
    EXPECT_FALSE(same(packed.left, plain.left));
    EXPECT_LT(cv::norm(packed.left, plain.left, cv::NORM_L1) / static_cast<double>(plain.left.total()), 30.0);
    const View bare = view_of({"sensor.preset=realistic", "sensor.auto_gain=off", "sensor.vignetting=0",
                               "sensor.read_noise=0", "sensor.jpeg_quality=0"});
    EXPECT_TRUE(same(bare.left, plain.left));
}

TEST(EndoscopeView, spreads_points_as_the_scene_says) {
    EXPECT_LT(highest(view_of({"render.blur_px=3"}).truth.left.coverage),
              0.7 * highest(view_of({"render.blur_px=0.8"}).truth.left.coverage));
}

TEST(EndoscopeView, distorts_pictures_and_truth_alike) {
    const View plain = view_of({}), bent = view_of({"camera.k1=-0.2"});
    double moved_px = 0.0;
    for (size_t i = 0; i < plain.samples.size(); ++i) {
        const TruthSample& s = bent.samples[i];
        moved_px = std::max(moved_px, (s.pixel[0] - plain.samples[i].pixel[0]).norm());
        const cv::Point at(static_cast<int>(std::lround(s.pixel[0].x())),
                           static_cast<int>(std::lround(s.pixel[0].y())));
        if (!s.in_span || s.i < 25 || s.i > 85) continue;  // between the jaws
        EXPECT_GT(bent.truth.left.coverage.at<float>(at), 0.2f) << i;
    }
    EXPECT_GT(moved_px, 1.0);
}

TEST(EndoscopeView, blurs_what_moves_and_gives_the_truth_of_the_middle) {
    const int ticks = 400;
    const View sharp = view_of({}, ticks), blurred = view_of({"sensor.exposure_time_ms=40"}, ticks),
               middle = view_of({}, ticks - 15);
    ASSERT_EQ(blurred.samples.size(), middle.samples.size());
    EXPECT_LT((blurred.samples[50].p_C - middle.samples[50].p_C).norm(), 1e-12);
    EXPECT_GT((blurred.samples[50].p_C - sharp.samples[50].p_C).norm(), 1e-5);
    cv::Mat mean = cv::Mat::zeros(middle.truth.left.coverage.size(), CV_32F);
    for (const int before : {35, 25, 15, 5}) mean += 0.25 * view_of({}, ticks - before).truth.left.coverage;
    EXPECT_LT(cv::norm(blurred.truth.left.coverage, mean, cv::NORM_INF), 1e-5);
    EXPECT_GT(cv::norm(blurred.truth.left.coverage, sharp.truth.left.coverage, cv::NORM_INF), 0.05);
    const View still = view_of({"sensor.exposure_time_ms=40"});
    EXPECT_LT(cv::norm(still.left, view_of({}).left, cv::NORM_INF), 2.0) << "at rest there is no blur";
}

TEST(EndoscopeView, shows_the_left_eye_an_earlier_moment_than_the_right) {
    const int ticks = 400;
    const View skewed = view_of({"sensor.right_eye_delay_ms=12"}, ticks), now = view_of({}, ticks),
               before = view_of({}, ticks - 12);
    EXPECT_TRUE(same(skewed.right, now.right));
    EXPECT_TRUE(same(skewed.left, before.left));
    EXPECT_FALSE(same(now.left, before.left));
    EXPECT_EQ(skewed.samples[50].pixel[0], before.samples[50].pixel[0]);
    EXPECT_EQ(skewed.samples[50].pixel[1], now.samples[50].pixel[1]);
}

class ToldRigTest : public TemporaryFolder {};

TEST_F(ToldRigTest, is_not_the_rig_that_draws) {
    const Overrides error = {"sensor.calibration_error=1", "duration_s=0.04"};
    Testbed told(scene(error)), exact(scene({}));
    EXPECT_EQ(exact.told_rig().left.cx_px, exact.rig().left.cx_px);
    EXPECT_EQ(told.rig().left.cx_px, exact.rig().left.cx_px);
    const Eigen::Vector3d p_C(0.01, 0.005, 0.1);
    const double off_px = (told.told_rig().project_right(p_C) - told.rig().project_right(p_C)).norm();
    EXPECT_GT(off_px, 0.01);
    EXPECT_LT(off_px, 3.0);
    EXPECT_TRUE(same(view_of(error).left, view_of({}).left));

    generate_sequence(
        scene(error), 1, folder_ / "sequence", {}, [](int) {}, nlohmann::ordered_json::object());
    const auto written = scenes::load_calibration(folder_ / "sequence/calib/stereo.yaml"),
               truth = scenes::load_calibration(folder_ / "sequence/truth/stereo.yaml");
    EXPECT_NEAR(written.left.cx_px, told.told_rig().left.cx_px, 1e-9);
    EXPECT_NEAR(truth.left.cx_px, told.rig().left.cx_px, 1e-9);
}

class OwnMeshesTest : public TemporaryFolder {};

TEST_F(OwnMeshesTest, replace_the_links_that_they_have) {
    // A plate of 40 mm across the shaft's axis, 10 mm up the shaft.
    write("shaft.obj", "v -20 -20 -10\nv 20 -20 -10\nv 20 20 -10\nv -20 20 -10\nf 1 2 3 4\nf 4 3 2 1\n");
    const View own = view_of({"arms.PSM1.meshes=" + folder_.string(), "arms.PSM1.mesh_scale_m=0.001"}),
               plain = view_of({});
    const auto area = [](const View& view, scenes::Label label) {
        return cv::countNonZero(view.truth.left.labels == static_cast<int>(label));
    };
    EXPECT_GT(area(own, scenes::Label::kPSM1), area(plain, scenes::Label::kPSM1) + 500);
    EXPECT_THROW(view_of({"arms.PSM1.meshes=" + folder_.string()}), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::experiments
