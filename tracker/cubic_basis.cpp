#include "tracker/cubic_basis.hpp"

#include <algorithm>

namespace atropos::tracker {

// Cox-de Boor, degree by degree; derivatives by differences of lower degrees (The NURBS Book, eq. 2.5, 2.7).
CubicBasisValues CubicBasis::at(double u) const {
    u = std::clamp(u, 0.0, 1.0);
    const std::vector<double>& t = basis_.knots();
    const int i = basis_.span(u);
    const auto knot = [&t](int k) { return t[static_cast<std::size_t>(k)]; };
    const auto ratio = [](double a, double b) { return b > 0.0 ? a / b : 0.0; };

    // N[d][r]: function i - d + r of degree d.
    double N[4][4] = {};
    N[0][0] = 1.0;
    for (int d = 1; d <= 3; ++d)
        for (int r = 0; r <= d; ++r) {
            const int k = i - d + r;
            const double left = r > 0 ? N[d - 1][r - 1] : 0.0;
            const double right = r < d ? N[d - 1][r] : 0.0;
            N[d][r] = ratio(u - knot(k), knot(k + d) - knot(k)) * left +
                      ratio(knot(k + d + 1) - u, knot(k + d + 1) - knot(k + 1)) * right;
        }
    // N_k,d' = d (N_k,d-1 / (t_k+d - t_k) - N_k+1,d-1 / (t_k+d+1 - t_k+1))
    const auto differentiated = [&](int d, const double* lower, double* out) {
        for (int r = 0; r <= d; ++r) {
            const int k = i - d + r;
            const double left = r > 0 ? lower[r - 1] : 0.0;
            const double right = r < d ? lower[r] : 0.0;
            out[r] = d * (ratio(left, knot(k + d) - knot(k)) - ratio(right, knot(k + d + 1) - knot(k + 1)));
        }
    };
    CubicBasisValues values;
    values.first = i - 3;
    double first_of_quadratic[4] = {};
    differentiated(3, N[2], values.derivative.data());
    differentiated(2, N[1], first_of_quadratic);
    differentiated(3, first_of_quadratic, values.second_derivative.data());
    std::copy(N[3], N[3] + 4, values.value.begin());
    return values;
}

std::vector<CubicBasisValues> CubicBasis::at_midpoints(int samples) const {
    std::vector<CubicBasisValues> table;
    for (int j = 0; j < samples; ++j) table.push_back(at((j + 0.5) / samples));
    return table;
}

}  // namespace atropos::tracker
