#include "scenes/calibration_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "scenes/file_error.hpp"

namespace atropos::scenes {
namespace {
using testing::HasSubstr;

StereoRig odd_rig() {
    StereoRig rig = parallel_rig(640, 360, 575.123456789, 0.005);
    rig.left.distortion = {-0.12, 0.05, 1e-3, -2e-3, 0.007};
    rig.right.fx_px = 571.3;
    rig.X_RC.linear() =
        Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.1, 1.0, 0.2).normalized()).toRotationMatrix();
    rig.X_RC.translation() = Eigen::Vector3d(-0.0055, 1e-4, 2e-4);
    return rig;
}

void expect_equal(const StereoRig& a, const StereoRig& b, double tolerance) {
    for (const auto& [x, y] : {std::pair{a.left, b.left}, std::pair{a.right, b.right}}) {
        EXPECT_EQ(x.width_px, y.width_px);
        EXPECT_EQ(x.height_px, y.height_px);
        EXPECT_EQ(x.fx_px, y.fx_px);
        EXPECT_EQ(x.fy_px, y.fy_px);
        EXPECT_EQ(x.cx_px, y.cx_px);
        EXPECT_EQ(x.distortion, y.distortion);
    }
    EXPECT_LE((a.X_RC.matrix() - b.X_RC.matrix()).cwiseAbs().maxCoeff(), tolerance);
}

TEST(Calibration, opencv_form_reads_back_equal) {
    expect_equal(parse_opencv_calibration("x", to_opencv_yaml(odd_rig())), odd_rig(), 0.0);
    for (const RigPreset& preset : rig_presets())
        expect_equal(parse_opencv_calibration("x", to_opencv_yaml(preset.rig)), preset.rig, 0.0);
}

TEST(Calibration, ros_form_reads_back_equal) {
    const StereoRig back =
        parse_ros_calibration("l", to_ros_yaml(odd_rig(), false), "r", to_ros_yaml(odd_rig(), true));
    expect_equal(back, odd_rig(), 1e-12);
}

TEST(Calibration, is_read_by_opencv_itself_and_rectifies_the_same_rays) {
    const cv::FileStorage file(to_opencv_yaml(odd_rig()), cv::FileStorage::READ | cv::FileStorage::MEMORY);
    cv::Mat M1, D1, T, R1, P1;
    file["M1"] >> M1;
    file["D1"] >> D1;
    file["T"] >> T;
    file["R1"] >> R1;
    file["P1"] >> P1;
    ASSERT_EQ(T.total(), 3u);
    EXPECT_NEAR(T.at<double>(0), -5.5, 1e-12);
    const std::vector<cv::Point2d> pixel{{100.0, 50.0}};
    std::vector<cv::Point2d> rectified;
    cv::undistortPoints(pixel, rectified, M1, D1, R1, P1);
    const Rectification ours = odd_rig().rectification();
    const Eigen::Vector2d expected =
        (ours.P1 * (ours.R1 * odd_rig().left.ray({100.0, 50.0})).homogeneous()).hnormalized();
    EXPECT_NEAR(rectified[0].x, expected.x(), 1e-2);  // OpenCV 4.6 stops its inverse after five steps
    EXPECT_NEAR(rectified[0].y, expected.y(), 1e-2);
}

const char* const kIni =
    "[StereoLeft]\nres_x=1400\nres_y=986\nfc_x=1500.5\nfc_y=1501\ncc_x=700\ncc_y=490\nk_0=-0.1\nk_1=0.2\nk_2="
    "0.001\nk_3=0.002\nk_4=0.3\n"
    "[StereoRight]\nres_x=1400\nres_y=986\nfc_x=1500\nfc_y=1501\ncc_x=690\ncc_y=490\nk_0=0\nk_1=0\nk_2=0\nk_"
    "3=0\nk_4=0\n"
    "R_0=1\nR_1=0\nR_2=0\nR_3=0\nR_4=1\nR_5=0\nR_6=0\nR_7=0\nR_8=1\nT_0=-5.2\nT_1=0\nT_2=0\n";

TEST(Calibration, reads_the_ini_form_of_dvrk) {
    const StereoRig rig = parse_ini_calibration("x.ini", kIni);
    EXPECT_EQ(rig.left.width_px, 1400);
    EXPECT_DOUBLE_EQ(rig.left.distortion[4], 0.3);
    EXPECT_NEAR(rig.baseline_m(), 0.0052, 1e-12);
}

/// The odd rig's file with one piece of text replaced.
std::string broken(const std::string& from, const std::string& to) {
    std::string text = to_opencv_yaml(odd_rig());
    const std::size_t place = text.find(from);
    EXPECT_NE(place, std::string::npos) << from;
    return text.replace(place, from.size(), to);
}

std::string error_of(const std::string& text) {
    try {
        parse_opencv_calibration("stereo.yaml", text);
    } catch (const FileError& error) {
        return error.what();
    }
    return "no error";
}

TEST(Calibration, refuses_what_is_no_calibration_in_one_line) {
    const std::pair<std::string, std::string> cases[] = {
        {"", "no YAML document"},
        {"hello\n", "no calibration"},
        {"- 1\n", "no calibration"},
        {broken("M1:", "N1:"), "no key 'M1'"},
        {broken("image_size:", "imageSize:"), "no key 'image_size'"},
        {broken("data: [ 640, 360 ]", "data: [ 640 ]"), "image_size has 1 numbers"},
        {broken("data: [ 640, 360 ]", "data: [ 0, 360 ]"), "image_size"},
        {broken("data: [ 640, 360 ]", "data: [ 640, .nan ]"), "no finite number"},
        {broken("data: [ 640, 360 ]", "data: [ 640, 1e300 ]"), "image_size"},
        {broken("575.123456789", "0."), "focal length"},
        {broken("575.123456789", "-5."), "focal length"},
        {broken("575.123456789", "inf"), "no finite number"},
        {broken("575.123456789", "abc"), "no finite number"},
        {broken("575.123456789, 0.,", "575.123456789, 3.,"), "no camera matrix"},
        {broken("rows: 3", "rows: 4"), "4x3, expected 3x3"},
        {broken("rows: 3", "rows: -3"), "'rows'"},
        {broken("rows: 3", "rows: 999999999"), "'rows'"},
        {broken("T: !!opencv-matrix", "T: 5\nX: !!opencv-matrix"), "T is no matrix"},
        {broken("-5.5, 0.1, 0.2", "0., 0., 0."), "baseline is 0"},
        {broken("-5.5, 0.1, 0.2", "-5100., 0.1, 0.2"), "is T in mm"},
        {broken("R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 0.",
                "R: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 9."),
         "not a rotation"},
    };
    for (const auto& [text, expected] : cases) {
        const std::string error = error_of(text);
        EXPECT_THAT(error, HasSubstr(expected));
        EXPECT_EQ(error.find('\n'), std::string::npos);
    }
    EXPECT_THROW(load_calibration("/nonexistent/stereo.yaml"), FileError);
    EXPECT_THROW(parse_ini_calibration("x.ini", "fc_x\n"), FileError);
    EXPECT_THROW(parse_ini_calibration("x.ini", "[StereoLeft]\nfc_x=nan\n"), FileError);
    EXPECT_THROW(parse_ros_calibration("l", "a: 1\n", "r", "a: 1\n"), FileError);
}

}  // namespace
}  // namespace atropos::scenes
