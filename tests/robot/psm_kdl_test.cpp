#include <gtest/gtest.h>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "robot/psm.hpp"
#include "tests/robot/kdl_chain.hpp"
#include "tests/robot/random_joints.hpp"

namespace atropos::robot {
namespace {

TEST(Psm, forward_kinematics_and_jacobian_equal_those_of_kdl) {
    const Psm psm(tool("LARGE_NEEDLE_DRIVER"));
    const KDL::Chain chain = kdl_chain();
    KDL::ChainFkSolverPos_recursive forward(chain);
    KDL::ChainJntToJacSolver jacobian(chain);
    scenes::RandomStream random(1, "joints");
    for (int i = 0; i < 1000; ++i) {
        const Joints q = random_joints(psm, random);
        KDL::JntArray joints(6);
        joints.data = q;
        KDL::Frame frame;
        KDL::Jacobian J(6);
        ASSERT_GE(forward.JntToCart(joints, frame), 0);
        ASSERT_GE(jacobian.JntToJac(joints, J), 0);
        const Eigen::Isometry3d X_BT = psm.forward(q);
        for (int row = 0; row < 3; ++row) {
            EXPECT_NEAR(X_BT.translation()[row], frame.p[row], 1e-9);
            for (int column = 0; column < 3; ++column)
                EXPECT_NEAR(X_BT.linear()(row, column), frame.M(row, column), 1e-9);
        }
        EXPECT_LT((psm.jacobian(q) - J.data).cwiseAbs().maxCoeff(), 1e-9);
    }
}

}  // namespace
}  // namespace atropos::robot
