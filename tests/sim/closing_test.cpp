// Blades and jaws that close at working speed on a thread that swings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/random_stream.hpp"
#include "tests/sim/world_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;
using testing::HeldThread;

constexpr double kPi = std::numbers::pi;
constexpr double kTipSpeed_m_s = 0.25;  // of each jaw

struct Swing {
    double amplitude_m, omega_rad_s, phase_rad;
    Vector3d direction;

    explicit Swing(scenes::RandomStream& random)
        : amplitude_m(random.uniform(0.0, 2e-3)),
          omega_rad_s(2.0 * kPi * random.uniform(1.0, 4.0)),
          phase_rad(random.uniform(0.0, 2.0 * kPi)) {
        const double about_x = random.uniform(0.0, 2.0 * kPi);
        direction = {random.uniform(-0.3, 0.3), std::cos(about_x), std::sin(about_x)};
        direction.normalize();
    }
    Vector3d offset_m(int tick) const {
        return amplitude_m * (std::sin(1e-3 * omega_rad_s * tick + phase_rad) - std::sin(phase_rad)) *
               direction;
    }
};

/// Across the thread at `s_m`: y along it, turned by up to 0.5 rad about z, up to 1 mm off in x, 2 mm in z.
Eigen::Isometry3d somewhere_across(const ThreadTruth& truth, double s_m, scenes::RandomStream& random) {
    const Vector3d y = (truth.sample(0, s_m + 1e-4) - truth.sample(0, s_m - 1e-4)).normalized();
    const Vector3d x = y.unitOrthogonal();
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() << x, y, x.cross(y);
    X.linear() = X.linear() * Eigen::AngleAxisd(random.uniform(0.0, 2.0 * kPi), Vector3d::UnitY()) *
                 Eigen::AngleAxisd(random.uniform(-0.5, 0.5), Vector3d::UnitZ());
    X.translation() = truth.sample(0, s_m) +
                      X.linear() * Vector3d(random.uniform(-1e-3, 1e-3), 0.0, random.uniform(-2e-3, 2e-3));
    return X;
}

const scenes::Polyline& settled() {
    static const scenes::Polyline kCurve{HeldThread().world.thread().strands[0].p_W};
    return kCurve;
}

/// Closes blades (jaws of a third gripper if `grasp`) once. Returns what they did to the thread.
std::vector<Event> close_once(std::uint64_t seed, bool grasp, Eigen::Isometry3d& X_WF) {
    scenes::RandomStream random(seed, "closing");
    HeldThread held(0.05, 0.07, {}, {}, -1.0, &settled());
    InstrumentOptions third;
    third.name = "PSM4";
    third.jaws = JawGeometry{};
    const int hand = held.world.add_instrument(third), scissors = 2;
    const Swing swing(random);
    int tick = 0;
    const auto step = [&] {
        for (int k = 0; k < 2; ++k) {
            Eigen::Isometry3d X_WG = held.X_WG[k];
            X_WG.translation() += swing.offset_m(tick);
            held.world.set_jaws(k, X_WG, 0.0);
        }
        held.world.step();
        ++tick;
    };
    while (tick < 60) step();
    X_WF = somewhere_across(held.world.thread(), random.uniform(0.012, 0.058), random);
    const double rate_rad_s = 2.0 * kTipSpeed_m_s / BladeGeometry{}.length_m;
    for (double opening = random.uniform(0.5, 0.9); opening > -0.5; opening -= 1e-3 * rate_rad_s) {
        if (grasp)
            held.world.set_jaws(hand, X_WF, std::max(0.0, opening));
        else
            held.world.set_blades(scissors, X_WF, std::max(0.0, opening));
        step();
    }
    std::vector<Event> done;
    for (const Event& e : held.world.events())
        if (e.instrument == (grasp ? hand : scissors) || e.kind == EventKind::kRelease) done.push_back(e);
    return done;
}

TEST(Scissors, cut_a_swinging_thread_once_at_working_speed) {
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        Eigen::Isometry3d X_WS;
        const std::vector<Event> done = close_once(seed, false, X_WS);
        ASSERT_EQ(done.size(), 1u) << "seed " << seed;
        EXPECT_EQ(done[0].kind, EventKind::kCut);
        EXPECT_LT(std::abs((X_WS.inverse() * done[0].p_W).y()), 5e-5) << "seed " << seed;
    }
}

TEST(Jaws, grasp_a_swinging_thread_once_at_working_speed) {
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        Eigen::Isometry3d X_WG;
        const std::vector<Event> done = close_once(seed, true, X_WG);
        ASSERT_EQ(done.size(), 1u) << "seed " << seed;
        EXPECT_EQ(done[0].kind, EventKind::kGrasp);
        EXPECT_LT(std::abs((X_WG.inverse() * done[0].p_W).x()), 4e-4) << "seed " << seed;
    }
}

}  // namespace
}  // namespace atropos::sim
