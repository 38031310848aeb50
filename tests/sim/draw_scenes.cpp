// Draws a small picture of each class of scene, seen from the side (left, x-z) and from above (right, x-y),
// so that a person can look at what the numbers say. Usage: sim_draw_scenes FOLDER

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "sim/world.hpp"
#include "tests/sim/knot_curves.hpp"
#include "tests/sim/rod_support.hpp"
#include "tests/sim/surfaces.hpp"
#include "tests/sim/world_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;

constexpr int kSize = 420;

struct View {
    cv::Mat image = cv::Mat(kSize, 2 * kSize, CV_8UC3, cv::Scalar(255, 255, 255));
    Vector3d centre;
    double px_per_m;

    cv::Point at(const Vector3d& p, bool above) const {
        const Vector3d d = (p - centre) * px_per_m;
        return {static_cast<int>(std::lround(d.x() * 16)) + 8 * kSize + (above ? 16 * kSize : 0),
                static_cast<int>(std::lround(-(above ? d.y() : d.z()) * 16)) + 8 * kSize};
    }
    void line(const Vector3d& a, const Vector3d& b, const cv::Scalar& colour, int width = 1) {
        for (const bool above : {false, true})
            cv::line(image, at(a, above), at(b, above), colour, width, cv::LINE_AA, 4);
    }
    void thread(const ThreadTruth& truth) {
        const cv::Scalar colours[] = {{120, 30, 90}, {30, 110, 200}, {40, 140, 60}};
        for (size_t k = 0; k < truth.strands.size(); ++k) {
            const auto& s = truth.strands[k].s_m;
            const int n = 600;
            for (int i = 0; i < n; ++i) {
                const double a = s.front() + (s.back() - s.front()) * i / n,
                             b = s.front() + (s.back() - s.front()) * (i + 1) / n;
                line(truth.sample(static_cast<int>(k), a), truth.sample(static_cast<int>(k), b),
                     colours[k % 3], 2);
            }
        }
    }
    void frame(const Eigen::Isometry3d& X) {
        const Vector3d o = X.translation();
        line(o, o - 0.008 * X.linear().col(2), {160, 160, 160}, 3);
        line(o, o + 0.003 * X.linear().col(1), {0, 160, 0}, 1);
    }
};

void hold(const std::string& folder) {
    testing::HeldThread held;
    View view{.centre = {0, 0, -0.01}, .px_per_m = 6000};
    view.thread(held.world.thread());
    for (const auto& X : held.X_WG) view.frame(X);
    cv::imwrite(folder + "/hold.png", view.image);

    const int hand =
        held.world.add_instrument({.name = "PSM3", .links = {}, .jaws = JawGeometry{}, .blades = {}});
    Eigen::Isometry3d X_WG = testing::HeldThread::frame(held.world.thread().sample(0, 0.03));
    for (int i = 0; i <= 40; ++i) {
        held.world.set_jaws(hand, X_WG, 0.6 * (1.0 - i / 40.0));
        held.world.step();
    }
    for (int i = 0; i < 300; ++i) {
        X_WG.translation() += Vector3d(0, 3e-5, 5e-5);
        held.world.set_jaws(hand, X_WG, 0.0);
        held.world.step();
    }
    View mid{.centre = {0, 0, -0.005}, .px_per_m = 6000};
    mid.thread(held.world.thread());
    for (const auto& X : {held.X_WG[0], held.X_WG[1], X_WG}) mid.frame(X);
    cv::imwrite(folder + "/mid_grasp.png", mid.image);
}

void cut(const std::string& folder) {
    testing::HeldThread held;
    const Eigen::Isometry3d X_WS = testing::HeldThread::frame(held.world.thread().sample(0, 0.035));
    for (int i = 0; i <= 400; ++i) {
        held.world.set_blades(2, X_WS, 0.6 * std::max(0.0, 1.0 - i / 60.0));
        held.world.step();
    }
    View view{.centre = {0, 0, -0.01}, .px_per_m = 6000};
    view.thread(held.world.thread());
    for (const auto& X : {held.X_WG[0], held.X_WG[1], X_WS}) view.frame(X);
    cv::imwrite(folder + "/cut.png", view.image);
}

void drape(const std::string& folder) {
    World world;
    const auto height = [](double x, double y) {
        return 0.004 * std::cos(180 * x) * std::cos(120 * y) + 4 * (x * x + y * y) - 0.01;
    };
    const scenes::TriangleMesh mesh = testing::height_field(0.045, 60, height);
    world.add_tissue(mesh);
    scenes::Polyline wave;
    for (int i = 0; i <= 200; ++i)
        wave.points.push_back({-0.03 + 0.0003 * i, 0.006 * std::sin(0.08 * i), 0.008});
    world.add_thread(wave);
    for (int i = 0; i < 800; ++i) world.step();
    View view{.centre = {0, 0, 0}, .px_per_m = 5000};
    for (double y = -0.04; y <= 0.04; y += 0.004)
        for (double x = -0.04; x < 0.04; x += 0.001)
            view.line({x, y, height(x, y)}, {x + 0.001, y, height(x + 0.001, y)}, {170, 190, 240});
    view.thread(world.thread());
    cv::imwrite(folder + "/drape.png", view.image);
}

void knot(const std::string& folder) {
    const auto curve = testing::loose_overhand(0.07).resampled(141);
    RodParameters parameters;
    parameters.gravity_W_m_s2.setZero();
    Rod rod(testing::with_length(state_along(curve.points), 0.07), parameters);
    Boundary ends{{{0, curve.points.front()}, {140, curve.points.back()}}, {}};
    rod.parameters().drag_N_s_m2 = 2e-2;
    testing::run(rod, ends, 0.3);
    rod.parameters().drag_N_s_m2 = 1e-4;
    const Vector3d apart = 2e-5 * (curve.points.back() - curve.points.front()).normalized();
    while (rod.tension_N(1) < 1.0) {
        ends.nodes[0].p_W -= apart;
        ends.nodes[1].p_W += apart;
        testing::run(rod, ends, 1e-3);
    }
    ThreadTruth truth;
    truth.strands.resize(1);
    truth.strands[0].p_W = rod.state().p_W;
    truth.strands[0].s_m = rod.state().s_m;
    View view{.centre = truth.sample(0, 0.035), .px_per_m = 70000};
    view.thread(truth);
    cv::imwrite(folder + "/knot.png", view.image);
}

}  // namespace
}  // namespace atropos::sim

int main(int argc, char** argv) {
    const std::string folder = argc > 1 ? argv[1] : ".";
    atropos::sim::hold(folder);
    atropos::sim::cut(folder);
    atropos::sim::drape(folder);
    atropos::sim::knot(folder);
}
