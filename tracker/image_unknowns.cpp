#include "tracker/image_unknowns.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>
#include <string>

namespace atropos::tracker {
namespace {

constexpr double kReferenceWidth_px = 640.0;

scenes::StereoRig without_distortion(scenes::StereoRig rig) {
    rig.left.distortion = rig.right.distortion = {};
    return rig;
}

Eigen::Matrix3d fundamental_matrix(const scenes::StereoRig& rig) {
    const Eigen::Vector3d t = rig.X_RC.translation();
    Eigen::Matrix3d cross;
    cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
    return rig.right.K().inverse().transpose() * cross * rig.X_RC.linear() * rig.left.K().inverse();
}

}  // namespace

ImageUnknowns::ImageUnknowns(const scenes::StereoRig& rig, const scenes::TrackerConfig& config)
    : pinhole_(without_distortion(rig)),
      eyes_(make_eyes(rig)),
      r_(config.labels.r),
      depth_factor_(config.labels.depth_factor),
      px_scale_(kReferenceWidth_px / rig.left.width_px),
      lambda_stereo_(config.lambda_stereo),
      fundamental_(fundamental_matrix(pinhole_)) {
    const CurveSampling sampling(config.curve.degree, config.curve.control_points, config.curve.samples);
    for (int k = 0; k < sampling.control_points(); ++k) {
        share_.push_back(0.0);
        for (int j = 0; j < sampling.samples(); ++j) share_.back() += sampling.du() * sampling.R(k, j);
    }
    for (std::size_t axis = 0; axis < 4; ++axis) {
        directions_.push_back({});
        directions_.back()[axis] = 1.0;
    }
    for (int signs = 0; signs < 8; ++signs)
        directions_.push_back({1.0, signs & 1 ? -1.0 : 1.0, signs & 2 ? -1.0 : 1.0, signs & 4 ? -1.0 : 1.0});
}

void ImageUnknowns::begin(std::span<const Eigen::Vector3d> control_points) {
    for (std::size_t eye = 0; eye < 2; ++eye) {
        points_[eye].clear();
        for (const Eigen::Vector3d& Q : control_points) points_[eye].push_back(eyes_[eye].homogeneous(Q));
    }
}

void ImageUnknowns::fix_ends(const std::array<std::optional<MeasuredTip>, 2>& tips) {
    for (std::size_t end = 0; end < 2; ++end)
        if (tips[end] && tips[end]->kind == MeasuredTip::Kind::kFixed)
            for (std::size_t eye = 0; eye < 2; ++eye)
                (end == 0 ? points_[eye].front() : points_[eye].back()) =
                    eyes_[eye].homogeneous(tips[end]->p_C);
}

/// Pixel, without distortion, of what the eye calls a point: that pixel, or normalised coordinates.
Eigen::Vector2d ImageUnknowns::pixel(int eye, const Eigen::Vector2d& point) const {
    if (!eyes_[0].is_distorted()) return point;
    const scenes::Camera& camera = eye == 0 ? pinhole_.left : pinhole_.right;
    return {camera.fx_px * point.x() + camera.cx_px, camera.fy_px * point.y() + camera.cy_px};
}

double ImageUnknowns::epipolar_distance_px(const Pair& pixels) const {
    const Eigen::Vector3d line = fundamental_ * pixels[0].homogeneous();
    return line.dot(pixels[1].homogeneous()) / std::max(line.head<2>().norm(), 1e-300);
}

double ImageUnknowns::stereo_cost(int k, const Pair& pixels) const {
    const double off_px = px_scale_ * epipolar_distance_px(pixels);
    return lambda_stereo_ * share_[static_cast<std::size_t>(k)] * off_px * off_px;
}

void ImageUnknowns::place_labels(std::span<const Eigen::Vector3d> control_points, double s_m,
                                 NodeLabels& labels) const {
    for (std::size_t k = 0; k < control_points.size(); ++k) {
        const int node = static_cast<int>(k);
        const Eigen::Vector3d& Q = control_points[k];
        const double z_m = std::max(Q.z(), Eye::kNearest);
        const double common_px = s_m / pinhole_.m_per_px(z_m);
        const double apart_px = depth_factor_ * s_m / pinhole_.m_per_disparity_px(z_m);
        const double unit = eyes_[0].is_distorted() ? 1.0 / pinhole_.left.fx_px : 1.0;
        const auto place = [&](int label, const std::array<double, 4>& d) {
            Pair moved, pixels;
            for (std::size_t eye = 0; eye < 2; ++eye) {
                const double apart = eye == 0 ? 0.5 * apart_px : -0.5 * apart_px;
                moved[eye] =
                    points_[eye][k].hnormalized() +
                    unit * Eigen::Vector2d(common_px * d[0] + apart * d[2], common_px * d[1] + apart * d[3]);
                pixels[eye] = pixel(static_cast<int>(eye), moved[eye]);
            }
            const std::optional<Eigen::Vector3d> met = pinhole_.unproject(pixels[0], pixels[1]);
            const double near_m = Eye::kNearest;
            if (!met || met->z() < near_m || (pinhole_.X_RC * *met).z() < near_m) {
                labels.set(node, label, Eigen::Vector3d::Zero(),
                           {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}, ChainProblem::kForbidden);
                return;
            }
            std::array<Eigen::Vector3d, 2> seen;
            for (std::size_t eye = 0; eye < 2; ++eye)  // weights from the new depth (eq. 3)
                seen[eye] = eyes_[eye].homogeneous(*met).z() * moved[eye].homogeneous() - points_[eye][k];
            labels.set(node, label, *met - Q, seen, static_cast<float>(stereo_cost(node, pixels)));
        };
        place(0, {});
        int label = 1;
        for (const std::array<double, 4>& d : directions_)
            for (int i = 1; i <= r_; ++i)
                for (const double sign : {1.0, -1.0})
                    place(label++, {sign * i * d[0], sign * i * d[1], sign * i * d[2], sign * i * d[3]});
    }
}

void ImageUnknowns::move(const NodeLabels& labels, std::span<const int> labelling) {
    for (std::size_t k = 0; k < labelling.size(); ++k)
        for (std::size_t eye = 0; eye < 2; ++eye)
            points_[eye][k] += labels.seen(static_cast<int>(k), labelling[k], eye);
}

double ImageUnknowns::stereo_energy() const {
    double sum = 0.0;
    for (std::size_t k = 0; k < points_[0].size(); ++k)
        sum += stereo_cost(static_cast<int>(k),
                           {pixel(0, points_[0][k].hnormalized()), pixel(1, points_[1][k].hnormalized())});
    return sum;
}

std::vector<double> ImageUnknowns::state() const {
    std::vector<double> numbers;
    for (const std::vector<Eigen::Vector3d>& points : points_)
        for (const Eigen::Vector3d& h : points) numbers.insert(numbers.end(), {h.x(), h.y(), h.z()});
    return numbers;
}

void ImageUnknowns::restore(std::span<const double> state) {
    const std::size_t K = share_.size();
    if (state.size() != 6 * K)
        throw std::invalid_argument("a state of " + std::to_string(state.size()) +
                                    " numbers, expected six a control point");
    for (std::size_t eye = 0; eye < 2; ++eye) {
        points_[eye].resize(K);
        for (std::size_t k = 0; k < K; ++k)
            points_[eye][k] = Eigen::Vector3d::Map(state.data() + 3 * (eye * K + k));
    }
}

}  // namespace atropos::tracker
