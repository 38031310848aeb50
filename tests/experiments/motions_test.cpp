// The motions that a scene file can ask of its arms, in the simulated field.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <sstream>

#include "experiments/scene_description.hpp"
#include "experiments/testbed.hpp"
#include "scenes/scene_file.hpp"
#include "tests/experiments/temporary_folder.hpp"
#include "tests/sim/knot.hpp"
#include "tests/support/real_data.hpp"

namespace atropos::experiments {
namespace {

namespace fs = std::filesystem;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using sim::EventKind;
using ::testing::HasSubstr;

const fs::path kScenes = fs::path(ATROPOS_SCENES);

scenes::SceneConfig scene(const std::string& name, std::vector<std::string> overrides = {}) {
    overrides.push_back("tissue.preset=none");
    return scenes::load_scene(kScenes / name, overrides);
}

Vector3d true_grip_C(const Testbed& field, int arm) {
    return field.arm(arm).truth().value.X_CT * field.arm(arm).psm().tool().X_TG.translation();
}

const sim::Event* first(const Testbed& field, EventKind kind, const std::string& name) {
    for (const sim::Event& e : field.world().events())
        if (e.kind == kind && e.name == name) return &e;
    return nullptr;
}

std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const std::exception& error) {
        return error.what();
    }
    return "no error";
}

TEST(Waypoints, are_passed_within_the_blend_and_the_arm_rests_at_the_last) {
    const scenes::SceneConfig config = scene("waypoints.yaml", {"arms.accuracy=perfect"});
    Testbed field(config);
    const Vector3d start = true_grip_C(field, 1), held = true_grip_C(field, 0);
    const auto& keys = config.arms.psm2.waypoints;
    std::vector<double> nearest(keys.offsets_m.size(), 1.0);
    double fastest = 0.0, shaken = 0.0;
    Vector3d before = start;
    const int ticks = 6000;
    for (int i = 0; i < ticks; ++i) {
        field.tick();
        const Vector3d now = true_grip_C(field, 1);
        for (size_t k = 0; k < nearest.size(); ++k)
            nearest[k] = std::min(nearest[k], (now - start - keys.offsets_m[k]).norm());
        fastest = std::max(fastest, (now - before).norm() / 1e-3);
        before = now;
        shaken += (true_grip_C(field, 0) - held).squaredNorm() / (3.0 * ticks);
    }
    for (const double distance : nearest) EXPECT_LT(distance, keys.blend_m);
    EXPECT_LT(nearest.back(), 1e-6);
    EXPECT_LT((before - start - keys.offsets_m.back()).norm(), 1e-6);
    EXPECT_LT(fastest, 1.01 * keys.speed_m_s);
    EXPECT_NEAR(1e3 * std::sqrt(shaken), 0.03, 0.006);  // PSM1 stands, but for its tremor
    EXPECT_TRUE(field.world().holds(0) && field.world().holds(1));
}

TEST(Waypoints, are_travelled_truly_faster_with_a_time_scale) {
    const auto duration_s = [](const char* scale) {
        Testbed field(scene("waypoints.yaml", {"arms.accuracy=perfect", scale}));
        for (int i = 0; i < 1000 || field.arm(1).controller().is_busy(); ++i) field.tick();
        return field.time_s();
    };
    EXPECT_NEAR(duration_s("arms.time_scale=1") / duration_s("arms.time_scale=2"), 2.0, 0.01);
}

class Replaying : public TemporaryFolder {
  protected:
    std::string scene_text(const std::string& keys, const std::string& more = "") const {
        return "duration_s: 2\ntissue: {preset: none}\narms:\n  accuracy: perfect\n" + more +
               "  PSM1: {motion: replay, recording: " + keys + "}\n" +
               "  PSM2: {motion: replay, recording: " + keys + "}\n";
    }
    scenes::SceneConfig parsed(const std::string& text) const {
        return scenes::parse_scene("test.yaml", text, folder_);
    }
};

/// One second of manipulation as a recording, and where the grips truly were.
struct Recorded {
    std::string csv = "frame,time_s,arm,frame_id,q1,q2,q3,q4,q5,q6,jaw_rad,x_m,y_m,z_m,qx,qy,qz,qw\n";
    std::string jigsaws, joints = "q1,q2,q3,q4,q5,q6,jaw_rad\n";
    std::array<std::vector<Vector3d>, 2> p_CG;

    Recorded() {
        Testbed field(scene("auto_scissors.yaml", {"arms.accuracy=perfect"}));
        for (int i = 0; i < 1000; ++i) {
            const bool thirty = i % 33 == 0;
            if (i % 10 == 0)
                for (int arm = 0; arm < 2; ++arm) add(field, arm, i);
            if (thirty) add_jigsaws(field);
            field.tick();
        }
    }
    void add(const Testbed& field, int arm, int tick) {
        const robot::ArmState s = field.arm(arm).truth().value;
        const Vector3d p = s.X_CT.translation();
        const Eigen::Quaterniond r(s.X_CT.linear());
        std::ostringstream line, q;
        line.precision(12);
        q.precision(12);
        for (int k = 0; k < 6; ++k) q << s.q[k] << ",";
        q << 0;
        line << tick << "," << 5.0 + 1e-3 * tick << "," << field.arm(arm).name() << ",C," << q.str();
        for (const double v : {p.x(), p.y(), p.z(), r.x(), r.y(), r.z(), r.w()}) line << "," << v;
        csv += line.str() + "\n";
        if (arm == 0) joints += q.str() + "\n";
        p_CG[static_cast<size_t>(arm)].push_back(true_grip_C(field, arm));
    }
    void add_jigsaws(const Testbed& field) {
        std::ostringstream line;
        line.precision(12);
        for (int k = 0; k < 38; ++k) line << "0 ";
        for (int arm = 0; arm < 2; ++arm) {
            const Isometry3d X = robot::half_turn_about_z() * field.arm(arm).truth().value.X_CT;
            for (int k = 0; k < 3; ++k) line << X.translation()[k] << " ";
            for (int k = 0; k < 9; ++k) line << X.linear()(k / 3, k % 3) << " ";
            line << "0 0 0 0 0 0 0 ";
        }
        jigsaws += line.str() + "\n";
    }
};
const Recorded& recorded() {
    static const Recorded kRecorded;
    return kRecorded;
}

TEST_F(Replaying, takes_both_arms_where_they_were_recorded_shifted_by_the_registration) {
    write("two.csv", recorded().csv);
    const std::string keys = "{file: two.csv, registration: {position_mm: [-2, 1, 0]}}";
    Testbed field(parsed(scene_text(keys)));
    double worst = 0.0;
    for (int i = 0; i < 990; ++i) {
        if (i % 10 == 0)
            for (int arm = 0; arm < 2; ++arm) {
                const Vector3d was = recorded().p_CG[static_cast<size_t>(arm)][static_cast<size_t>(i / 10)];
                worst = std::max(worst, (true_grip_C(field, arm) - was - Vector3d(-2e-3, 1e-3, 0)).norm());
            }
        field.tick();
    }
    std::printf("replay: at most %.4f mm from the recording\n", 1e3 * worst);
    EXPECT_LT(worst, 1e-5);
    EXPECT_TRUE(field.world().holds(0) && field.world().holds(1));
}

TEST_F(Replaying, runs_twice_as_fast_with_a_time_scale_of_two) {
    write("two.csv", recorded().csv);
    Testbed field(parsed(scene_text("{file: two.csv}", "  time_scale: 2\n")));
    for (int i = 0; i < 400; ++i) field.tick();
    EXPECT_LT((true_grip_C(field, 0) - recorded().p_CG[0][80]).norm(), 2e-5);
}

TEST_F(Replaying, takes_bare_joints_at_their_rate) {
    write("one.csv", recorded().joints);
    const std::string text =
        "duration_s: 1\ntissue: {preset: none}\narms:\n  accuracy: perfect\n"
        "  PSM1: {motion: replay, recording: {file: one.csv, rate_hz: 200}}\n"
        "  PSM2: {motion: hold}\n";
    Testbed field(parsed(text));
    for (int i = 0; i < 250; ++i) field.tick();
    EXPECT_LT((true_grip_C(field, 0) - recorded().p_CG[0][50]).norm(), 2e-5);
}

TEST_F(Replaying, takes_the_76_columns_of_jigsaws) {
    write("suturing.txt", recorded().jigsaws);
    Testbed field(parsed(scene_text("{file: suturing.txt}")));
    const int tick = 600;  // row 18 at 30 Hz, recorded after 594 ms
    for (int i = 0; i < tick; ++i) field.tick();
    for (int arm = 0; arm < 2; ++arm) {
        const auto& p = recorded().p_CG[static_cast<size_t>(arm)];
        EXPECT_LT((true_grip_C(field, arm) - (0.6 * p[59] + 0.4 * p[60])).norm(), 5e-5);
    }
}

TEST_F(Replaying, refuses_a_recording_with_its_first_offending_row) {
    std::string beyond = recorded().joints;
    const size_t third = beyond.find('\n', beyond.find('\n', beyond.find('\n') + 1) + 1) + 1;
    beyond.insert(third, "0,0,0.25,0,0,0,0\n");
    write("one.csv", beyond);
    const std::string keys = "{file: one.csv}";
    const std::string what = error_of([&] { Testbed field(parsed(scene_text(keys))); });
    EXPECT_THAT(what, HasSubstr("one.csv:4: insertion 0.010000 m beyond its limit"));
    EXPECT_EQ(what.find('\n'), std::string::npos);
    EXPECT_THAT(error_of([&] { Testbed field(parsed(scene_text("{file: none.csv}"))); }),
                HasSubstr("no file 'none.csv'"));
    EXPECT_THAT(error_of([&] { Testbed field(parsed(scene_text("{rate_hz: 30}"))); }),
                HasSubstr("arms.PSM1.recording.file is missing"));
}

TEST_F(Replaying, puts_the_real_recording_on_the_third_arm) {
    const auto file = support::real_data("dvrk-psm-recording.csv");
    if (!file) GTEST_SKIP() << support::kNoRealData;
    const std::string text =
        "duration_s: 5\ntissue: {preset: none}\narms:\n  accuracy: perfect\n"
        "  PSM1: {motion: hold}\n  PSM2: {motion: hold}\n"
        "  PSM3: {tool: large_needle_driver, motion: replay, recording: {file: " +
        file->string() + "}}\n";
    const scenes::SceneConfig config = parsed(text);
    EXPECT_THAT(describe_arms(config), HasSubstr("4.99 s of"));
    EXPECT_THAT(describe_arms(config), HasSubstr("values clamped to limits: 1"));
    Testbed field(config);
    for (int i = 0; i < 4990; ++i) field.tick();
    EXPECT_LT((field.arm(2).truth().value.q -
               load_replay(config, 2, robot::frame_tree(scene_layout(config), field.rig())).joints(4.99))
                  .cwiseAbs()
                  .maxCoeff(),
              1e-6);
}

TEST(MidGrasp, takes_the_thread_where_it_is_asked_to_and_lifts_it_with_arms_as_imperfect_as_real_ones) {
    for (const char* seed : {"seed=1", "seed=2", "seed=3"}) {
        Testbed field(scene("mid_grasp.yaml", {seed}));
        const double before_m = field.thread().sample(0, field.thread().span.middle_s_m()).z();
        for (int i = 0; i < 6000; ++i) field.tick();
        const sim::Event* grasp = first(field, EventKind::kGrasp, "PSM3");
        ASSERT_TRUE(grasp) << seed;
        EXPECT_FALSE(first(field, EventKind::kCollision, "PSM3"));
        EXPECT_TRUE(field.world().holds(0) && field.world().holds(1) && field.world().holds(2)) << seed;
        const double off_m = grasp->s_m - field.thread().span.middle_s_m();
        const double lifted_m = field.thread().sample(0, field.world().held_s_m(2)).z() - before_m;
        std::printf("mid grasp, %s: %.2f mm from the middle, lifted by %.2f mm\n", seed, 1e3 * off_m,
                    1e3 * lifted_m);
        EXPECT_LT(std::abs(off_m), 2e-3) << seed;
        EXPECT_GT(lifted_m, 4e-3) << seed;
    }
}

TEST(MidGrasp, carries_the_thread_through_its_way_points) {
    const scenes::SceneConfig config =
        scene("third_arm.yaml", {"arms.accuracy=perfect", "arms.mid_grasp.at_s=0.1", "arms.PSM1.motion=hold",
                                 "arms.PSM3.waypoints.speed_mm_s=15"});
    Testbed field(config);
    while (!field.world().holds(2) && field.time_s() < 8.0) field.tick();
    ASSERT_TRUE(field.world().holds(2));
    const Vector3d taken = true_grip_C(field, 2);
    double farthest_m = 0.0;
    for (int i = 0; i < 6000; ++i) {
        field.tick();
        farthest_m = std::max(farthest_m, (true_grip_C(field, 2) - taken).norm());
    }
    EXPECT_GT(farthest_m, config.arms.mid_grasp.lift_m + 5e-3);
    EXPECT_TRUE(field.world().holds(0) && field.world().holds(1) && field.world().holds(2));
    EXPECT_FALSE(first(field, EventKind::kCollision, "PSM3"));
}

TEST(TiedKnot, stays_where_the_arm_lets_go_of_it) {
    Testbed field(scene("tied_knot.yaml"));
    const Vector3d knot_W = field.X_WC() * true_grip_C(field, 0);
    const auto off_m = [&] {
        const sim::ThreadTruth thread = field.thread();
        return (thread.sample(0, thread.span.s0_m) - knot_W).norm();
    };
    EXPECT_LT(off_m(), 2e-5);
    EXPECT_FALSE(field.world().holds(0));
    for (int i = 0; i < 3000; ++i) field.tick();
    EXPECT_LT(off_m(), 2e-5);
    EXPECT_TRUE(field.thread().span.intact);
    EXPECT_GT((field.X_WC() * true_grip_C(field, 0) - knot_W).norm(), 0.02) << "PSM1 leaves";
}

TEST(KnotPull, draws_a_hanging_overhand_knot_tight_to_one_newton) {
    Testbed field(scene("knot_pull.yaml"));
    const Vector3d view(0.3, 1.0, 0.4);
    const auto determinant = [&] {
        return sim::testing::knot_determinant(field.thread().strands[0].p_W, view);
    };
    EXPECT_EQ(determinant(), 3);
    const double apart = (true_grip_C(field, 1) - true_grip_C(field, 0)).norm();
    for (int i = 0; i < 5000; ++i) field.tick();
    EXPECT_EQ(determinant(), 3);
    const double tension = field.thread().tension_N(0, 0.005),
                 way = (true_grip_C(field, 1) - true_grip_C(field, 0)).norm() - apart;
    std::printf("knot: pulled %.1f mm apart, %.2f N at the jaws, %.2f N in the thread\n", 1e3 * way,
                field.world().grip_force_N(0), tension);
    EXPECT_NEAR(tension, 1.0, 0.2);
    EXPECT_TRUE(field.world().holds(0) && field.world().holds(1));
}

TEST(Manipulation, may_begin_with_arms_nearer_than_a_thread_hangs_well) {
    const Testbed field(scene("auto_scissors_long.yaml"));
    const double apart_m = (true_grip_C(field, 0) - true_grip_C(field, 1)).norm();
    EXPECT_LT(apart_m, 0.4 * field.scene().thread.length_m);
}

TEST(Motions, that_do_not_suit_their_arm_are_refused_in_one_line) {
    const auto refused = [](const std::vector<std::string>& keys) {
        return error_of([&] { Testbed field(scene("auto_scissors.yaml", keys)); });
    };
    EXPECT_THAT(refused({"arms.PSM1.motion=mid_grasp"}),
                HasSubstr("arms.PSM1.motion is mid_grasp, expected one"));
    EXPECT_THAT(refused({"arms.PSM3.motion=pull"}), HasSubstr("arms.PSM3.motion is pull, expected one"));
    EXPECT_THAT(refused({"arms.PSM3.motion=mid_grasp"}), HasSubstr("expected a grasper"));
    EXPECT_THAT(refused({"arms.PSM1.motion=waypoints"}), HasSubstr("offsets_mm is empty"));
    EXPECT_THAT(refused({"arms.layout=lab_rig"}), HasSubstr("has no PSM3, expected arms.PSM3.base_mm"));
    EXPECT_THAT(refused({"arms.PSM1.motion=hold", "arms.PSM2.motion=hold", "thread.knot=overhand",
                         "thread.length_mm=52"}),
                HasSubstr("too short for a loose knot"));
}

TEST(SceneDescription, says_whether_thread_and_cut_are_within_reach_and_what_the_thread_is) {
    const std::string arms = describe_arms(scene("auto_scissors.yaml"));
    EXPECT_THAT(arms, HasSubstr("PSM1 large_needle_driver: remote centre (-100.0, 0.0, 173.2) mm"));
    EXPECT_THAT(arms, HasSubstr("holds its end: yes"));
    EXPECT_THAT(arms, HasSubstr("cuts a slack middle: yes"));
    EXPECT_THAT(describe_arms(scene("auto_scissors.yaml", {"arms.PSM3.base_mm=[0, -190, 190]"})),
                HasSubstr("cuts a slack middle: no, insertion"));
    EXPECT_THAT(describe_arms(scene("mid_grasp.yaml")), HasSubstr("grasps a slack middle: yes"));
    const std::string thread = describe_thread(scene("auto_scissors.yaml"));
    EXPECT_THAT(thread, HasSubstr("gravity-bending    24.9 mm"));
    EXPECT_THAT(thread, HasSubstr("diameters"));
    EXPECT_THAT(thread, HasSubstr("expected cost"));
    EXPECT_THAT(thread, HasSubstr("warning: thread: EI_N_m2 of silk is assumed"));
    // A cantilever that sags by w L^4 / 8 EI, small enough for the formula: 20 mm, 0.5 mm at 66.3 mg/m.
    EXPECT_THAT(describe_sag(scene("auto_scissors.yaml"), 20, 0.5), HasSubstr("EI_N_m2: 2.599e-08"));
}

}  // namespace
}  // namespace atropos::experiments
