#include <gtest/gtest.h>

#include <cmath>

#include "tests/sim/rod_support.hpp"

namespace atropos::sim {
namespace {

using Eigen::Vector3d;
using testing::come_to_rest;
using testing::sampled;
using testing::with_length;

/// Largest distance of nodes to the catenary of the same ends and length, at equal arc length.
double catenary_error_mm(int edges) {
    const double length = 0.07, span = 0.05;
    RodParameters parameters;
    parameters.EI_N_m2 = 0.0;
    parameters.GJ_N_m2 = 0.0;
    Rod rod(with_length(sampled(edges, [&](double u) { return Vector3d(span * u, 0, -0.08 * u * (1 - u)); }),
                        length),
            parameters);
    Boundary ends{{{0, {0, 0, 0}}, {edges, {span, 0, 0}}}, {}};
    come_to_rest(rod, ends);
    double low = 1e-4, high = 1.0;  // 2 a sinh(S / 2a) = L
    for (int i = 0; i < 200; ++i) {
        const double a = 0.5 * (low + high);
        (2 * a * std::sinh(span / (2 * a)) > length ? low : high) = a;
    }
    const double a = low;
    double worst = 0.0;
    for (int i = 0; i <= edges; ++i) {
        const double s = length * i / edges - 0.5 * length;
        const double x = a * std::asinh(s / a);
        const Vector3d p(0.5 * span + x, 0, a * std::cosh(x / a) - a * std::cosh(0.5 * span / a));
        worst = std::max(worst, (rod.state().p_W[static_cast<size_t>(i)] - p).norm());
    }
    return 1e3 * worst;
}

TEST(Rod, hangs_as_a_catenary_to_second_order) {
    const double coarse = catenary_error_mm(50), middle = catenary_error_mm(100),
                 fine = catenary_error_mm(200);
    RecordProperty("error_mm_at_100_edges", std::to_string(middle));
    std::printf("catenary error mm: %.5f %.5f %.5f\n", coarse, middle, fine);
    EXPECT_LT(middle, 0.01);
    EXPECT_NEAR(coarse / middle, 4.0, 0.4);
    EXPECT_NEAR(middle / fine, 4.0, 0.4);
}

}  // namespace
}  // namespace atropos::sim
