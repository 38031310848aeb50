#include "tracker/label_set.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace atropos::tracker {
namespace {

constexpr double kTable1Reach_px = 14.0;  // at 640, over all steps (III-A)
constexpr double kReferenceWidth_px = 640.0;

}  // namespace

std::vector<Eigen::Vector3d> label_set(int r, double s_m, const Eigen::Matrix3d& axes) {
    const double directions[7][3] = {
        {0, 1, 0},  {1, 0, 0},  {0, 0, 1}, {1, 1, 1},
        {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};  // top-down, left-right, front-back, diagonals
    std::vector<Eigen::Vector3d> labels{Eigen::Vector3d::Zero()};
    for (const auto& d : directions)
        for (int i = 1; i <= r; ++i)
            for (const double sign : {1.0, -1.0})
                labels.emplace_back(axes * (sign * i * s_m * Eigen::Vector3d(d[0], d[1], d[2])));
    return labels;
}

Eigen::Matrix3d ray_axes(const Eigen::Vector3d& p_C, double depth_factor) {
    const Eigen::Vector3d ray = p_C.normalized();
    const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(ray).normalized();
    Eigen::Matrix3d axes;
    axes << right, ray.cross(right), depth_factor * ray;
    return axes;
}

double label_spacing_m(const scenes::TrackerConfig& config, const scenes::StereoRig& rig, double z_m) {
    if (config.labels.preset == scenes::LabelPreset::kCustom) return config.labels.s_m;
    double steps = 0.0;  // 1 + 1/2 + ...: reach of all steps in units of r s
    for (int step = 0; step < config.labels.steps; ++step) steps += std::exp2(-step);
    const double share = config.labels.preset == scenes::LabelPreset::kPaperTable1 ? 1.0 : 0.25;
    const double reach_px = share * kTable1Reach_px * rig.left.width_px / kReferenceWidth_px;
    return reach_px * rig.m_per_px(z_m) / (config.labels.r * steps);
}

}  // namespace atropos::tracker
