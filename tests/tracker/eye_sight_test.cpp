#include "tracker/eye_sight.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "tests/support/synthetic_sequence.hpp"

namespace atropos::tracker {
namespace {

using support::SyntheticFrame;
using support::SyntheticSequence;
using support::SyntheticSequenceOptions;

ImageView view_of(const cv::Mat1b& image) {
    return {image.data, static_cast<std::ptrdiff_t>(image.step), 1, image.cols, image.rows};
}

/// A smooth picture from a formula, moved by `shift` px.
cv::Mat1b waves(const Eigen::Vector2d& shift) {
    cv::Mat1b image(100, 160);
    for (int v = 0; v < image.rows; ++v)
        for (int u = 0; u < image.cols; ++u) {
            const double x = u - shift.x(), y = v - shift.y();
            const double level = 128.0 +
                                 50.0 * std::sin(0.23 * x + 0.11 * y) * std::cos(0.31 * y - 0.05 * x) +
                                 30.0 * std::sin(0.007 * x * x - 0.17 * y);
            image(v, u) = static_cast<unsigned char>(std::lround(level));
        }
    return image;
}

TEST(PatchMatcher, finds_a_moved_patch_to_hundredths_of_a_pixel) {
    for (const Eigen::Vector2d& shift : {Eigen::Vector2d(-7.3, 1.6), Eigen::Vector2d(2.45, -0.52)}) {
        const cv::Mat1b left = waves({0.0, 0.0}), right = waves(shift);
        PatchMatcher matcher;
        const auto centre = matcher.choose(view_of(left), cv::Rect(70, 40, 20, 20));
        ASSERT_TRUE(centre);
        const auto match = matcher.find(view_of(right), cv::Rect(centre->x - 12, centre->y - 4, 25, 9));
        ASSERT_TRUE(match);
        EXPECT_LT((match->right_px - match->left_px - shift).norm(), 0.02);
    }
}

TEST(PatchMatcher, does_not_find_what_is_not_there) {
    const cv::Mat1b left = waves({0.0, 0.0}), right = waves({40.0, 0.0});
    PatchMatcher matcher;
    const auto centre = matcher.choose(view_of(left), cv::Rect(70, 40, 20, 20));
    ASSERT_TRUE(centre);
    EXPECT_FALSE(matcher.find(view_of(right), cv::Rect(centre->x - 4, centre->y - 3, 9, 7)));
}

/// Looks at `frames` of a drawn sequence, told a rig whose right eye is off by `error`.
EyeFound found_in(const SyntheticSequenceOptions& options, const EyeCorrection& error, int frames) {
    scenes::StereoRig rig = options.rig;
    rig.right.cy_px -= error.row_px;
    rig.X_RC = Eigen::AngleAxisd(-error.roll_rad, Eigen::Vector3d::UnitZ()) * rig.X_RC;
    const SyntheticSequence sequence(options);
    EyeSight eye({}, rig);
    for (int i = 0; i < frames; ++i) {
        const SyntheticFrame frame = sequence.frame(i);
        eye.look({view_of(frame.left), view_of(frame.right)}, i == 0 ? 0.0 : 1.0 / 30.0);
    }
    return eye.found();
}

TEST(EyeSight, finds_rows_and_roll_within_its_sigmas) {
    for (const std::uint64_t seed : {1, 2, 3, 4}) {
        const EyeCorrection error{seed % 2 == 0 ? 1.5 : -1.5, seed < 3 ? 0.0035 : -0.0035};
        const EyeFound found = found_in({.seed = seed}, error, 3);
        EXPECT_NEAR(found.correction.row_px, error.row_px, 0.06) << seed;
        EXPECT_NEAR(found.correction.roll_rad, error.roll_rad, 0.0005) << seed;
        EXPECT_LT(found.sigmas().row_px, 0.05) << seed;
        const Eigen::Vector2d off(found.correction.row_px - error.row_px,
                                  found.correction.roll_rad - error.roll_rad);
        EXPECT_LT(off.dot(found.covariance.inverse() * off), 14.0) << seed;  // chi-square of two, 99.9 %
    }
}

TEST(EyeSight, claims_nothing_where_it_sees_nothing) {
    cv::Mat1b left(360, 640, uchar{120}), right(360, 640, uchar{120});
    cv::RNG random(7);
    for (cv::Mat1b* image : {&left, &right}) {
        cv::Mat noise(image->size(), CV_8S);
        random.fill(noise, cv::RNG::NORMAL, 0.0, 4.0);
        cv::add(*image, noise, *image, cv::noArray(), CV_8U);
    }
    EyeSight eye({}, SyntheticSequenceOptions{}.rig);
    eye.look({view_of(left), view_of(right)}, 0.0);
    EXPECT_GT(eye.found().sigmas().row_px, 0.9);
    EXPECT_LT(std::abs(eye.found().correction.row_px), 0.3);
}

TEST(EyeSight, is_less_sure_where_there_is_less_to_see) {
    const SyntheticSequenceOptions plain{.seed = 3, .clutter = false, .instruments = false};
    const EyeFound found = found_in(plain, {1.5, 0.0035}, 3);
    EXPECT_GT(found.sigmas().row_px, 2.0 * found_in({.seed = 3}, {1.5, 0.0035}, 3).sigmas().row_px);
    EXPECT_LT(std::abs(found.correction.row_px - 1.5), 3.0 * found.sigmas().row_px);
}

TEST(EyeSight, gets_surer_with_every_frame) {
    const double once = found_in({.seed = 2}, {}, 1).sigmas().row_px;
    EXPECT_LT(found_in({.seed = 2}, {}, 12).sigmas().row_px, 0.8 * once);
}

}  // namespace
}  // namespace atropos::tracker
