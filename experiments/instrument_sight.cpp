#include "experiments/instrument_sight.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace atropos::experiments {
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
namespace {

constexpr double kStep_px = 3.0;       // between samples of the outline
constexpr double kBeyond_px = 2.0;     // a sample's outside must be free of other instruments
constexpr double kInformation = 0.04;  // of a sample, px^-2: neighbours err together
constexpr double kRobust_px = 1.5;
constexpr double kLeastContrast = 0.35;  // of mean probabilities inside and outside
constexpr double kLeastSupport = 0.35;
constexpr int kLeastSamples = 40;
constexpr double kForget_m = 0.15;  // way over which the shift becomes another one
constexpr double kCreep_m_s = 0.001;
constexpr double kShape_m = 0.00015;  // outline of the pieces against the instrument's
constexpr double kTurnNoise = 0.1, kTurnNoise_rad = 0.002;
constexpr double kPlayShare = 0.8;  // cables rest near the ends of their play more often than not

/// Where along a profile (px from its middle, outwards) the instrument ends; false without a clear border.
bool border(const std::vector<float>& profile, double& place) {
    const int n = static_cast<int>(profile.size());
    float sum = 0.0f, best = -1e9f;
    int end = 0;
    for (int i = 0; i < n; ++i) {
        sum += 2.0f * profile[static_cast<size_t>(i)] - 1.0f;
        if (sum > best) {
            best = sum;
            end = i;
        }
    }
    constexpr int kSide = 3;
    if (end + 1 < kSide || end + kSide >= n) return false;
    float inside = 0.0f, outside = 0.0f;
    for (int i = 0; i < kSide; ++i) {
        inside += profile[static_cast<size_t>(end - i)];
        outside += profile[static_cast<size_t>(end + 1 + i)];
    }
    if ((inside - outside) / kSide < static_cast<float>(kLeastContrast)) return false;
    const float a = profile[static_cast<size_t>(end)], b = profile[static_cast<size_t>(end) + 1];
    const float share = a > b ? std::clamp((a - 0.5f) / (a - b), 0.0f, 1.0f) : 0.5f;
    place = end + static_cast<double>(share) - 0.5 * (n - 1);
    return true;
}

float at(const cv::Mat& image, const Vector2d& px) {
    const int x = static_cast<int>(std::floor(px.x())), y = static_cast<int>(std::floor(px.y()));
    if (x < 0 || y < 0 || x + 1 >= image.cols || y + 1 >= image.rows) return -1.0f;
    const auto u = static_cast<float>(px.x() - x), v = static_cast<float>(px.y() - y);
    const float *above = image.ptr<float>(y) + x, *below = image.ptr<float>(y + 1) + x;
    return (1 - v) * ((1 - u) * above[0] + u * above[1]) + v * ((1 - u) * below[0] + u * below[1]);
}

bool read(const cv::Mat& image, const Vector2d& px, const Vector2d& normal, int reach,
          std::vector<float>& profile) {
    profile.clear();
    for (int i = -reach; i <= reach; ++i) {
        const float value = at(image, px + i * normal);
        if (value < 0.0f) return false;
        profile.push_back(value);
    }
    return true;
}

int label_at(const cv::Mat& labels, const Vector2d& px) {
    const int x = static_cast<int>(std::lround(px.x())), y = static_cast<int>(std::lround(px.y()));
    return x < 0 || y < 0 || x >= labels.cols || y >= labels.rows ? -1 : labels.at<std::uint8_t>(y, x);
}

}  // namespace

InstrumentSight::InstrumentSight(const render::InstrumentModel& model, const SightPrior& prior)
    : outline_(model), prior_(prior) {
    Parameters sigma;
    sigma << Vector3d::Constant(prior.shift_m), kPlayShare * prior.play_rad;
    P0_ = sigma.cwiseMax(1e-6).cwiseAbs2().asDiagonal();
    P_ = P0_;
}

void InstrumentSight::predict(const ArmReading& arm) {
    const robot::ArmState before = arm_.measured;
    arm_ = arm;
    const robot::ArmState& measured = arm_.measured;
    seen_ = false;
    if (!started_) {
        started_ = true;
        return;
    }
    const double way_m = (measured.X_CT.translation() - before.X_CT.translation()).norm();
    const double dt_s = std::max(0.0, measured.time_s - before.time_s);
    const double keep = std::exp(-(way_m + kCreep_m_s * dt_s) / kForget_m);
    x_.head<3>() *= keep;
    Parameters scale = Parameters::Ones(), noise = Parameters::Zero();
    scale.head<3>().setConstant(keep);
    noise.head<3>() = (1.0 - keep * keep) * P0_.diagonal().head<3>();
    // Within the play the joint stays where it is while the cable moves.
    for (int i = 0; i < 3; ++i) {
        const double turn = measured.q[3 + i] - before.q[3 + i], play = prior_.play_rad[i];
        x_[3 + i] = std::clamp(x_[3 + i] - turn, -play, play);
        noise[3 + i] =
            std::pow(kTurnNoise * turn, 2) + (play > 0.0 ? dt_s * std::pow(kTurnNoise_rad, 2) / 0.033 : 0.0);
    }
    P_ = (scale.asDiagonal() * P_ * scale.asDiagonal()).eval();
    P_.diagonal() += noise;
}

InstrumentSight::Links InstrumentSight::links_C(const Parameters& x) const {
    robot::Joints q = arm_.measured.q;
    q.tail<3>() += x.tail<3>();
    Links links = arm_.psm->link_poses(q, arm_.measured.jaw_rad);
    for (Isometry3d& link : links) {
        link = arm_.X_CB * link;
        link.translation() += x.head<3>();
    }
    return links;
}

Isometry3d InstrumentSight::X_CT(const Parameters& x) const {
    robot::Joints q = arm_.measured.q;
    q.tail<3>() += x.tail<3>();
    Isometry3d X = arm_.X_CB * arm_.psm->forward(q);
    X.translation() += x.head<3>();
    return X;
}

Isometry3d InstrumentSight::X_CT() const {
    return X_CT(x_);
}

std::vector<scenes::Capsule> InstrumentSight::capsules_C() const {
    robot::Joints q = arm_.measured.q;
    q.tail<3>() += x_.tail<3>();
    auto capsules = arm_.psm->capsules(q, arm_.measured.jaw_rad);
    for (scenes::Capsule& c : capsules)
        c = {arm_.X_CB * c.a + x_.head<3>(), arm_.X_CB * c.b + x_.head<3>(), c.radius_m};
    return capsules;
}

Matrix3d InstrumentSight::covariance(const Vector3d& p_T) const {
    constexpr double kSmall_rad = 1e-4;
    Eigen::Matrix<double, 3, 6> J;
    J.leftCols<3>().setIdentity();
    for (int i = 3; i < 6; ++i) {
        Parameters x = x_;
        x[i] += kSmall_rad;
        J.col(i) = (X_CT(x) * p_T - X_CT(x_) * p_T) / kSmall_rad;
    }
    return J * P_ * J.transpose() + kShape_m * kShape_m * Matrix3d::Identity();
}

std::optional<robot::InstrumentOffset> InstrumentSight::offset(const Vector3d& p_T) const {
    if (!seen_) return std::nullopt;
    const Vector3d p_C = X_CT() * p_T, ray = p_C.normalized();
    const Matrix3d C = covariance(p_T);
    const double depth = ray.dot(C * ray), lateral = 0.5 * (C.trace() - depth);
    return robot::InstrumentOffset{arm_.measured.time_s, p_C - arm_.measured.X_CT * p_T, std::sqrt(lateral),
                                   std::sqrt(depth)};
}

void InstrumentSight::project(const std::array<EyeView, 2>& eyes) {
    const Links links_C = this->links_C(x_);
    for (size_t side = 0; side < 2; ++side) {
        Links links = links_C;
        for (Isometry3d& link : links) link = eyes[side].X_EC * link;
        polygons_[side] = outline_.project(*eyes[side].camera, links);
    }
}

void InstrumentSight::move(const std::array<EyeView, 2>& eyes, const Parameters& x) {
    const Links links_C = this->links_C(x);
    for (size_t side = 0; side < 2; ++side) {
        Links links = links_C;
        for (Isometry3d& link : links) link = eyes[side].X_EC * link;
        InstrumentOutline::move(*eyes[side].camera, links, polygons_[side]);
    }
}

void InstrumentSight::collect(const EyeView& eye, size_t side, int number, const Parameters& x,
                              double reach_px, Covariance& H, Parameters& g) {
    constexpr double kSmall_rad = 1e-4;
    const Links links = links_C(x);
    std::array<Links, 3> turned;
    for (int i = 0; i < 3; ++i) {
        Parameters moved = x;
        moved[3 + i] += kSmall_rad;
        turned[static_cast<size_t>(i)] = links_C(moved);
    }
    own_.create(eye.labels.size(), CV_8U);
    own_.setTo(0);
    paint(polygons_[side], 1, own_);

    std::vector<float> profile;
    const int reach = static_cast<int>(std::lround(reach_px));
    for (const auto& polygon : polygons_[side]) {
        const size_t n = polygon.px.size();
        Vector2d middle = Vector2d::Zero();
        for (const Vector2d& px : polygon.px) middle += px / static_cast<double>(n);
        for (size_t k = 0; k < n; ++k) {
            const Vector2d &a = polygon.px[k], &b = polygon.px[(k + 1) % n];
            const double length = (b - a).norm();
            if (length < 0.5) continue;
            Vector2d normal = Vector2d(b.y() - a.y(), a.x() - b.x()) / length;
            if (normal.dot(a - middle) < 0.0) normal = -normal;
            const int samples = std::max(1, static_cast<int>(std::lround(length / kStep_px)));
            for (int s = 0; s < samples; ++s) {
                const double share = (s + 0.5) / samples;
                const Vector2d px = a + share * (b - a), beyond = px + kBeyond_px * normal;
                const int there = label_at(eye.labels, beyond);
                if (there < 0 || own_.at<std::uint8_t>(static_cast<int>(std::lround(beyond.y())),
                                                       static_cast<int>(std::lround(beyond.x()))) != 0)
                    continue;
                if (there != 0 && there != number + 1) continue;
                if (!read(eye.probability, px, normal, reach, profile)) continue;
                ++tried_;
                double r = 0.0;
                if (!border(profile, r)) continue;
                const Vector3d p_L = polygon.p_L[k] + share * (polygon.p_L[(k + 1) % n] - polygon.p_L[k]);
                const auto link = static_cast<size_t>(polygon.link);
                const Vector3d p_C = links[link] * p_L;
                Eigen::Matrix<double, 2, 3> px_per_m;
                eye.camera->project(eye.X_EC * p_C, px_per_m);
                const Eigen::RowVector3d by_shift = normal.transpose() * px_per_m * eye.X_EC.linear();
                Eigen::Matrix<double, 1, 6> J;
                J.head<3>() = by_shift;
                for (int i = 0; i < 3; ++i)
                    J[3 + i] = by_shift.dot((turned[static_cast<size_t>(i)][link] * p_L - p_C) / kSmall_rad);
                const double weight =
                    kInformation * (length / samples / kStep_px) / (1.0 + r * r / (kRobust_px * kRobust_px));
                H += weight * J.transpose() * J;
                g += weight * r * J.transpose();
                if (std::abs(r) < 3.0) ++fitted_;
            }
        }
    }
}

bool InstrumentSight::look(const std::array<EyeView, 2>& eyes, int number) {
    const double scale = eyes[0].camera->width_px / 640.0;
    const double z_m = std::max(0.02, X_CT().translation().z());
    const double sigma_px =
        std::sqrt(covariance(Vector3d::Zero()).diagonal().head<2>().maxCoeff()) * eyes[0].camera->fx_px / z_m;
    const Covariance prior_information = P_.inverse();
    Parameters x = x_;
    Covariance H;
    for (const double share : {1.0, 0.7, 0.5, 0.5}) {
        const double reach_px = std::clamp(share * 3.0 * sigma_px, 7.0 * scale, 24.0 * scale);
        H = prior_information;
        Parameters g = -prior_information * (x - x_);
        tried_ = fitted_ = 0;
        move(eyes, x);
        for (size_t side = 0; side < 2; ++side) collect(eyes[side], side, number, x, reach_px, H, g);
        x += H.ldlt().solve(g);
        for (int i = 0; i < 3; ++i) x[3 + i] = std::clamp(x[3 + i], -prior_.play_rad[i], prior_.play_rad[i]);
    }
    support_ = tried_ > 0 ? static_cast<double>(fitted_) / tried_ : 0.0;
    seen_ = tried_ >= kLeastSamples && support_ >= kLeastSupport && x.allFinite();
    if (seen_) {
        x_ = x;
        P_ = H.inverse();
    }
    move(eyes, x_);
    return seen_;
}

}  // namespace atropos::experiments
