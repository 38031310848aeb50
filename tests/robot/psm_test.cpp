#include "robot/psm.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <numbers>
#include <sstream>

#include "tests/robot/random_joints.hpp"
#include "tests/support/real_data.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;

Psm needle_driver() {
    return Psm(tool("LARGE_NEEDLE_DRIVER"));
}

TEST(Psm, forward_kinematics_give_the_test_vectors_of_dvrk) {
    const Psm psm = needle_driver();
    EXPECT_NEAR((psm.forward(Joints::Zero()).translation() - Vector3d(0, 0, 0.0065)).norm(), 0.0, 1e-12);

    Joints q = Joints::Zero();
    q[2] = 0.12;
    EXPECT_NEAR((psm.forward(q).translation() - Vector3d(0, 0, -0.1135)).norm(), 0.0, 1e-12);
    Matrix3d R;
    R << 0, 1, 0, 1, 0, 0, 0, 0, -1;
    EXPECT_LT((psm.forward(q).linear() - R).norm(), 1e-12);

    q << 0.2, 0.1, 0.15, 0.3, 0.4, -0.2;
    R << 0.3612, 0.9242, -0.1242, 0.8367, -0.3800, -0.3945, -0.4118, 0.0386, -0.9105;
    EXPECT_LT((psm.forward(q).translation() - Vector3d(0.0271, -0.0176, -0.1391)).cwiseAbs().maxCoeff(),
              1e-4);
    EXPECT_LT((psm.forward(q).linear() - R).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(Psm, jacobian_equals_central_differences) {
    const Psm psm = needle_driver();
    scenes::RandomStream random(2, "joints");
    for (int n = 0; n < 200; ++n) {
        const Joints q = random_joints(psm, random);
        const auto J = psm.jacobian(q);
        const double h = 1e-6;
        for (int i = 0; i < 6; ++i) {
            Joints more = q, less = q;
            more[i] += h;
            less[i] -= h;
            const Isometry3d X1 = psm.forward(more), X0 = psm.forward(less);
            const Vector3d linear = (X1.translation() - X0.translation()) / (2 * h);
            const Matrix3d W = (X1.linear() - X0.linear()) / (2 * h) * psm.forward(q).linear().transpose();
            EXPECT_LT((J.col(i).head<3>() - linear).norm(), 1e-8);
            EXPECT_LT((J.col(i).tail<3>() - Vector3d(W(2, 1), W(0, 2), W(1, 0))).norm(), 1e-8);
        }
    }
}

TEST(Psm, inverse_kinematics_return_20000_random_poses) {
    scenes::RandomStream random(3, "joints");
    for (const char* name : {"LARGE_NEEDLE_DRIVER", "MEGA_NEEDLE_DRIVER", "MARYLAND_BIPOLAR_FORCEPS"}) {
        const Psm psm(tool(name));
        double worst_joint = 0.0, worst_pose = 0.0;
        for (int i = 0; i < 20000; ++i) {
            const Joints q = random_joints(psm, random);
            const Isometry3d X_BT = psm.forward(q);
            const auto result = psm.inverse(X_BT, q);
            ASSERT_TRUE(result) << reason(result) << " at " << q.transpose();
            worst_joint = std::max(worst_joint, (result.q - q).cwiseAbs().maxCoeff());
            worst_pose =
                std::max(worst_pose, (psm.forward(result.q).matrix() - X_BT.matrix()).cwiseAbs().maxCoeff());
        }
        EXPECT_LT(worst_pose, 1e-9) << name;
        EXPECT_LT(worst_joint, 1e-9) << name;
        RecordProperty(std::string(name) + "_worst_pose", std::to_string(worst_pose));
    }
}

TEST(Psm, every_branch_reaches_the_pose_and_only_one_lies_inside_the_limits) {
    const Psm psm = needle_driver();
    scenes::RandomStream random(4, "joints");
    for (int n = 0; n < 2000; ++n) {
        const Isometry3d X_BT = psm.forward(random_joints(psm, random));
        int inside = 0;
        std::vector<double> rolls;
        const auto all = psm.branches(X_BT);
        ASSERT_GE(all.size(), 2u);
        for (const Joints& q : all) {
            EXPECT_LT((psm.forward(q).matrix() - X_BT.matrix()).cwiseAbs().maxCoeff(), 1e-9);
            if (psm.limits().first_outside(q) < 0) {
                ++inside;
                rolls.push_back(q[3]);
            }
        }
        EXPECT_GE(inside, 1);
        for (size_t i = 1; i < rolls.size(); ++i)  // further solutions are turns of roll
            EXPECT_NEAR(std::remainder(rolls[i] - rolls[0], 2 * std::numbers::pi), 0.0, 1e-9);
    }
}

TEST(Psm, inverse_kinematics_choose_the_roll_nearest_to_the_present_one) {
    const Psm psm = needle_driver();
    Joints q;
    q << 0.1, -0.2, 0.15, 3.0, 0.3, -0.4;
    const Isometry3d X_BT = psm.forward(q);
    EXPECT_NEAR(psm.inverse(X_BT, q).q[3], 3.0, 1e-9);
    Joints near = Joints::Zero();
    near[3] = -3.5;
    EXPECT_NEAR(psm.inverse(X_BT, near).q[3], 3.0 - 2 * std::numbers::pi, 1e-9);
    q[3] = 1.0;  // one turn less would pass the roll limit of 260 degrees
    near[3] = -4.5;
    EXPECT_NEAR(psm.inverse(psm.forward(q), near).q[3], 1.0, 1e-9);
}

TEST(Psm, poses_out_of_reach_are_refused_with_a_reason) {
    const Psm psm = needle_driver();
    Joints q;
    q << 0.0, 0.0, 0.15, 0.0, 0.0, 0.0;
    Isometry3d deep = psm.forward(q);
    deep.translation().z() = -0.30;
    EXPECT_EQ(psm.inverse(deep).status, IkStatus::kOutsideLimits);
    EXPECT_NE(reason(psm.inverse(deep)).find("insertion"), std::string::npos);

    q[2] = 0.05;
    EXPECT_EQ(psm.inverse(psm.forward(q)).status, IkStatus::kTooShallow);
    EXPECT_NE(reason(psm.inverse(psm.forward(q))).find("45"), std::string::npos);

    q[2] = 0.15;
    q[4] = 85 * kDegree;
    EXPECT_EQ(psm.inverse(psm.forward(q)).status, IkStatus::kOutsideLimits);
    EXPECT_NE(reason(psm.inverse(psm.forward(q))).find("wrist_pitch 85.0 deg"), std::string::npos);

    Isometry3d centre = psm.forward(q);
    centre.translation().setZero();
    EXPECT_EQ(psm.inverse(centre).status, IkStatus::kAtRemoteCentre);
    centre.translation().x() = std::nan("");
    EXPECT_EQ(psm.inverse(centre).status, IkStatus::kNotAPose);
    Isometry3d stretched = psm.forward(q);
    stretched.linear() *= 1.1;
    EXPECT_EQ(psm.inverse(stretched).status, IkStatus::kNotAPose);
}

TEST(Psm, links_hang_together_at_their_pins) {
    scenes::RandomStream random(5, "joints");
    for (const Tool& t : tools()) {
        const Psm psm(t);
        const Joints q = random_joints(psm, random);
        const double jaw = 0.6;
        const auto X_BL = psm.link_poses(q, jaw);
        const auto turn = [](double angle, const Vector3d& axis) {
            Isometry3d X = Isometry3d::Identity();
            X.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
            return X;
        };
        const Isometry3d wrist = X_BL[kShaft] * turn(-q[4], Vector3d::UnitX());
        Isometry3d jaws =
            wrist * Eigen::Translation3d(0, 0, t.pitch_to_yaw_m) * turn(q[5], Vector3d::UnitY());
        EXPECT_LT((wrist.matrix() - X_BL[kWrist].matrix()).norm(), 1e-12);
        EXPECT_LT(((jaws * turn(jaw / 2, Vector3d::UnitY())).matrix() - X_BL[kJawLeft].matrix()).norm(),
                  1e-12);
        EXPECT_LT(((jaws * turn(-jaw / 2, Vector3d::UnitY())).matrix() - X_BL[kJawRight].matrix()).norm(),
                  1e-12);
        const Isometry3d X_BG = psm.forward(q) * t.X_TG;  // on the line between the jaws
        EXPECT_LT((X_BG.linear() - jaws.linear()).norm(), 1e-12);
        EXPECT_LT((X_BG.translation() - jaws * Vector3d(0, 0, 0.008)).norm(), 1e-12);
        EXPECT_LT((X_BL[kShaft].linear() * Vector3d::UnitZ() + X_BL[kShaft].translation().normalized() * -1.0)
                      .norm(),
                  1e-12);  // the shaft passes through the remote centre
    }
}

TEST(Psm, closed_jaws_meet_without_overlap_at_the_grip_point) {
    for (const Tool& t : tools()) {
        if (t.kind != ToolKind::kGrasper) continue;
        const scenes::Capsule &left = t.capsules[kJawLeft].back(), &right = t.capsules[kJawRight].back();
        EXPECT_NEAR(scenes::clearance_m(left, right), 0.0, 1e-12) << t.name;
        EXPECT_LT(left.a.z(), 0.008) << t.name;
        EXPECT_GT(left.b.z(), 0.008) << t.name;
        EXPECT_NEAR(left.b.z() + left.radius_m, 0.011, 1e-12) << t.name;
    }
}

// Rows of a real arm: joints, and the tip (rotation vector) as the dVRK computed it.
struct Row {
    Joints q;
    Isometry3d X_BT;
};
std::vector<Row> recording(const std::filesystem::path& path) {
    std::vector<Row> rows;
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::array<double, 13> v{};
        std::istringstream fields(line);
        std::string field;
        for (double& value : v) {
            std::getline(fields, field, ',');
            value = std::stod(field);
        }
        Row row;
        for (int i = 0; i < 6; ++i) row.q[i] = v[static_cast<size_t>(i) + 1];
        const Vector3d r(v[10], v[11], v[12]);
        row.X_BT = Eigen::Translation3d(v[7], v[8], v[9]) * Eigen::AngleAxisd(r.norm(), r.normalized());
        rows.push_back(row);
    }
    return rows;
}

TEST(Psm, reproduces_the_recording_of_a_real_arm) {
    const auto file = support::real_data("dvrk-psm-recording.csv");
    if (!file) GTEST_SKIP() << support::kNoRealData;
    const auto rows = recording(*file);
    ASSERT_EQ(rows.size(), 500u);
    const Psm psm = needle_driver();
    double sum = 0.0, worst = 0.0;
    int values = 0, close = 0, refused = 0;
    for (const Row& row : rows) {
        const double error = (psm.forward(row.q).translation() - row.X_BT.translation()).norm();
        sum += error;
        worst = std::max(worst, error);
        const auto result = psm.inverse(row.X_BT, row.q);
        if (!result) {  // one row passes the wrist limit by 0.006 rad
            ++refused;
            EXPECT_EQ(result.status, IkStatus::kOutsideLimits);
        }
        for (int i = 0; i < 6; ++i, ++values) close += std::abs(result.q[i] - row.q[i]) < 2e-4;
    }
    EXPECT_LE(1e3 * sum / 500.0, 0.002);
    EXPECT_LE(1e3 * worst, 0.06);
    EXPECT_GE(close, 0.99 * values);
    EXPECT_EQ(refused, 1);
    std::printf("recording: tip mean %.4f max %.4f mm, %.2f %% of joint values within 2e-4, %d refused\n",
                1e3 * sum / 500.0, 1e3 * worst, 100.0 * close / values, refused);
}

}  // namespace
}  // namespace atropos::robot
