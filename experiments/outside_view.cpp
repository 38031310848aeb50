#include "experiments/outside_view.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace atropos::experiments {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

const cv::Scalar kGround(45, 38, 32), kTrue(255, 160, 0), kTracked(60, 220, 60);
const cv::Scalar kArmColours[kArms] = {{208, 196, 184}, {192, 180, 168}, {160, 200, 216}};
constexpr double kCurveRadius_m = 3e-4;
const Vector3d kFromTarget_m(0.055, -0.055, -0.105);  // beside, above and behind the endoscope's view, in C

struct Stroke {
    Vector3d a, b;  // in the outside camera's frame
    double radius_m;
    cv::Scalar colour;
    double depth_m() const { return 0.5 * (a.z() + b.z()); }
};

/// Pose of C in a camera that looks at `target` from the side, image y down.
Eigen::Isometry3d outside_camera(const Vector3d& target) {
    const Vector3d z = -kFromTarget_m.normalized();
    const Vector3d x = Vector3d::UnitY().cross(z).normalized();
    Eigen::Isometry3d X_CO = Eigen::Isometry3d::Identity();
    X_CO.linear() << x, z.cross(x), z;
    X_CO.translation() = target + kFromTarget_m;
    return X_CO.inverse();
}

void add_curve(std::vector<Stroke>& strokes, const std::vector<Vector3d>& points, const cv::Scalar& colour) {
    for (size_t i = 1; i < points.size(); ++i)
        strokes.push_back({points[i - 1], points[i], kCurveRadius_m, colour});
}

/// In short pieces, each as wide as its distance makes it.
void add_capsule(std::vector<Stroke>& strokes, const Vector3d& a, const Vector3d& b, double radius_m,
                 const cv::Scalar& colour) {
    constexpr double kPiece_m = 2e-3;
    const int pieces = std::max(1, static_cast<int>((b - a).norm() / kPiece_m));
    for (int k = 0; k < pieces; ++k)
        strokes.push_back({a + (b - a) * k / pieces, a + (b - a) * (k + 1) / pieces, radius_m, colour});
}

void paint(cv::Mat& picture, const Stroke& stroke) {
    constexpr int kShift = 4;
    constexpr double kNear_m = 0.03;
    if (std::min(stroke.a.z(), stroke.b.z()) < kNear_m) return;
    const double f_px = 1.2 * picture.cols;
    const auto at = [&](const Vector3d& p) {
        const Vector2d px = f_px * p.head<2>() / p.z() + Vector2d(0.5 * picture.cols, 0.5 * picture.rows);
        const auto fixed = [](double v) {
            return static_cast<int>(std::lround(std::clamp(v, -4e3, 4e3) * (1 << kShift)));
        };
        return cv::Point(fixed(px.x()), fixed(px.y()));
    };
    const double width_px = 2.0 * stroke.radius_m * f_px / stroke.depth_m();
    cv::line(picture, at(stroke.a), at(stroke.b), stroke.colour,
             std::clamp(static_cast<int>(std::lround(width_px)), 1, 200), cv::LINE_AA, kShift);
}

}  // namespace

cv::Mat draw_outside_view(const Testbed& testbed, const std::vector<TruthSample>& samples,
                          const scenes::ThreadEstimate& estimate, cv::Size size) {
    const Eigen::Isometry3d X_OC = outside_camera(samples[samples.size() / 2].p_C);
    const Eigen::Isometry3d X_OW = X_OC * testbed.X_WC().inverse();
    std::vector<Stroke> strokes;
    for (int arm = 0; arm < kArms; ++arm)
        for (const scenes::Capsule& c : testbed.arm(arm).true_capsules_W().value)
            add_capsule(strokes, X_OW * c.a, X_OW * c.b, c.radius_m, kArmColours[arm]);
    for (size_t i = 1; i < samples.size(); ++i)
        if (samples[i].strand == samples[i - 1].strand)
            add_curve(strokes, {X_OC * samples[i - 1].p_C, X_OC * samples[i].p_C}, kTrue);
    std::stable_sort(strokes.begin(), strokes.end(),
                     [](const Stroke& a, const Stroke& b) { return a.depth_m() > b.depth_m(); });
    std::vector<Vector3d> tracked;
    for (const auto& sample : estimate.samples) tracked.push_back(X_OC * sample.p_C);
    add_curve(strokes, tracked, kTracked);

    cv::Mat picture(size, CV_8UC3, kGround);
    for (const Stroke& stroke : strokes) paint(picture, stroke);
    cv::rectangle(picture, {0, 0, size.width, size.height}, {120, 120, 120});
    return picture;
}

}  // namespace atropos::experiments
