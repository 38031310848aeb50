#include "robot/scissors_command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "tests/robot/scissors_world.hpp"

namespace atropos::robot {
namespace {

using scenes::ArmAccuracy;
using scenes::ThreadEstimate;
using scenes::TrackStatus;
using testing::HasSubstr;

struct Figures {
    int severed = 0, aborted = 0, missed = 0, outside = 0, gate_shut = 0;
    std::vector<double> errors_m;
    double clearance_m = 1.0;
    double mean_m() const {
        return std::accumulate(errors_m.begin(), errors_m.end(), 0.0) / static_cast<double>(errors_m.size());
    }
    double p95_m() const { return errors_m[errors_m.size() * 95 / 100]; }
};

Figures run_seeds(const char* name, const ScissorsWorldOptions& options, int seeds) {
    Figures f;
    double target = 0.0, blade = 0.0, depth = 0.0, predicted = 0.0;
    for (int seed = 0; seed < seeds; ++seed) {
        const ScissorsOutcome o = ScissorsWorld(options, static_cast<std::uint64_t>(seed)).run();
        f.severed += o.severed;
        f.missed += o.closed && !o.severed;
        f.aborted += o.status.aborted;
        f.gate_shut += o.gate_was_shut;
        f.clearance_m = std::min(f.clearance_m, o.least_clearance_m);
        if (o.status.aborted) std::printf("  seed %d: %s\n", seed, o.status.reason.c_str());
        EXPECT_TRUE(o.status.finished) << "seed " << seed << " ended in " << to_string(o.status.state);
        EXPECT_EQ(o.status.succeeded, o.severed) << seed;
        if (!o.severed) continue;
        f.errors_m.push_back(o.error_m);
        f.outside += o.error_m > options.scissors.tolerance_m;
        target += std::pow(o.target_error_m, 2);
        blade += std::pow(o.blade_error_m, 2);
        depth += std::pow(o.depth_error_m, 2);
        predicted += o.predicted_miss_m;
    }
    std::sort(f.errors_m.begin(), f.errors_m.end());
    const double n = std::max<double>(1.0, static_cast<double>(f.errors_m.size()));
    if (f.errors_m.empty()) f.errors_m.push_back(1.0);
    std::printf(
        "%s: %d severed, %d missed, %d aborted of %d; error mean %.2f p95 %.2f max %.2f mm (target %.2f, "
        "blade %.2f, depth %.2f RMS; predicted %.2f); clear %.1f mm\n",
        name, f.severed, f.missed, f.aborted, seeds, 1e3 * f.mean_m(), 1e3 * f.p95_m(),
        1e3 * f.errors_m.back(), 1e3 * std::sqrt(target / n), 1e3 * std::sqrt(blade / n),
        1e3 * std::sqrt(depth / n), 1e3 * predicted / n, 1e3 * f.clearance_m);
    return f;
}

TEST(ScissorsCommand, calibrated_arms_cut_the_moving_thread_at_its_middle) {
    const Figures f = run_seeds("calibrated", {}, 20);
    EXPECT_EQ(f.severed, 20);
    EXPECT_EQ(f.missed, 0);
    EXPECT_EQ(f.outside, 0);
    EXPECT_EQ(f.gate_shut, 0);
    EXPECT_LE(f.mean_m(), 0.0010);
    EXPECT_LE(f.p95_m(), 0.0020);
    EXPECT_GE(f.clearance_m, 0.005);
}

TEST(ScissorsCommand, perfect_arms_cut_nearer) {
    ScissorsWorldOptions options;
    options.accuracy = ArmAccuracy::kPerfect;
    options.offsets = false;
    const Figures f = run_seeds("perfect", options, 10);
    EXPECT_EQ(f.severed, 10);
    EXPECT_EQ(f.outside, 0);
    EXPECT_LE(f.mean_m(), 0.0005);
    EXPECT_LE(f.p95_m(), 0.0010);
    EXPECT_GE(f.clearance_m, 0.005);
}

TEST(ScissorsCommand, cuts_where_it_is_told_along_the_span) {
    ScissorsWorldOptions options;
    options.scissors.place.fraction = 0.35;
    EXPECT_EQ(run_seeds("fraction 0.35", options, 3).severed, 3);
    options.scissors.place.from_end1_m = 0.030;
    EXPECT_EQ(run_seeds("30 mm from end 1", options, 3).severed, 3);
}

TEST(ScissorsCommand, uncalibrated_arms_without_help_from_images_never_close) {
    ScissorsWorldOptions options;
    options.accuracy = ArmAccuracy::kUncalibrated;
    options.offsets = false;
    options.duration_s = 30.0;
    options.scissors.timeout_s = 6.0;
    const ScissorsOutcome o = ScissorsWorld(options, 1).run();
    EXPECT_FALSE(o.closed);
    EXPECT_TRUE(o.status.aborted);
    EXPECT_THAT(o.status.reason, HasSubstr("time-out"));
    EXPECT_THAT(o.status.reason, HasSubstr("predicted miss exceeds the tolerance"));
}

// ---- Faults --------------------------------------------------------------------------------------------

ScissorsOutcome run_fault(ScissorsWorldOptions options, std::uint64_t seed) {
    const ScissorsOutcome o = ScissorsWorld(options, seed).run();
    EXPECT_TRUE(o.status.finished) << to_string(o.status.state);
    std::printf("  seed %d %s at %.2f: %s\n", static_cast<int>(seed), o.closed ? "closed" : "did not close",
                o.cut_s, o.status.reason.c_str());
    return o;
}

constexpr double kFault_s = 2.9;  // the blades are near the thread
constexpr std::uint64_t kSeeds = 20;

TEST(ScissorsCommand, half_a_second_without_frames_delays_the_cut) {
    ScissorsWorldOptions options;
    options.frame_dropped = [](double t) { return t > kFault_s && t < kFault_s + 0.5; };
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_TRUE(o.severed);
        EXPECT_LE(o.error_m, 0.002);
    }
}

TEST(ScissorsCommand, blades_turn_back_before_they_reach_the_thread_when_the_gate_shuts) {
    double shut_s = -1.0, nearest_m = 1.0;
    int attempts_when_back = -1;
    ScissorsWorldOptions options;
    options.tamper = [&](ThreadEstimate& e, double t) {
        if (shut_s >= 0.0 && t < shut_s + 0.5) e.status = TrackStatus::kLost;
    };
    options.watch = [&](const ScissorsWorld& w) {
        const ScissorsStatus& s = w.status();
        if (s.state != ScissorsState::kFollow) return;
        if (shut_s < 0.0 && s.advance_m < 0.012) shut_s = w.time_s();
        if (shut_s < 0.0 || w.time_s() > shut_s + 0.5) return;
        nearest_m = std::min(nearest_m, s.advance_m);
        attempts_when_back = s.attempts;
    };
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        shut_s = -1.0;
        nearest_m = 1.0;
        const ScissorsOutcome o = ScissorsWorld(options, seed).run();
        EXPECT_GT(nearest_m, 0.005) << "seed " << seed;
        EXPECT_EQ(attempts_when_back, 0) << "seed " << seed;
        EXPECT_TRUE(o.severed) << o.status.reason;
        EXPECT_EQ(o.status.attempts, 1);
    }
}

TEST(ScissorsCommand, a_lost_tracker_is_named) {
    ScissorsWorldOptions options;
    options.tamper = [](ThreadEstimate& e, double t) {
        if (t < kFault_s) return;
        e.status = TrackStatus::kLost;
        e.samples.clear();
    };
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_FALSE(o.closed);
        EXPECT_THAT(o.status.reason, HasSubstr("tracker lost"));
    }
}

TEST(ScissorsCommand, a_tracker_that_falls_silent_is_named) {
    ScissorsWorldOptions options;
    options.frame_dropped = [](double t) { return t > kFault_s; };
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_FALSE(o.closed);
        EXPECT_THAT(o.status.reason, HasSubstr("no estimate"));
    }
}

TEST(ScissorsCommand, an_estimate_that_jumps_is_not_followed) {
    ScissorsWorldOptions options;
    options.tamper = [](ThreadEstimate& e, double t) {
        if (t < kFault_s) return;
        const double last = static_cast<double>(e.samples.size() - 1);
        for (size_t i = 0; i < e.samples.size(); ++i) {  // the ends stay at the grips
            const double u = static_cast<double>(i) / last;
            e.samples[i].p_C += 4.0 * u * (1.0 - u) * Eigen::Vector3d(0.0, 0.003, 0.007);
        }
    };
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_FALSE(o.closed);
        EXPECT_THAT(o.status.reason, HasSubstr("jumped by"));
    }
}

TEST(ScissorsCommand, another_thread_is_not_cut) {
    ScissorsWorldOptions options;
    options.tamper = [](ThreadEstimate& e, double) {
        for (auto& sample : e.samples) sample.p_C += Eigen::Vector3d(0.0, 0.02, 0.0);
    };
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_FALSE(o.closed);
        EXPECT_THAT(o.status.reason, HasSubstr("from the jaws that hold it"));
    }
}

TEST(ScissorsCommand, a_stalled_arm_stops_and_says_so) {
    ScissorsWorldOptions options;
    options.stall_s = 1.8;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_FALSE(o.closed);
        EXPECT_THAT(o.status.reason, HasSubstr("arm stalled"));
    }
}

TEST(ScissorsCommand, a_thread_already_cut_is_left_alone) {
    ScissorsWorldOptions options;
    options.already_cut_s = kFault_s;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_FALSE(o.closed);
        EXPECT_THAT(o.status.reason, HasSubstr("already cut"));
    }
}

TEST(ScissorsCommand, a_span_that_grows_is_a_thread_that_slips) {
    ScissorsWorldOptions options;
    options.slip_m_s = 0.006;
    options.scissors.max_length_change = 0.04;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        const ScissorsOutcome o = run_fault(options, seed);
        EXPECT_TRUE(o.severed || o.status.reason.find("mm long") != std::string::npos) << o.status.reason;
        EXPECT_TRUE(!o.severed || o.error_m <= 0.002) << o.error_m;
    }
}

TEST(ScissorsCommand, blunt_blades_are_found_out) {
    ScissorsWorldOptions options;
    options.blunt = true;
    options.duration_s = 40.0;
    const ScissorsOutcome o = run_fault(options, 1);
    EXPECT_TRUE(o.closed);
    EXPECT_FALSE(o.status.succeeded);
    EXPECT_EQ(o.status.verified, CutEvidence::kIntact);
    EXPECT_EQ(o.status.attempts, 3);
    EXPECT_THAT(o.status.reason, HasSubstr("verification disagrees"));
}

TEST(ScissorsCommand, an_arm_in_the_way_is_not_touched) {
    ScissorsWorldOptions options;
    const Eigen::Vector3d p_C(0.0, 0.007, 0.112);  // just behind the thread's middle
    options.obstacles_C.push_back({p_C, p_C, 0.015});
    const ScissorsOutcome o = run_fault(options, 1);
    EXPECT_FALSE(o.closed);
    EXPECT_TRUE(o.status.aborted);
}

// ---- Promises ------------------------------------------------------------------------------------------

TEST(ScissorsCommand, the_same_seed_gives_the_same_commands) {
    const auto trace = [] {
        std::vector<double> all;
        ScissorsWorldOptions options;
        options.watch = [&](const ScissorsWorld& w) {
            const Joints q = w.arm(2).controller().setpoint().q;
            all.insert(all.end(), q.begin(), q.end());
            all.push_back(w.status().predicted_miss_m);
        };
        ScissorsWorld(options, 3).run();
        return all;
    };
    const std::vector<double> a = trace(), b = trace();
    ASSERT_EQ(a.size(), b.size());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(double)), 0);
}

TEST(ScissorsCommand, blades_keep_to_the_speed_limits_near_the_thread) {
    ScissorsWorldOptions options;
    double fastest = 0.0, fastest_near = 0.0;
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    options.watch = [&](const ScissorsWorld& w) {
        const ScissorsStatus& s = w.status();
        const Eigen::Vector3d p = w.arm(2).controller().setpoint_cp().translation();
        const double speed = last.isZero() ? 0.0 : (p - last).norm() / PsmArm::kPeriod_s;
        last = p;
        fastest = std::max(fastest, speed);
        if (s.state == ScissorsState::kFollow || s.state == ScissorsState::kClose)
            fastest_near = std::max(fastest_near, speed - s.velocity_C.norm());
    };
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        last.setZero();
        ScissorsWorld(options, seed).run();
    }
    std::printf("tip at most %.0f mm/s, near the thread %.0f mm/s beyond the thread's own\n", 1e3 * fastest,
                1e3 * fastest_near);
    EXPECT_LE(fastest, 0.110);
    EXPECT_LE(fastest_near, 0.035);
}

TEST(ScissorsCommand, blades_that_wait_give_way_to_an_arm_that_comes_near_and_come_back) {
    ScissorsWorldOptions options;
    options.accuracy = scenes::ArmAccuracy::kPerfect;
    options.command_s = 100.0;
    options.duration_s = 6.0;
    const auto tip_C = [](const ScissorsWorld& w) {
        return Eigen::Vector3d(w.arm(2).X_CB() * w.arm(2).controller().setpoint_cp().translation());
    };
    const Eigen::Vector3d parked_C = tip_C(ScissorsWorld(options, 1));
    // A ball of 3 mm comes from the side at 30 mm/s, as far as where the tip was, and leaves again.
    const auto ball = [&](double t) {
        const double away_m = 0.030 * std::abs(t - 2.0);
        const Eigen::Vector3d p = parked_C + Eigen::Vector3d(away_m, 0.001, 0.0);
        return scenes::Capsule{p, p, 0.003};
    };
    options.visitor_C = ball;
    double least_m = 1.0, farthest_m = 0.0;
    options.watch = [&](const ScissorsWorld& w) {
        for (const scenes::Capsule& c : w.arm(2).true_capsules_W().value)
            least_m = std::min(
                least_m, scenes::clearance_m({w.X_CW() * c.a, w.X_CW() * c.b, c.radius_m}, ball(w.time_s())));
        farthest_m = std::max(farthest_m, (tip_C(w) - parked_C).norm());
    };
    ScissorsWorld world(options, 1);
    world.run();
    std::printf("clearance at least %.1f mm, %.1f mm aside at most\n", 1e3 * least_m, 1e3 * farthest_m);
    EXPECT_GT(least_m, 0.002);
    EXPECT_GT(farthest_m, 0.005);
    EXPECT_LT((tip_C(world) - parked_C).norm(), 1e-4);
}

TEST(ScissorsCommand, refuses_what_makes_no_sense) {
    const Psm grasper(tool("LARGE_NEEDLE_DRIVER")), scissors(tool("ROUND_TIP_SCISSORS"));
    Joints q = Joints::Zero();
    q[2] = 0.15;
    PsmArm wrong(grasper, q), right(scissors, q);
    const Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    EXPECT_THROW(ScissorsCommand({}, wrong, X), std::invalid_argument);
    ScissorsOptions options;
    options.tolerance_m = 0.0;
    EXPECT_THROW(ScissorsCommand(options, right, X), std::invalid_argument);
    options = {};
    options.place.fraction = 1.5;
    EXPECT_THROW(ScissorsCommand(options, right, X), std::invalid_argument);
}

}  // namespace
}  // namespace atropos::robot
