#include "robot/ecm.hpp"

#include <gtest/gtest.h>

#include "scenes/random_stream.hpp"

namespace atropos::robot {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

EcmJoints random_joints(const Ecm& ecm, scenes::RandomStream& random) {
    EcmJoints q;
    for (int i = 0; i < 4; ++i) q[i] = random.uniform(ecm.limits().lower[i], ecm.limits().upper[i]);
    q[2] = random.uniform(0.03, 0.255);
    return q;
}

TEST(Ecm, tip_lies_straight_below_the_remote_centre_at_zero) {
    const Isometry3d X_BT = Ecm().forward({0.0, 0.0, 0.12, 0.0});
    EXPECT_LT((X_BT.translation() - Vector3d(0, 0, -0.1207)).norm(), 1e-12);
    EXPECT_LT((X_BT.linear().col(2) - Vector3d(0, 0, -1)).norm(), 1e-12);
}

TEST(Ecm, a_30_degree_scope_looks_30_degrees_aside) {
    const Vector3d straight = Ecm().forward(EcmJoints::Zero()).linear().col(2);
    for (const Scope scope : {Scope::kUp30, Scope::kDown30}) {
        const Isometry3d X_BT = Ecm(scope).forward(EcmJoints::Zero());
        EXPECT_NEAR(X_BT.linear().col(2).dot(straight), std::sqrt(0.75), 1e-12);
        const double up = X_BT.linear().col(2).dot(Ecm().forward(EcmJoints::Zero()).linear().col(1));
        EXPECT_NEAR(up, scope == Scope::kUp30 ? 0.5 : -0.5, 1e-12);
    }
}

TEST(Ecm, inverse_kinematics_return_the_joints_of_every_scope) {
    scenes::RandomStream random(1, "ecm");
    for (const Scope scope : {Scope::kStraight, Scope::kUp30, Scope::kDown30}) {
        const Ecm ecm(scope);
        for (int i = 0; i < 2000; ++i) {
            const EcmJoints q = random_joints(ecm, random);
            const auto result = ecm.inverse(ecm.forward(q));
            ASSERT_TRUE(result) << reason(result);
            EXPECT_LT((result.q - q).cwiseAbs().maxCoeff(), 1e-9);
        }
    }
}

TEST(Ecm, views_that_do_not_pass_the_remote_centre_are_refused) {
    Isometry3d X_BT = Ecm().forward({0.1, 0.2, 0.12, 0.0});
    X_BT.linear() = X_BT.linear() * Eigen::AngleAxisd(0.01, Vector3d::UnitX());
    EXPECT_EQ(Ecm().inverse(X_BT).status, IkStatus::kNotOnAxis);
    EXPECT_NE(reason(Ecm().inverse(X_BT)).find("0.57 deg"), std::string::npos);
}

TEST(Ecm, jacobian_equals_central_differences) {
    const Ecm ecm(Scope::kUp30);
    scenes::RandomStream random(2, "ecm");
    for (int n = 0; n < 100; ++n) {
        const EcmJoints q = random_joints(ecm, random);
        const auto J = ecm.jacobian(q);
        for (int i = 0; i < 4; ++i) {
            const double h = 1e-6;
            EcmJoints more = q, less = q;
            more[i] += h;
            less[i] -= h;
            const Isometry3d X1 = ecm.forward(more), X0 = ecm.forward(less);
            const Eigen::Matrix3d W =
                (X1.linear() - X0.linear()) / (2 * h) * ecm.forward(q).linear().transpose();
            EXPECT_LT((J.col(i).head<3>() - (X1.translation() - X0.translation()) / (2 * h)).norm(), 1e-8);
            EXPECT_LT((J.col(i).tail<3>() - Vector3d(W(2, 1), W(0, 2), W(1, 0))).norm(), 1e-8);
        }
    }
}

}  // namespace
}  // namespace atropos::robot
