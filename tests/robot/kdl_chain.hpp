#pragma once

#include <kdl/chain.hpp>
#include <numbers>

namespace atropos::robot {

/// A PSM with a large needle driver, written once more for Orocos KDL.
inline KDL::Chain kdl_chain() {
    const double quarter = std::numbers::pi / 2.0;
    using KDL::Frame;
    using KDL::Joint;
    using KDL::Segment;
    KDL::Chain chain;
    // KDL's modified DH puts the joint after the fixed part: a(i-1), alpha(i-1), then rotation about the new
    // z.
    const auto fixed = [](double a, double alpha) {
        return Frame(KDL::Rotation::RotX(alpha), KDL::Vector(a, 0, 0));
    };
    const auto add = [&](double a, double alpha, double d, double theta, bool prismatic) {
        chain.addSegment(Segment(Joint(Joint::Fixed), fixed(a, alpha)));
        chain.addSegment(Segment(Joint(prismatic ? Joint::TransZ : Joint::RotZ),
                                 Frame(KDL::Rotation::RotZ(theta), KDL::Vector(0, 0, d))));
    };
    add(0, quarter, 0, quarter, false);
    add(0, -quarter, 0, -quarter, false);
    add(0, quarter, -0.4318, 0, true);
    add(0, 0, 0.4162, 0, false);
    add(0, -quarter, 0, -quarter, false);
    add(0.0091, -quarter, 0, -quarter, false);
    chain.addSegment(Segment(Joint(Joint::Fixed), Frame(KDL::Rotation(0, -1, 0, 0, 0, 1, -1, 0, 0))));
    return chain;
}

}  // namespace atropos::robot
