#include "tracker/line_course.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr double kSine = 0.35;  // of what runs along the epipolar line

}  // namespace

LineCourse course_of(std::span<const LineNode> line, double unseen_px, const LineCourseOptions& options) {
    constexpr double kNoise_px = 0.3, kSlope = 0.4;  // of a node; of disparities along threads
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero(), moments = Eigen::Matrix3d::Zero();
    double s = 0.0;
    for (auto node = line.rbegin(); node != line.rend(); ++node) {
        if (node != line.rbegin()) s -= (std::prev(node)->left - node->left).norm();
        if (-s > options.memory_px + unseen_px) break;
        if (!node->both()) continue;
        const Eigen::Vector3d row(1.0, s, 0.5 * s * s);
        information += row * row.transpose();
        moments += row * Eigen::RowVector3d(node->left.x(), node->left.y(), node->disparity_px);
    }
    information.diagonal().array() += 1e-9;
    Eigen::Matrix3d in_image = information;
    in_image(2, 2) += std::pow(kNoise_px * options.sharpest_turn_px, 2);
    Eigen::Matrix2d in_depth = information.topLeftCorner<2, 2>();
    in_depth(1, 1) += std::pow(kNoise_px / kSlope, 2);
    const Eigen::Matrix<double, 3, 2> curve = in_image.ldlt().solve(moments.leftCols<2>());
    const Eigen::Vector2d depth = in_depth.ldlt().solve(moments.topRightCorner<2, 1>());
    return {.place = curve.row(0).transpose(),
            .direction = curve.row(1).transpose() / std::max(curve.row(1).norm(), 1e-6),
            .bend_per_px = curve.row(2).transpose(),
            .disparity_px = depth[0],
            .slope = depth[1]};
}

double known_disparity_px(std::span<const LineNode> line) {
    constexpr double kNoise_px = 1.5, kDriftAPx = 0.1;
    double level_px = 0.0;
    for (std::size_t k = line.size(); k > 0; --k) {
        if (std::abs(line[k - 1].eye[0].tangent.y()) > kSine) break;
        if (k > 1) level_px += (line[k - 1].left - line[k - 2].left).norm();
    }
    return kNoise_px + kDriftAPx * level_px;
}

bool leaps(std::span<const LineNode> line, std::span<const LineNode> stretch, double focal_px) {
    constexpr double kSteepest = 2.1;  // slope to the image plane: 65 degrees
    const LineNode& back = line.back();
    const double known_px = known_disparity_px(line),
                 slope = kSteepest * std::abs(back.disparity_px) / focal_px;
    const auto leaping = std::count_if(stretch.begin(), stretch.end(), [&](const LineNode& node) {
        const Eigen::Vector2d way = node.left - back.left;
        return std::abs(way.y()) > kSine * way.norm() &&
               std::abs(node.disparity_px - back.disparity_px) > known_px + slope * way.norm();
    });
    return 2 * leaping > std::ssize(stretch);
}

}  // namespace atropos::tracker
