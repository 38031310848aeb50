#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "render/sensor.hpp"
#include "render_scenes.hpp"

namespace atropos::render {
namespace {

struct Error {
    double sum2 = 0.0, max = 0.0, sum = 0.0;
    int count = 0;
    void add(double e) {
        sum += e;
        sum2 += e * e;
        max = std::max(max, std::abs(e));
        ++count;
    }
    double rms() const { return std::sqrt(sum2 / count); }
    double mean() const { return sum / count; }
};

ThreadRibbon white_thread(scenes::Polyline curve, bool lit = false) {
    ThreadRibbon ribbon;
    ribbon.curve_W = std::move(curve);
    ribbon.look.colour.setOnes();
    ribbon.look.lit = lit;
    return ribbon;
}

// A straight thread through the image's middle at an angle, slanted in depth.
scenes::Polyline straight(double angle_rad, double offset_m) {
    const Eigen::Vector3d along(std::cos(angle_rad), std::sin(angle_rad), 0.25);
    const Eigen::Vector3d across(-std::sin(angle_rad), std::cos(angle_rad), 0.0);
    const Eigen::Vector3d middle = Eigen::Vector3d(0.001, 0.0007, 0.1) + offset_m * across;
    scenes::Polyline line;
    for (int i = 0; i <= 200; ++i) line.points.push_back(middle + (0.06 * i / 200.0 - 0.03) * along);
    return line;
}

// Arc of a circle through the image's middle.
scenes::Polyline arc(double radius_m, double angle_rad) {
    scenes::Polyline line;
    for (int i = 0; i <= 1600; ++i) {
        const double a = angle_rad + (i / 1600.0 - 0.5) * 0.04 / radius_m;
        const double a0 = angle_rad;
        line.points.emplace_back(radius_m * (std::cos(a) - std::cos(a0)),
                                 radius_m * (std::sin(a) - std::sin(a0)), 0.1 + 0.2 * radius_m * (a - a0));
    }
    return line;
}

// Centroid of the light on lines across the axis, against the projected curve. Lines run along rows or
// columns, whichever the thread crosses more squarely; errors are perpendicular to the axis.
template <class Pixel>
void measure(const Pixel& light, const scenes::Camera& camera, const Eigen::Isometry3d& X_EW,
             const scenes::Polyline& curve, Error& error) {
    std::vector<Eigen::Vector2d> axis;
    for (const auto& p : curve.points) axis.push_back(camera.project(X_EW * p));
    const Eigen::Vector2d overall = axis.back() - axis.front();
    const int across = std::abs(overall.x()) > std::abs(overall.y()) ? 1 : 0, along = 1 - across;
    const int first = static_cast<int>(std::ceil(std::min(axis.front()[along], axis.back()[along]))) + 8;
    const int last = static_cast<int>(std::floor(std::max(axis.front()[along], axis.back()[along]))) - 8;
    const int size[2] = {camera.width_px, camera.height_px};
    for (int line = std::max(first, 10); line <= std::min(last, size[along] - 10); ++line) {
        for (std::size_t i = 0; i + 1 < axis.size(); ++i) {
            const double a = axis[i][along] - line, b = axis[i + 1][along] - line;
            if (a * b > 0.0 || a == b) continue;
            const Eigen::Vector2d at = axis[i] + (axis[i + 1] - axis[i]) * (a / (a - b));
            const int middle = static_cast<int>(std::lround(at[across]));
            if (middle < 14 || middle > size[across] - 14) break;
            double sum = 0.0, moment = 0.0;
            for (int k = middle - 12; k <= middle + 12; ++k) {
                const double value = across == 0 ? light(k, line) : light(line, k);
                sum += value;
                moment += value * k;
            }
            const Eigen::Vector2d direction = (axis[i + 1] - axis[i]).normalized();
            error.add((moment / sum - at[across]) * std::abs(direction[along]));
            break;
        }
    }
}

// Across a bent thread rows cut aslant: here the mean signed distance of the light from the curve, in windows
// of 3 px (one sigma) along it, each pixel weighted by how the curve's bend stretches its strip.
void measure_bent(const cv::Mat& linear, const scenes::Camera& camera, const scenes::Polyline& curve,
                  Error& error) {
    std::vector<Eigen::Vector2d> axis;
    std::vector<double> arc_px = {0.0};
    for (const auto& p : curve.points) axis.push_back(camera.project(p));
    for (std::size_t i = 1; i < axis.size(); ++i)
        arc_px.push_back(arc_px.back() + (axis[i] - axis[i - 1]).norm());
    const int windows = static_cast<int>((arc_px.back() - 60.0) / 2.0);
    std::vector<double> sum(static_cast<std::size_t>(windows), 0.0), moment(sum);
    for (int y = 0; y < linear.rows; ++y) {
        for (int x = 0; x < linear.cols; ++x) {
            const double light = linear.at<cv::Vec3f>(y, x)[1];
            if (light <= 0.0) continue;
            const Eigen::Vector2d p(x, y);
            std::size_t nearest = 0;
            for (std::size_t i = 0; i < axis.size(); ++i) {
                if ((axis[i] - p).squaredNorm() < (axis[nearest] - p).squaredNorm()) nearest = i;
            }
            constexpr std::size_t n = 8;
            if (nearest < n || nearest + n >= axis.size()) continue;
            const Eigen::Vector2d along = (axis[nearest + 1] - axis[nearest - 1]).normalized();
            const Eigen::Vector2d d = p - axis[nearest];
            const double before = std::atan2(axis[nearest].y() - axis[nearest - n].y(),
                                             axis[nearest].x() - axis[nearest - n].x());
            const double after = std::atan2(axis[nearest + n].y() - axis[nearest].y(),
                                            axis[nearest + n].x() - axis[nearest].x());
            const double bend = std::remainder(after - before, 2.0 * std::numbers::pi) * 2.0 /
                                (arc_px[nearest + n] - arc_px[nearest - n]);
            const double t = d.dot(along);
            const double distance = along.x() * d.y() - along.y() * d.x() - 0.5 * bend * t * t;
            const double weight = light / (1.0 - bend * distance);
            for (int k = 0; k < windows; ++k) {
                const double from = (arc_px[nearest] + t - 30.0 - 2.0 * k) / 3.0;
                if (std::abs(from) > 5.0) continue;
                const double w = weight * std::exp(-0.5 * from * from);
                sum[static_cast<std::size_t>(k)] += w;
                moment[static_cast<std::size_t>(k)] += w * distance;
            }
        }
    }
    for (std::size_t k = 0; k < sum.size(); ++k) error.add(moment[k] / sum[k]);
}

double run(const scenes::StereoRig& rig, const std::vector<scenes::Polyline>& curves, Error& error,
           bool lit = false) {
    StereoEndoscope endoscope(endoscope_preset("fast"), rig);
    for (const auto& curve : curves) {
        const std::vector<ThreadRibbon> ribbons = {white_thread(curve, lit)};
        FrameInput input;
        input.ribbons = ribbons;
        const StereoFrame frame = endoscope.render(input);
        measure([&](int x, int y) { return frame.left.linear.at<cv::Vec3f>(y, x)[1]; }, rig.left,
                Eigen::Isometry3d::Identity(), curve, error);
        measure([&](int x, int y) { return frame.right.linear.at<cv::Vec3f>(y, x)[1]; }, rig.right, rig.X_RC,
                curve, error);
    }
    return error.rms();
}

double linear_of(std::uint8_t coded) {
    const double v = coded / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

void report(const char* what, const Error& error) {
    std::printf("%s: rms %.5f max %.5f mean %.5f px of %d\n", what, error.rms(), error.max, error.mean(),
                error.count);
}

std::vector<scenes::Polyline> straight_threads() {
    std::vector<scenes::Polyline> curves;
    for (int i = 0; i < 18; ++i) {
        for (int k = 0; k < 3; ++k) curves.push_back(straight(i * std::numbers::pi / 18.0, k * 0.000061));
    }
    return curves;
}

TEST(ThreadRibbon, lies_on_its_axis_at_every_angle_to_a_thousandth_of_a_pixel) {
    Error error;
    run(scenes::rig_preset("paper").rig, straight_threads(), error);
    report("straight", error);
    EXPECT_GT(error.count, 20000);
    EXPECT_LE(error.rms(), 0.002);
    EXPECT_LE(error.max, 0.01);
}

TEST(ThreadRibbon, lies_on_its_axis_where_it_bends) {
    std::vector<scenes::Polyline> curves;
    for (int i = 0; i < 18; ++i) curves.push_back(arc(0.02 + 0.004 * i, i * std::numbers::pi / 18.0));
    Error error;
    const scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    StereoEndoscope endoscope(endoscope_preset("fast"), rig);
    for (const auto& curve : curves) {
        const std::vector<ThreadRibbon> ribbons = {white_thread(curve)};
        FrameInput input;
        input.ribbons = ribbons;
        measure_bent(endoscope.render(input).left.linear, rig.left, curve, error);
    }
    report("curved", error);
    EXPECT_LE(error.rms(), 0.002);
    EXPECT_LE(error.max, 0.01);
}

TEST(ThreadRibbon, keeps_its_place_in_eight_bits) {
    const scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    StereoEndoscope endoscope(endoscope_preset("fast"), rig);
    const Sensor sensor(sensor_preset("ideal"), rig, 1);
    Error error;
    for (const auto& curve : straight_threads()) {
        const std::vector<ThreadRibbon> ribbons = {white_thread(curve)};
        FrameInput input;
        input.ribbons = ribbons;
        const cv::Mat picture = sensor.develop(endoscope.render(input), 0).left;
        measure([&](int x, int y) { return linear_of(picture.at<cv::Vec3b>(y, x)[1]); }, rig.left,
                Eigen::Isometry3d::Identity(), curve, error);
    }
    report("8 bits", error);
    EXPECT_LE(error.rms(), 0.03);
}

// What the figures above are worth: the same picture, measured by a camera half a pixel beside.
TEST(ThreadRibbon, would_show_a_mistake_of_half_a_pixel) {
    const scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    scenes::Camera beside = rig.left;
    beside.cx_px += 0.5;
    beside.cy_px += 0.5;
    StereoEndoscope endoscope(endoscope_preset("fast"), rig);
    Error error;
    const scenes::Polyline curve = straight(0.3, 0.0);
    const std::vector<ThreadRibbon> ribbons = {white_thread(curve)};
    FrameInput input;
    input.ribbons = ribbons;
    const cv::Mat linear = endoscope.render(input).left.linear;
    measure([&](int x, int y) { return linear.at<cv::Vec3f>(y, x)[1]; }, beside,
            Eigen::Isometry3d::Identity(), curve, error);
    EXPECT_NEAR(error.rms(), 0.5 * std::abs(std::cos(0.3) - std::sin(0.3)), 0.02);
}

TEST(ThreadRibbon, is_shifted_by_its_own_shading_when_lit) {
    Error error;
    run(scenes::rig_preset("paper").rig, straight_threads(), error, true);
    report("lit", error);
    // A light beside the lens makes the near side brighter: stated, not wanted to be nothing.
    EXPECT_LE(error.rms(), 0.1);
}

TEST(ThreadRibbon, follows_the_lens_distortion) {
    scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    rig.left.distortion = rig.right.distortion = {-0.12, 0.05, 0.001, -0.0005, 0.0, 0.0, 0.0, 0.0};
    Error error;
    run(rig, straight_threads(), error);
    report("distorted", error);
    EXPECT_LE(error.rms(), 0.02);
    EXPECT_LE(error.max, 0.02);
}

}  // namespace
}  // namespace atropos::render
