#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "sim/world.hpp"
#include "tests/sim/world_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;
using testing::HeldThread;

int count(const World& world, EventKind kind) {
    return static_cast<int>(std::count_if(world.events().begin(), world.events().end(),
                                          [&](const Event& e) { return e.kind == kind; }));
}

TEST(Scissors, cut_nothing_beside_them) {
    HeldThread held;
    const Vector3d middle = held.world.thread().sample(0, 0.035);
    // Beyond the tips, behind the pin, and outside the opening.
    for (const Vector3d& offset : {Vector3d(0, 0, 0.006), Vector3d(0, 0, -0.009), Vector3d(0, 0.006, 0)}) {
        Eigen::Isometry3d X_WS = HeldThread::frame(middle + offset);
        for (int i = 0; i <= 40; ++i) {
            held.world.set_blades(2, X_WS, 0.6 * (1.0 - i / 40.0));
            held.world.step();
        }
        for (int i = 0; i <= 10; ++i)
            held.world.set_blades(2, HeldThread::frame({0, 0.1, 0.1}), 0.6), held.world.step();
    }
    EXPECT_EQ(count(held.world, EventKind::kCut), 0);
}

TEST(Scissors, report_a_collision_when_they_meet_another_instrument) {
    World world;
    for (const char* name : {"PSM1", "PSM3"}) {
        InstrumentOptions tool;
        tool.name = name;
        tool.links = {{{Vector3d(0, 0, -0.02), Vector3d(0, 0, 0), 2e-3}}};
        world.add_instrument(tool);
    }
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    world.set_link_poses(0, std::vector{X});
    for (int i = 0; i < 100; ++i) {
        X.translation().x() = 0.02 - 2e-4 * i;
        world.set_link_poses(1, std::vector{X});
        world.step();
    }
    ASSERT_EQ(count(world, EventKind::kCollision), 1);
    EXPECT_EQ(world.events()[0].other, world.events()[0].name == "PSM1" ? "PSM3" : "PSM1");
    EXPECT_NEAR(world.events()[0].time_s, 0.081, 2e-3);
}

TEST(Jaws, grasp_in_mid_thread_carry_it_and_let_it_go) {
    HeldThread held;
    InstrumentOptions third;
    third.name = "PSM4";
    third.jaws = JawGeometry{};
    const int hand = held.world.add_instrument(third);
    Eigen::Isometry3d X_WG = HeldThread::frame(held.world.thread().sample(0, 0.03));
    for (int i = 0; i <= 40; ++i) {
        held.world.set_jaws(hand, X_WG, 0.6 * (1.0 - i / 40.0));
        held.world.step();
    }
    ASSERT_TRUE(held.world.holds(hand));
    EXPECT_NEAR(held.world.held_s_m(hand), 0.03, 5e-4);
    for (int i = 0; i < 100; ++i) {
        X_WG.translation() += Vector3d(0, 0, 5e-5);
        held.world.set_jaws(hand, X_WG, 0.0);
        held.world.step();
    }
    const ThreadTruth truth = held.world.thread();
    EXPECT_LT((truth.sample(0, held.world.held_s_m(hand)) - X_WG.translation()).norm(), 6e-4);
    EXPECT_EQ(truth.span.holder0, 0);
    EXPECT_EQ(truth.span.holder1, 1);
    for (int i = 0; i <= 40; ++i) {
        held.world.set_jaws(hand, X_WG, 0.6 * i / 40.0);
        held.world.step();
    }
    EXPECT_FALSE(held.world.holds(hand));
    EXPECT_EQ(count(held.world, EventKind::kRelease), 1);
}

/// Pulls two grippers apart at 20 mm/s, 10 mm farther than the thread between them is long.
TEST(Jaws, of_two_that_pull_too_hard_one_lets_the_thread_through_and_the_other_keeps_it) {
    HeldThread held(0.05, 0.07, {}, {}, 0.004);
    double most_N = 0.0;
    for (int tick = 0; tick < 1100; ++tick) {
        held.X_WG[1].translation().x() += 2e-5;
        held.world.set_jaws(1, held.X_WG[1], 0.0);
        held.world.step();
        most_N = std::max(most_N, held.world.grip_force_N(0));
        if (count(held.world, EventKind::kSlip) == 1 && count(held.world, EventKind::kRelease) == 0) {
            EXPECT_TRUE(held.world.holds(0) && held.world.holds(1));
        }
    }
    const auto& events = held.world.events();
    const auto slip =
        std::find_if(events.begin(), events.end(), [](const Event& e) { return e.kind == EventKind::kSlip; });
    const auto release = std::find_if(events.begin(), events.end(),
                                      [](const Event& e) { return e.kind == EventKind::kRelease; });
    ASSERT_NE(slip, events.end());
    ASSERT_NE(release, events.end());
    EXPECT_EQ(count(held.world, EventKind::kRelease), 1);
    EXPECT_EQ(slip->instrument, release->instrument);
    EXPECT_NE(held.world.holds(0), held.world.holds(1));
    const double limit_N = 2.0 * held.options.material.jaw_friction * JawGeometry{}.hold_force_N;
    EXPECT_NEAR(slip->force_N, limit_N, 0.02 * limit_N);
    EXPECT_LT(most_N, 1.02 * limit_N);
    // The tail of 4 mm went through the jaws at 20 mm/s.
    EXPECT_NEAR(release->time_s - slip->time_s, 0.2, 0.03);
    std::printf("slips at %.2f N of %.2f, out after %.3f s\n", slip->force_N, limit_N,
                release->time_s - slip->time_s);
}

std::uint64_t hash_of_an_episode() {
    HeldThread held;
    const Vector3d middle = held.world.thread().sample(0, 0.0301);
    for (int i = 0; i <= 160; ++i) {
        held.X_WG[0].translation() += Vector3d(0, 2e-5, 1e-5);
        held.world.set_jaws(0, held.X_WG[0], 0.0);
        held.world.set_blades(2, HeldThread::frame(middle), 0.6 * std::max(0.0, 1.0 - i / 60.0));
        held.world.step();
    }
    return held.world.state_hash();
}

TEST(World, gives_the_same_bytes_in_two_processes_and_two_threads) {
    const std::uint64_t here = hash_of_an_episode();
    std::uint64_t a = 0, b = 0;
    std::thread first([&] { a = hash_of_an_episode(); }), second([&] { b = hash_of_an_episode(); });
    first.join();
    second.join();
    EXPECT_EQ(a, here);
    EXPECT_EQ(b, here);
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        const std::uint64_t there = hash_of_an_episode();
        _exit(write(ends[1], &there, sizeof there) == sizeof there ? 0 : 1);
    }
    std::uint64_t there = 0;
    EXPECT_EQ(read(ends[0], &there, sizeof there), static_cast<ssize_t>(sizeof there));
    waitpid(child, nullptr, 0);
    EXPECT_EQ(there, here);
}

}  // namespace
}  // namespace atropos::sim
