#include "render/visibility.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/instrument.hpp"
#include "render/tissue.hpp"
#include "render_scenes.hpp"
#include "scenes/capsule.hpp"
#include "scenes/random_stream.hpp"

namespace atropos::render {
namespace {

// First front face on the way from the eye to p, over every triangle of every item.
double first_hit(const FrameInput& input, const Eigen::Vector3d& eye, const Eigen::Vector3d& p) {
    double nearest = 1.0;
    for (const scenes::RenderItem& item : input.items) {
        for (const auto& t : item.mesh->triangles) {
            Eigen::Matrix3d M;  // p0 + u e1 + v e2 - t d = eye
            const Eigen::Vector3d a = item.X_WM * item.mesh->vertices[t[0]].cast<double>();
            const Eigen::Vector3d b = item.X_WM * item.mesh->vertices[t[1]].cast<double>();
            const Eigen::Vector3d c = item.X_WM * item.mesh->vertices[t[2]].cast<double>();
            if ((b - a).cross(c - a).dot(p - eye) >= 0.0) continue;
            M << b - a, c - a, eye - p;
            const Eigen::Vector3d uvt = M.inverse() * (eye - a);
            if (uvt.x() >= 0.0 && uvt.y() >= 0.0 && uvt.x() + uvt.y() <= 1.0 && uvt.z() > 0.0) {
                nearest = std::min(nearest, uvt.z());
            }
        }
    }
    return nearest;
}

TEST(Visibility, agrees_with_casting_every_ray_at_every_triangle) {
    const scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    TissueOptions options;
    options.size_x_m = options.size_y_m = 0.06;
    options.cell_m = 0.002;
    options.texture_px = 16;
    options.relief_m = 0.008;
    const Tissue tissue = make_tissue(options, 3);
    std::vector<scenes::RenderItem> items = {tissue.item()};
    const InstrumentModel tool = load_instrument(ATROPOS_MESHES "/needle_driver");
    Eigen::Isometry3d X_WL = Eigen::Isometry3d::Identity();
    X_WL.rotate(Eigen::AngleAxisd(2.6, Eigen::Vector3d(1.0, 0.3, 0.1).normalized()));
    X_WL.translation() = Eigen::Vector3d(0.0, 0.005, 0.012);
    for (int link = 0; link < 4; ++link) tool.append(link, X_WL, scenes::Label::kPSM1, items);

    ThreadRibbon ribbon;
    for (int i = 0; i <= 1000; ++i) {
        const double t = i / 1000.0, a = 6.0 * M_PI * t;
        ribbon.curve_W.points.emplace_back(0.012 * std::cos(a) + 0.01 * t, 0.012 * std::sin(a),
                                           0.004 + 0.006 * t);
    }
    const std::vector<double> arc_m = ribbon.curve_W.arc_lengths_m();
    std::vector<SamplePoint> samples;
    for (std::size_t i = 0; i <= 1000; ++i) samples.push_back({ribbon.curve_W.points[i], 0, arc_m[i]});
    const std::vector<ThreadRibbon> ribbons = {ribbon};

    FrameInput input;
    input.X_WC.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    input.X_WC.translation() = Eigen::Vector3d(0.0, 0.0, 0.1);
    input.items = items;
    input.ribbons = ribbons;
    input.samples = samples;
    VisibilityTest visibility;
    int wrong = 0, hidden = 0, crossed = 0, count = 0;
    for (const Eye& eye : {Eye{rig.left, Eigen::Isometry3d::Identity(), 0}, Eye{rig.right, rig.X_RC, 1}}) {
        const std::vector<SampleView> views = visibility.views(input, eye);
        const Eigen::Isometry3d X_WE = input.X_WC * eye.X_EC.inverse();
        const Eigen::Vector3d p_eye = X_WE.translation();
        for (std::size_t i = 0; i < samples.size(); ++i) {
            const Eigen::Vector3d p = samples[i].p_W;
            const double before = 1.0 - ribbon.radius_m / (p - p_eye).norm();
            bool by_thread = false;
            for (std::size_t k = 0; k + 1 < arc_m.size(); ++k) {
                const double own_m = 6.0 * ribbon.radius_m;
                if (arc_m[k + 1] > arc_m[i] - own_m && arc_m[k] < arc_m[i] + own_m) continue;
                by_thread |=
                    scenes::segment_distance(p_eye, p, ribbon.curve_W.points[k], ribbon.curve_W.points[k + 1])
                        .distance_m < ribbon.radius_m;
            }
            const bool by_scene = first_hit(input, p_eye, p) < before;
            EXPECT_LT((views[i].pixel - eye.camera.project(X_WE.inverse() * p)).norm(), 1e-9);
            const bool expected = !by_scene && !by_thread;
            wrong += expected != (views[i].visibility == Visibility::kVisible);
            hidden += by_scene;
            crossed += by_thread;
            ++count;
        }
    }
    std::printf("visibility: %d of %d differ, %d behind the scene, %d behind the thread\n", wrong, count,
                hidden, crossed);
    EXPECT_GE(count, 2000);
    EXPECT_GT(hidden, 50);
    EXPECT_GT(crossed, 2);
    EXPECT_LE(wrong, count / 500);
}

TEST(RayCaster, finds_the_depth_that_the_picture_shows) {
    const scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    StereoEndoscope endoscope(endoscope_preset("fast"), rig);
    const auto ball = sphere(0.02, 60);
    const std::vector<scenes::RenderItem> items = {item_at(ball, {0.0, 0.0, 0.1}, scenes::Label::kOther)};
    FrameInput input;
    input.items = items;
    const StereoFrame frame = endoscope.render(input);
    const RayCaster caster(*ball);
    int compared = 0;
    double worst_m = 0.0;
    for (int y = 0; y < rig.left.height_px; y += 5) {
        for (int x = 0; x < rig.left.width_px; x += 5) {
            const Eigen::Vector3d ray = rig.left.normalised(Eigen::Vector2d(x, y)).homogeneous();
            const auto hit = caster.cast(Eigen::Vector3d(0.0, 0.0, -0.1), ray, 1.0);
            const float depth = frame.left.depth_m.at<float>(y, x);
            if (!hit || depth == 0.0f) continue;  // an edge may fall either way
            if (*hit > 0.095)
                continue;  // grazing: a 1/256 px snap of vertices is worth more than a micrometre
            worst_m = std::max(worst_m, std::abs(*hit - depth));
            ++compared;
        }
    }
    std::printf("depth against rays: %.2e mm over %d\n", 1e3 * worst_m, compared);
    EXPECT_GT(compared, 500);
    EXPECT_LE(worst_m, 1e-6);
}

}  // namespace
}  // namespace atropos::render
