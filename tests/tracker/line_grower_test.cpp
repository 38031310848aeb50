#include "tracker/line_grower.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "scenes/stereo_rig.hpp"
#include "tracker/line_look.hpp"

namespace atropos::tracker {
namespace {

using Eigen::Vector2d;

constexpr double kDisparity_px = 30.0;

/// A circle's arc in the left image, and the same line in the right one.
Vector2d on_arc(double s_px) {
    constexpr double kRadius_px = 150.0;
    const double angle = 0.3 + s_px / kRadius_px;
    return Vector2d(300.0, 40.0) + kRadius_px * Vector2d(-std::cos(angle), std::sin(angle));
}

/// Both eyes' pictures of a line of 300 px, and paths along parts of it.
class LineGrowerTest : public testing::Test {
  protected:
    LineGrowerTest() { draw(); }

    Vector2d in_eye(double s_px, std::size_t eye) const {
        return on_arc(s_px) + Vector2d(shift_px_ - (eye == 0 ? 0.0 : kDisparity_px), 0.0);
    }

    void draw() {
        for (const std::size_t eye : {0, 1}) {
            images_[eye] = cv::Mat1b(360, 640, 160);
            stroke(eye, 0.0, 300.0, 50);
        }
    }

    void stroke(std::size_t eye, double from_px, double to_px, int level) {
        for (double s = from_px; s < to_px; s += 1.0) {
            const auto at = [&](double t) {
                const Vector2d p = 16.0 * in_eye(t, eye);
                return cv::Point(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
            };
            cv::line(images_[eye], at(s), at(s + 1.0), level, 3, cv::LINE_AA, 4);
        }
    }

    std::array<LineEnd, 2> grow(double from_px, double to_px) { return grow({from_px, from_px}, to_px); }
    std::array<LineEnd, 2> grow(const std::array<double, 2>& from_px, double to_px) {
        for (const std::size_t eye : {0, 1}) {
            cv::GaussianBlur(images_[eye], images_[eye], {}, 0.7);
            eyes_[eye].image = channel_view(images_[eye], scenes::ImageChannel::kGray, eyes_[eye].buffer);
            eyes_[eye].map.width = 640;
            eyes_[eye].map.height = 360;
            eyes_[eye].map.at_pixel.assign(640 * 360, RidgePointMap::kNone);
            for (int v = 0; v < 360; ++v)
                for (int u = hidden_from_; u < 640; ++u)
                    eyes_[eye].map.at_pixel[static_cast<std::size_t>(v * 640 + u)] = RidgePointMap::kHidden;
            paths_[eye].points.clear();
            for (double s = from_px[eye]; s < to_px; s += 1.0) {
                const Vector2d along = in_eye(s + 0.5, eye) - in_eye(s - 0.5, eye);
                paths_[eye].points.push_back({in_eye(s, eye), along.normalized(), 20.0});
            }
        }
        return grow_line(view_, eyes_, scenes::ThreadPolarity::kDark, false, 0.0, paths_);
    }

    /// How far an end of the path of an eye lies from a place of the line.
    double off_px(std::size_t eye, int end, double s_px) const {
        return (paths_[eye].end(end).px - in_eye(s_px, eye)).norm();
    }

    RectifiedView view_{scenes::parallel_rig(640, 360, 575.0, 0.005)};
    std::array<cv::Mat1b, 2> images_;
    std::array<EyeLines, 2> eyes_;
    std::array<ImagePath, 2> paths_;
    int hidden_from_ = 640;
    double shift_px_ = 0.0;
};

TEST_F(LineGrowerTest, takes_a_part_of_a_line_to_both_its_ends) {
    EXPECT_EQ(grow(120.0, 200.0), (std::array{LineEnd::kPlain, LineEnd::kPlain}));
    for (const std::size_t eye : {0, 1}) {
        EXPECT_LT(off_px(eye, 0, 0.0), 4.0);
        EXPECT_LT(off_px(eye, 1, 300.0), 4.0);
        for (const RidgePoint& point : paths_[eye].points) {
            double least = 1e9;
            for (double s = -5.0; s < 305.0; s += 0.25)
                least = std::min(least, (in_eye(s, eye) - point.px).norm());
            EXPECT_LT(least, 0.5);
        }
    }
}

TEST_F(LineGrowerTest, goes_over_a_fold_that_hides_the_line_in_one_eye) {
    stroke(1, 220.0, 240.0, 160);
    grow(60.0, 140.0);
    EXPECT_LT(off_px(0, 1, 300.0), 4.0);
}

TEST_F(LineGrowerTest, cuts_off_what_has_not_the_lines_contrast) {
    for (const std::size_t eye : {0, 1}) stroke(eye, 301.0, 360.0, 150);
    grow(60.0, 355.0);
    for (const std::size_t eye : {0, 1}) EXPECT_LT(off_px(eye, 1, 300.0), 5.0);
}

TEST_F(LineGrowerTest, says_that_a_line_fades_little_by_little) {
    for (const std::size_t eye : {0, 1})
        for (double s = 240.0; s < 300.0; s += 5.0)
            stroke(eye, s, s + 5.0, static_cast<int>(std::lround(50.0 + 100.0 * (s - 240.0) / 60.0)));
    EXPECT_EQ(grow(60.0, 200.0), (std::array{LineEnd::kPlain, LineEnd::kFades}));
}

TEST_F(LineGrowerTest, says_that_one_eye_sees_more_of_the_line) {
    stroke(1, 300.0, 380.0, 50);
    EXPECT_EQ(grow(60.0, 200.0)[1], LineEnd::kOneEye);
}

TEST_F(LineGrowerTest, ends_at_an_instrument_and_says_so) {
    hidden_from_ = static_cast<int>(in_eye(230.0, 0).x());
    EXPECT_EQ(grow(60.0, 140.0)[1], LineEnd::kHidden);
    EXPECT_LT(off_px(0, 1, 230.0), 4.0);
}

TEST_F(LineGrowerTest, keeps_what_one_eye_sees_where_the_others_image_ends) {
    shift_px_ = -140.0;
    draw();
    EXPECT_EQ(grow({0.0, 60.0}, 200.0)[0], LineEnd::kLeaves);
    EXPECT_LT(off_px(0, 0, 0.0), 4.0);
    EXPECT_LT(paths_[1].end(0).px.x(), 8.0);
}

TEST(LineLook, sees_a_line_where_it_is_and_in_the_shade_as_well) {
    for (const double light : {1.0, 0.6}) {
        cv::Mat1b image(100, 200, static_cast<unsigned char>(light * 200.0));
        cv::line(image, {0, 50}, {199, 50}, light * 60.0, 3, cv::LINE_AA);
        cv::GaussianBlur(image, image, {}, 0.7);
        cv::Mat buffer;
        ImagePath path;
        for (int u = 20; u < 180; ++u) path.points.push_back({{u, 50.0}, {1.0, 0.0}, 20.0});
        const LineLook look(channel_view(image, scenes::ImageChannel::kGray, buffer), path,
                            scenes::ThreadPolarity::kDark);
        EXPECT_NEAR(look.width_px(), 4.0, 1.0);  // OpenCV's edges add a pixel
        const LineSight sight = look.at({{100.0, 48.4}, {1.0, 0.0}, 0.0}, 3.0);
        EXPECT_NEAR(sight.offset_px, 1.6, 0.1);
        EXPECT_NEAR(sight.contrast, 0.65, 0.08);
        EXPECT_LT(look.beside({{100.0, 50.0}, {1.0, 0.0}, 0.0}, 2.5), 0.02);
    }
}

TEST(LineLook, sees_the_ground_on_both_sides_of_an_edge) {
    cv::Mat1b image(100, 200, 200);
    image(cv::Rect(0, 51, 200, 49)) = 80;
    cv::Mat buffer;
    ImagePath path;
    for (int u = 20; u < 180; ++u) path.points.push_back({{u, 50.0}, {1.0, 0.0}, 20.0});
    const LineLook look(channel_view(image, scenes::ImageChannel::kGray, buffer), path,
                        scenes::ThreadPolarity::kDark);
    const std::array<double, 2> sides = look.sides({{100.0, 50.0}, {1.0, 0.0}, 0.0});
    EXPECT_NEAR(sides[0], 200.0, 1.0);
    EXPECT_NEAR(sides[1], 80.0, 1.0);
}

TEST(LineCourse, sees_a_leap_in_depth_but_not_along_the_epipolar_line) {
    constexpr double kFocal_px = 575.0;
    const auto line = [](double from_px, const Vector2d& along, double disparity_px) {
        std::vector<LineNode> nodes;
        for (double s = from_px; s < from_px + 30.0; s += 1.5) {
            LineNode node;
            node.left = s * along;
            node.disparity_px = disparity_px;
            for (RidgePoint& point : node.eye) point.tangent = along;
            nodes.push_back(node);
        }
        return nodes;
    };
    const Vector2d down(0.0, 1.0), level(1.0, 0.0);
    EXPECT_FALSE(leaps(line(0.0, down, 30.0), line(40.0, down, 31.0), kFocal_px));
    EXPECT_TRUE(leaps(line(0.0, down, 30.0), line(40.0, down, 24.0), kFocal_px));
    EXPECT_FALSE(leaps(line(0.0, level, 30.0), line(40.0, level, 24.0), kFocal_px));
}

TEST(LineCourse, goes_on_along_a_circle_and_a_ramp_of_disparity) {
    std::vector<LineNode> line;
    for (double s = 0.0; s < 60.0; s += 1.5) {
        LineNode node;
        node.left = on_arc(s);
        node.disparity_px = 20.0 + 0.05 * s;
        node.seen = {true, true};
        line.push_back(node);
    }
    const LineCourse course = course_of(line, 0.0);
    EXPECT_LT((course.ahead(15.0) - on_arc(58.5 + 15.0)).norm(), 0.5);
    EXPECT_NEAR(course.disparity_px + 15.0 * course.slope, 20.0 + 0.05 * 73.5, 0.2);
}

}  // namespace
}  // namespace atropos::tracker
