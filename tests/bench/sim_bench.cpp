// CPU cost of the thread, beside its peers' cost and accuracy in the same run: Bullet's own soft rope and
// MuJoCo's chain of ball joints. One iteration is one simulated second; "error_mm" is the largest distance of
// a node at rest to the analytic catenary (70 mm over 50 mm).

#include <benchmark/benchmark.h>
#include <mujoco/mujoco.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "tests/sim/knot_curves.hpp"
#include "tests/sim/rod_support.hpp"
#include "tests/sim/surfaces.hpp"
#include "tests/sim/world_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;

constexpr double kLength = 0.07, kSpan = 0.05;

/// Point of the catenary at arc length s from its left end (0, 0, 0).
Vector3d catenary(double s) {
    double low = 1e-4, high = 1.0;
    for (int i = 0; i < 200; ++i) {
        const double a = 0.5 * (low + high);
        (2 * a * std::sinh(kSpan / (2 * a)) > kLength ? low : high) = a;
    }
    const double a = low, x = a * std::asinh((s - 0.5 * kLength) / a);
    return {0.5 * kSpan + x, 0, a * std::cosh(x / a) - a * std::cosh(0.5 * kSpan / a)};
}

ThreadOptions silk(int edges, ThreadModel model, double EI) {
    ThreadOptions options;
    options.model = model;
    options.edges = edges;
    options.length_m = kLength;
    options.material.EI_N_m2 = EI;
    options.material.GJ_N_m2 = 0.74 * EI;
    return options;
}

void hang(benchmark::State& state, const ThreadOptions& options) {
    World world;
    const Vector3d end(kSpan, 0, 0);
    world.add_thread(hanging_curve({Vector3d::Zero(), {1, 0, -1}}, {end, {1, 0, 1}}, kLength), options);
    world.anchor(0.0, Vector3d::Zero());
    world.anchor(kLength, end);
    world.settle(10.0);
    for (auto _ : state)
        for (int i = 0; i < 1000; ++i) world.step();
    const Strand strand = world.thread().strands[0];
    double worst = 0.0;
    for (size_t i = 0; i < strand.p_W.size(); ++i)
        worst = std::max(worst, (strand.p_W[i] - catenary(strand.s_m[i])).norm());
    state.counters["error_mm"] = 1e3 * worst;
}

void RodHangs(benchmark::State& state) {
    hang(state, silk(static_cast<int>(state.range(0)), ThreadModel::kRod, 0.0));
}
BENCHMARK(RodHangs)->Arg(20)->Arg(30)->Arg(70)->Arg(100)->Arg(140)->Iterations(2)->Unit(
    benchmark::kMillisecond);

void BulletSoftRopeHangs(benchmark::State& state) {
    ThreadOptions options = silk(static_cast<int>(state.range(0)), ThreadModel::kBulletSoft, 0.0);
    options.soft_iterations = static_cast<int>(state.range(1));
    hang(state, options);
}
BENCHMARK(BulletSoftRopeHangs)
    ->Args({70, 50})
    ->Args({70, 200})
    ->Args({70, 1000})
    ->Args({70, 4000})
    ->Iterations(2)
    ->Unit(benchmark::kMillisecond);

/// Tissue below and three instruments of three links around the thread, so that every query has work to do.
void scene(benchmark::State& state, bool moving) {
    testing::HeldThread held(kSpan, kLength, silk(static_cast<int>(state.range(0)), ThreadModel::kRod, 1e-8));
    held.world.add_tissue(testing::height_field(
        0.06, 60, [](double x, double y) { return -0.03 + 0.002 * std::sin(200 * x) * std::sin(200 * y); }));
    std::vector<int> arms;
    const std::vector<scenes::Capsule> link{{{0, 0, 0.002}, {0, 0, 0.02}, 3e-3}};
    for (int k = 0; k < 3; ++k) {
        InstrumentOptions arm;
        arm.name = "shaft";
        arm.links = {link, link, link};
        arms.push_back(held.world.add_instrument(arm));
    }
    int tick = 0;
    const auto pose = [&](double t) {
        for (int k = 0; k < 3; ++k) {
            std::vector<Eigen::Isometry3d> X(3, Eigen::Isometry3d::Identity());
            for (int l = 0; l < 3; ++l)
                X[static_cast<size_t>(l)].translation() =
                    Vector3d(0.025 * (k - 1), 0.012 + 0.002 * std::sin(t), 0.02 * l);
            held.world.set_link_poses(arms[static_cast<size_t>(k)], X);
        }
    };
    for (auto _ : state)
        for (int i = 0; i < 1000; ++i, ++tick) {
            const double t = 1e-3 * tick;
            pose(t);
            if (moving)
                for (int k = 0; k < 2; ++k) {
                    Eigen::Isometry3d X = held.X_WG[k];
                    X.translation() += Vector3d(0.01 * std::sin(5 * t), 0.01 * std::sin(4 * t),
                                                0.005 * (1 - std::cos(6 * t)));
                    held.world.set_jaws(k, X, 0.0);
                }
            held.world.step();
        }
}
void Hold(benchmark::State& state) {
    scene(state, false);
}
void Transport(benchmark::State& state) {
    scene(state, true);
}
BENCHMARK(Hold)->Arg(100)->Arg(140)->Iterations(2)->Unit(benchmark::kMillisecond);
BENCHMARK(Transport)->Arg(100)->Arg(140)->Arg(300)->Iterations(2)->Unit(benchmark::kMillisecond);

/// The overhand knot drawn tight to 1 N at 40 mm/s and held: seconds of CPU a simulated second in
/// "cpu_per_s".
void TightKnot(benchmark::State& state) {
    const int edges = static_cast<int>(state.range(0));
    for (auto _ : state) {
        state.PauseTiming();
        const ThreadState start = testing::with_length(
            state_along(testing::loose_overhand(kLength).resampled(edges + 1).points), kLength);
        RodParameters parameters;
        parameters.gravity_W_m_s2.setZero();
        Rod rod(start, parameters);
        Boundary ends{{{0, start.p_W.front()}, {edges, start.p_W.back()}}, {}};
        rod.parameters().drag_N_s_m2 = 2e-2;
        testing::run(rod, ends, 0.3);
        rod.parameters().drag_N_s_m2 = 1e-4;
        const Vector3d apart = 2e-5 * (start.p_W.back() - start.p_W.front()).normalized();
        state.ResumeTiming();
        int steps = 0;
        for (; steps < 2000 && rod.tension_N(1) < 1.0; ++steps) {
            ends.nodes[0].p_W -= apart;
            ends.nodes[1].p_W += apart;
            testing::run(rod, ends, 1e-3);
        }
        testing::run(rod, ends, 0.5);
        state.counters["simulated_s"] = 1e-3 * (steps + 500);
    }
}
BENCHMARK(TightKnot)->Arg(140)->Arg(200)->Arg(300)->Iterations(2)->Unit(benchmark::kMillisecond);

/// MuJoCo wants lengths in mm and masses in mg here: in SI it refuses links this light. An equality `connect`
/// takes its anchor from the pose in which the model is written, so the chain is written on the catenary, its
/// end where it is held. Its defaults let the end sink by millimetres and the chain explode within a second;
/// the stiff constraint and the damping are what holds it best.
std::string mujoco_chain(int links) {
    const double edge = 1e3 * kLength / links, mass = 6.63e-5 * 1e3 * edge,
                 r = 0.125;  // mg a link of `edge` mm
    std::ostringstream xml;
    xml.precision(15);
    xml << "<mujoco><compiler angle='radian'/><option timestep='0.001' gravity='0 0 -9810' solver='PGS' "
           "iterations='50'/><size njmax='2000' nconmax='10'/><worldbody><body name='hand' mocap='true' pos='"
        << 1e3 * kSpan << " 0 0'/>";
    double before = 0.0;
    for (int i = 0; i < links; ++i) {
        const Vector3d d = catenary(kLength * (i + 1) / links) - catenary(kLength * i / links);
        const double angle = std::atan2(-d.z(), d.x());
        xml << "<body name='b" << i << "' pos='" << (i == 0 ? 0.0 : edge) << " 0 0' euler='0 "
            << angle - before << " 0'><joint type='ball' damping='0.1'/><inertial pos='" << edge / 2
            << " 0 0' mass='" << mass << "' diaginertia='" << 0.5 * mass * r * r << " "
            << mass * edge * edge / 12 << " " << mass * edge * edge / 12 << "'/>";
        before = angle;
    }
    for (int i = 0; i < links; ++i) xml << "</body>";
    xml << "</worldbody><equality><connect body1='b" << links - 1 << "' body2='hand' anchor='" << edge
        << " 0 0' solref='0.002 1' solimp='0.99 0.999 0.001'/></equality></mujoco>";
    return xml.str();
}

void MujocoBallChainHangs(benchmark::State& state) {
    const int links = static_cast<int>(state.range(0));
    const std::string file = std::filesystem::temp_directory_path() / "atropos_mujoco_chain.xml";
    std::ofstream(file) << mujoco_chain(links);
    char error[500] = "";
    mjModel* model = mj_loadXML(file.c_str(), nullptr, error, sizeof error);
    std::remove(file.c_str());
    if (!model) return state.SkipWithError(error);
    mjData* data = mj_makeData(model);
    for (int i = 0; i < 2000; ++i) mj_step(model, data);
    for (auto _ : state)
        for (int i = 0; i < 1000; ++i) mj_step(model, data);
    double worst = 0.0;
    for (int i = 0; i < links; ++i) {
        const double* p = data->xpos + 3 * mj_name2id(model, mjOBJ_BODY, ("b" + std::to_string(i)).c_str());
        worst = std::max(worst, (1e-3 * Vector3d(p[0], p[1], p[2]) - catenary(kLength * i / links)).norm());
    }
    state.counters["error_mm"] = 1e3 * worst;
    mj_deleteData(data);
    mj_deleteModel(model);
}
BENCHMARK(MujocoBallChainHangs)->Arg(70)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace atropos::sim

BENCHMARK_MAIN();
