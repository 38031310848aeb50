// Draws the default layout during a cut: left eye, side and front views, with frames and the scissors' swept
// capsules. Usage: layout_picture FILE.png

#include <cstdio>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "robot/arm_clearance.hpp"
#include "robot/layout_defaults.hpp"
#include "tests/robot/hanging_thread.hpp"

namespace {

using namespace atropos;
using namespace atropos::robot;
using Eigen::Isometry3d;
using Eigen::Vector3d;

struct View {
    cv::Mat image;
    std::function<Vector3d(const Vector3d&)> pixel;  // x, y (px) and px per metre there; third <= 0: behind

    void dot(const Vector3d& p, double radius_m, const cv::Scalar& colour) {
        const Vector3d q = pixel(p);
        if (q.z() <= 0.0) return;
        cv::circle(image, {cvRound(q.x()), cvRound(q.y())}, std::max(1, cvRound(radius_m * q.z())), colour,
                   cv::FILLED, cv::LINE_AA);
    }
    void capsules(const Capsules& all, const cv::Scalar& colour) {
        for (const scenes::Capsule& c : all)
            for (int i = 0; i <= 400; ++i) dot(c.a + (c.b - c.a) * (i / 400.0), c.radius_m, colour);
    }
    void frame(const Isometry3d& X, double size_m) {
        const cv::Scalar colours[3] = {{0, 0, 255}, {0, 200, 0}, {255, 0, 0}};
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i <= 60; ++i)
                dot(X.translation() + size_m * i / 60.0 * X.linear().col(axis), 0.0003, colours[axis]);
    }
};

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: layout_picture FILE.png\n"), 2;
    const Layout layout = default_layout();
    const LayoutDefaults defaults;
    const scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    FrameTree tree = frame_tree(layout, rig);
    const auto X_WG = defaults.X_WG();
    const auto thread =
        hanging_thread(X_WG[0].translation(), X_WG[1].translation(), defaults.thread_length_m);
    const Vector3d p_WB3 = layout.arms[2].X_WB.translation();
    const Isometry3d X_cut = LayoutDefaults::X_WS(thread.points[50], Vector3d::UnitX(), p_WB3);

    const auto in_world = [&](size_t arm, const Joints& q, double jaw) {
        Capsules all = Psm(tool(layout.arms[arm].tool)).capsules(q, jaw);
        for (auto& c : all) c = {layout.arms[arm].X_WB * c.a, layout.arms[arm].X_WB * c.b, c.radius_m};
        return all;
    };
    std::array<Joints, 3> q;
    for (size_t i = 0; i < 2; ++i) {
        const Psm psm(tool(layout.arms[i].tool));
        q[i] = joints_for(psm, layout.arms[i].X_WB, X_WG[i], psm.tool().X_TG).q;
        set_tip(tree, layout.arms[i].name, psm.forward(q[i]));
    }
    const Psm scissors(tool(layout.arms[2].tool));
    const Joints parked =
        joints_for(scissors, layout.arms[2].X_WB, defaults.X_WS_parked(p_WB3), *scissors.tool().X_TS).q;
    q[2] = joints_for(scissors, layout.arms[2].X_WB, X_cut, *scissors.tool().X_TS).q;
    set_tip(tree, "PSM3", scissors.forward(q[2]));

    const Isometry3d X_CW = tree.pose("C", "W");
    std::vector<View> views(3);
    views[0] = {cv::Mat(360, 640, CV_8UC3, cv::Scalar::all(230)), [&](const Vector3d& p) {
                    const Vector3d p_C = X_CW * p;
                    if (p_C.z() < 0.005) return Vector3d(0, 0, -1);
                    const Eigen::Vector2d u = rig.project_left(p_C);
                    return Vector3d(u.x(), u.y(), rig.left.fx_px / p_C.z());
                }};
    views[1] = {cv::Mat(500, 500, CV_8UC3, cv::Scalar::all(230)),
                [](const Vector3d& p) { return Vector3d(250 + 1300 * p.y(), 420 - 1300 * p.z(), 1300); }};
    views[2] = {cv::Mat(500, 500, CV_8UC3, cv::Scalar::all(230)),
                [](const Vector3d& p) { return Vector3d(250 + 1300 * p.x(), 420 - 1300 * p.z(), 1300); }};
    const auto ecm = Ecm().capsule(layout.ecm_joints);
    for (size_t v = 0; v < views.size(); ++v) {
        View& view = views[v];
        if (v > 0)
            view.capsules({{layout.X_WEcm * ecm.a, layout.X_WEcm * ecm.b, ecm.radius_m}}, {120, 120, 120});
        if (v > 0)
            for (int i = 0; i <= 10; ++i)
                view.capsules(in_world(2, parked + (q[2] - parked) * (i / 10.0), 0.7), {200, 225, 200});
        view.capsules(in_world(0, q[0], 0.0), {200, 160, 110});
        view.capsules(in_world(1, q[1], 0.0), {110, 160, 200});
        view.capsules(in_world(2, q[2], 0.7), {110, 180, 110});
        for (const Vector3d& p : thread.points) view.dot(p, 0.00015, {160, 30, 110});
        for (const auto& name : tree.names())
            if (name != "C" && name != "R" && name != "ECM" && !(v == 0 && name.starts_with("ECM")))
                view.frame(tree.pose("W", name), v == 0 ? 0.005 : 0.015);
    }
    cv::Mat picture(860, 1000, CV_8UC3, cv::Scalar::all(255));
    views[0].image.copyTo(picture(cv::Rect(180, 0, 640, 360)));
    views[1].image.copyTo(picture(cv::Rect(0, 360, 500, 500)));
    views[2].image.copyTo(picture(cv::Rect(500, 360, 500, 500)));
    return cv::imwrite(argv[1], picture) ? 0 : 2;
}
