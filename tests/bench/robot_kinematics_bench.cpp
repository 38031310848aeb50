// Kinematics of a PSM beside Orocos KDL's, in one program and with the same compiler flags.

#include <benchmark/benchmark.h>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "robot/psm.hpp"
#include "tests/robot/kdl_chain.hpp"
#include "tests/robot/random_joints.hpp"

namespace atropos::robot {
namespace {

const Psm& psm() {
    static const Psm kPsm(tool("LARGE_NEEDLE_DRIVER"));
    return kPsm;
}

const std::vector<Joints>& joints() {
    static const std::vector<Joints> kJoints = [] {
        scenes::RandomStream random(1, "bench");
        std::vector<Joints> all;
        for (int i = 0; i < 1024; ++i) all.push_back(random_joints(psm(), random));
        return all;
    }();
    return kJoints;
}

KDL::JntArray array(const Joints& q) {
    KDL::JntArray a(6);
    a.data = q;
    return a;
}

void Forward(benchmark::State& state) {
    size_t i = 0;
    for (auto _ : state) benchmark::DoNotOptimize(psm().forward(joints()[i++ % 1024]));
}
BENCHMARK(Forward);

void ForwardKdl(benchmark::State& state) {
    const KDL::Chain chain = kdl_chain();
    KDL::ChainFkSolverPos_recursive solver(chain);
    std::vector<KDL::JntArray> q;
    for (const Joints& j : joints()) q.push_back(array(j));
    KDL::Frame frame;
    size_t i = 0;
    for (auto _ : state) benchmark::DoNotOptimize(solver.JntToCart(q[i++ % 1024], frame));
}
BENCHMARK(ForwardKdl);

void Inverse(benchmark::State& state) {
    std::vector<Eigen::Isometry3d> X_BT;
    for (const Joints& q : joints()) X_BT.push_back(psm().forward(q));
    size_t i = 0;
    for (auto _ : state) benchmark::DoNotOptimize(psm().inverse(X_BT[i++ % 1024]));
}
BENCHMARK(Inverse);

// KDL has no closed form; its Levenberg-Marquardt starts 0.1 rad (10 mm) away.
void InverseKdl(benchmark::State& state) {
    const KDL::Chain chain = kdl_chain();
    KDL::ChainFkSolverPos_recursive forward(chain);
    KDL::ChainIkSolverPos_LMA solver(chain);
    std::vector<KDL::JntArray> starts;
    std::vector<KDL::Frame> goals(1024);
    for (size_t i = 0; i < 1024; ++i) {
        forward.JntToCart(array(joints()[i]), goals[i]);
        Joints start = joints()[i] + Joints::Constant(0.1);
        start[2] -= 0.09;
        starts.push_back(array(start));
    }
    KDL::JntArray q(6);
    size_t i = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(solver.CartToJnt(starts[i % 1024], goals[i % 1024], q));
        ++i;
    }
}
BENCHMARK(InverseKdl);

void JacobianOfTip(benchmark::State& state) {
    size_t i = 0;
    for (auto _ : state) benchmark::DoNotOptimize(psm().jacobian(joints()[i++ % 1024]));
}
BENCHMARK(JacobianOfTip);

}  // namespace
}  // namespace atropos::robot

BENCHMARK_MAIN();
