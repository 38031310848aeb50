#include "robot/layout_defaults.hpp"

#include <gtest/gtest.h>

#include "robot/arm_clearance.hpp"
#include "tests/robot/hanging_thread.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

struct Scene {
    Layout layout = default_layout();
    LayoutDefaults defaults;
    scenes::StereoRig rig = scenes::rig_preset("paper").rig;
    FrameTree tree = frame_tree(layout, rig);
    scenes::Polyline thread = hanging_thread(defaults.X_WG()[0].translation(),
                                             defaults.X_WG()[1].translation(), defaults.thread_length_m);

    Psm psm(size_t i) const { return Psm(tool(layout.arms[i].tool)); }
    Joints holding(size_t i) const {
        const Psm p = psm(i);
        const auto q = joints_for(p, layout.arms[i].X_WB, defaults.X_WG()[i], p.tool().X_TG);
        EXPECT_TRUE(q) << reason(q);
        return q.q;
    }
    Joints cutting(const Isometry3d& X_WS) const {
        const Psm p = psm(2);
        const auto q = joints_for(p, layout.arms[2].X_WB, X_WS, *p.tool().X_TS);
        EXPECT_TRUE(q) << reason(q);
        return q.q;
    }
    Capsules capsules_W(size_t i, const Joints& q, double jaw) const {
        Capsules all = psm(i).capsules(q, jaw);
        for (scenes::Capsule& c : all) c = {layout.arms[i].X_WB * c.a, layout.arms[i].X_WB * c.b, c.radius_m};
        return all;
    }
    Capsules endoscope_W() const {
        const scenes::Capsule c = Ecm().capsule(layout.ecm_joints);
        return {{layout.X_WEcm * c.a, layout.X_WEcm * c.b, c.radius_m}};
    }
};

TEST(LayoutDefaults, grips_and_thread_are_in_view_of_both_eyes_near_the_working_distance) {
    const Scene s;
    const Isometry3d X_CW = s.tree.pose("C", "W");
    for (const Vector3d& p_W : s.thread.points) {
        const Vector3d p_C = X_CW * p_W;
        EXPECT_NEAR(p_C.z(), 0.1, 0.012);
        for (const auto& pixel : {s.rig.project_left(p_C), s.rig.project_right(p_C)}) {
            EXPECT_GT(pixel.x(), 100);
            EXPECT_LT(pixel.x(), 540);
            EXPECT_GT(pixel.y(), 60);
            EXPECT_LT(pixel.y(), 300);
        }
    }
    EXPECT_NEAR(s.thread.length_m(), 0.07, 1e-4);
    EXPECT_GT(s.thread.points[50].z(), -0.0125);  // above the tissue, which lies 25 mm below the target
}

TEST(LayoutDefaults, holders_reach_their_grips_far_from_all_limits) {
    const Scene s;
    for (size_t i = 0; i < 2; ++i) {
        const Joints q = s.holding(i);
        const auto limits = s.psm(i).limits();
        for (int j = 0; j < 6; ++j) {
            const double room = j == 2 ? 0.02 : 0.4;
            EXPECT_GT(q[j], limits.lower[j] + room) << "PSM" << i + 1 << " joint " << j;
            EXPECT_LT(q[j], limits.upper[j] - room) << "PSM" << i + 1 << " joint " << j;
        }
        EXPECT_LT(std::abs(q[3]), 3.2);
        std::printf("PSM%zu holds at %.3f %.3f %.4f %.3f %.3f %.3f\n", i + 1, q[0], q[1], q[2], q[3], q[4],
                    q[5]);
    }
}

TEST(LayoutDefaults, a_cut_by_psm3_at_the_middle_keeps_every_arm_5_mm_apart) {
    const Scene s;
    const Vector3d p_WB3 = s.layout.arms[2].X_WB.translation();
    const Isometry3d X_parked = s.defaults.X_WS_parked(p_WB3);
    const Isometry3d X_cut = LayoutDefaults::X_WS(s.thread.points[50], Vector3d::UnitX(), p_WB3);
    const Joints q0 = s.cutting(X_parked), q1 = s.cutting(X_cut);
    const double open = s.psm(2).tool().jaw_max_rad;
    const MovingCapsules scissors = [&](double t) { return s.capsules_W(2, q0 + t * (q1 - q0), open); };
    const auto fixed = [](const Capsules& c) { return [c](double) { return c; }; };
    std::vector<std::pair<std::string, Capsules>> others = {{"PSM1", s.capsules_W(0, s.holding(0), 0.0)},
                                                            {"PSM2", s.capsules_W(1, s.holding(1), 0.0)},
                                                            {"ECM", s.endoscope_W()}};
    for (const auto& [name, capsules] : others) {
        const Sweep sweep = swept_clearance(scissors, fixed(capsules));
        EXPECT_GE(sweep.clearance_m, 0.005) << name;
        std::printf("PSM3 to %s: %.1f mm clear\n", name.c_str(), 1e3 * sweep.clearance_m);
    }
    EXPECT_GE(clearance_m(others[0].second, others[1].second), 0.005);
    EXPECT_GE(clearance_m(others[0].second, others[2].second), 0.005);
    EXPECT_GE(clearance_m(others[1].second, others[2].second), 0.005);
    std::printf("PSM3 parked %.3f %.3f %.4f %.3f %.3f %.3f, cutting %.3f %.3f %.4f %.3f %.3f %.3f\n", q0[0],
                q0[1], q0[2], q0[3], q0[4], q0[5], q1[0], q1[1], q1[2], q1[3], q1[4], q1[5]);
}

TEST(LayoutDefaults, the_blades_enclose_the_thread_and_the_closed_jaws_hold_it_at_the_grips) {
    const Scene s;
    const Vector3d middle = s.thread.points[50];
    const Isometry3d X_cut =
        LayoutDefaults::X_WS(middle, Vector3d::UnitX(), s.layout.arms[2].X_WB.translation());
    const Joints q = s.cutting(X_cut);
    const Capsules open = s.capsules_W(2, q, s.psm(2).tool().jaw_max_rad);
    for (const auto& capsule : open) EXPECT_GT(scenes::clearance_m(capsule, middle), 0.0005);
    const Capsules shut = s.capsules_W(2, q, 0.0);
    double nearest = 1.0;
    for (const auto& capsule : shut) nearest = std::min(nearest, scenes::clearance_m(capsule, middle));
    EXPECT_LT(nearest, 0.0003);
    for (size_t i = 0; i < 2; ++i) {
        double grip = 1.0;
        for (const auto& capsule : s.capsules_W(i, s.holding(i), 0.0))
            grip = std::min(grip, scenes::clearance_m(capsule, s.defaults.X_WG()[i].translation()));
        EXPECT_NEAR(grip, 0.0, 1e-9);
    }
}

TEST(ArmClearance, a_sweep_is_never_above_a_dense_search_and_close_to_it) {
    const MovingCapsules first = [](double t) {
        return Capsules{{{-0.1, 0, 0.05 * t}, {0.1, 0.05 * t, 0.02}, 0.004}};
    };
    const MovingCapsules second = [](double t) {
        return Capsules{{{0.0, -0.1, 0.06 - 0.05 * t}, {0.02 * t, 0.1, 0.05}, 0.004}};
    };
    double dense = 1.0;
    for (int i = 0; i <= 20000; ++i)
        dense = std::min(dense, clearance_m(first(i / 20000.0), second(i / 20000.0)));
    const Sweep sweep = swept_clearance(first, second, 1e-4);
    EXPECT_LE(sweep.clearance_m, dense);
    EXPECT_GE(sweep.clearance_m, dense - 1.1e-4);
}

}  // namespace
}  // namespace atropos::robot
