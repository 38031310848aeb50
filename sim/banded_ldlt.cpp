#include "sim/banded_ldlt.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::sim {

using Eigen::Vector4d;

void BandedLdlt::reset(int rows) {
    rows_ = rows;
    Columns zero;
    for (Block& block : zero) block.fill(Vector4d::Zero());
    columns_.assign(static_cast<size_t>(rows / 3 + 2), zero);
    inverse_pivots_.assign(static_cast<size_t>(rows), 0.0);
}

void BandedLdlt::fix_node(int node) {
    for (Block& block : at(node)) block.fill(Vector4d::Zero());
    for (int k = 1; k <= 2 && k <= node; ++k) at(node - k)[static_cast<size_t>(k)].fill(Vector4d::Zero());
    for (int c = 0; c < 3; ++c) at(node)[0][static_cast<size_t>(c)][c] = 1.0;
}

bool BandedLdlt::factor() {
    const auto subtract_outer = [](Block& target, const Block& a, const Block& b) {
        for (size_t c = 0; c < 3; ++c)
            for (int column = 0; column < 3; ++column)
                target[static_cast<size_t>(column)] -= a[c][column] * b[c];
    };
    for (int node = 0; node < rows_ / 3; ++node) {
        auto& [own, next, second] = at(node);
        // Within the node's own three columns, one pivot after the other.
        std::array<double, 3> inverse{};
        for (size_t c = 0; c < 3; ++c) {
            const double pivot = own[c][static_cast<int>(c)];
            if (!(pivot > 0.0) || !std::isfinite(pivot)) return false;
            inverse[c] = 1.0 / pivot;
            inverse_pivots_[static_cast<size_t>(3 * node) + c] = inverse[c];
            for (size_t later = c + 1; later < 3; ++later) {
                const double l = own[c][static_cast<int>(later)] * inverse[c];
                own[later] -= l * own[c];
                next[later] -= l * next[c];
                second[later] -= l * second[c];
            }
        }
        // L of the node's columns, then what they take from the two nodes after it.
        Block next_l, second_l;
        for (size_t c = 0; c < 3; ++c) {
            next_l[c] = inverse[c] * next[c];
            second_l[c] = inverse[c] * second[c];
            own[c] *= inverse[c];
        }
        Columns& after = at(node + 1);
        subtract_outer(after[0], next_l, next);
        subtract_outer(after[1], next_l, second);
        subtract_outer(at(node + 2)[0], second_l, second);
        next = next_l;
        second = second_l;
    }
    return true;
}

template <int kCount>
void BandedLdlt::solve_panel(double* panel, int width, int first_row) const {
    using Lanes = Eigen::Array<double, kCount, 1>;
    const auto row = [&](int node, int r) {
        return Eigen::Map<Lanes>(panel + static_cast<std::ptrdiff_t>(3 * node + r) * width);
    };
    const int nodes = rows_ / 3;
    for (int node = first_row / 3; node < nodes; ++node) {
        const Columns& l = columns_[static_cast<size_t>(node)];
        const Lanes b0 = row(node, 0);
        const Lanes b1 = row(node, 1) - l[0][0][1] * b0;
        const Lanes b2 = row(node, 2) - l[0][0][2] * b0 - l[0][1][2] * b1;
        row(node, 1) = b1;
        row(node, 2) = b2;
        for (int k = 1; k < 3 && node + k < nodes; ++k) {
            const Block& block = l[static_cast<size_t>(k)];
            for (int r = 0; r < 3; ++r)
                row(node + k, r) -= block[0][r] * b0 + block[1][r] * b1 + block[2][r] * b2;
        }
    }
    for (int node = nodes - 1; node >= first_row / 3; --node) {
        const Columns& l = columns_[static_cast<size_t>(node)];
        const double* inverse = &inverse_pivots_[static_cast<size_t>(3 * node)];
        Lanes b[3];
        for (int c = 0; c < 3; ++c) b[c] = inverse[c] * row(node, c);
        for (int k = 1; k < 3 && node + k < nodes; ++k)
            for (int c = 0; c < 3; ++c) {
                const Vector4d& column = l[static_cast<size_t>(k)][static_cast<size_t>(c)];
                b[c] -= column[0] * row(node + k, 0) + column[1] * row(node + k, 1) +
                        column[2] * row(node + k, 2);
            }
        b[1] -= l[0][1][2] * b[2];
        b[0] -= l[0][0][1] * b[1] + l[0][0][2] * b[2];
        for (int c = 0; c < 3; ++c) row(node, c) = b[c];
    }
}

void BandedLdlt::solve(Eigen::VectorXd& b) const {
    solve_panel<1>(b.data(), 1, 0);
}

void BandedLdlt::solve(std::vector<double>& b, int width, int first_row) const {
    int start = 0;  // in panels: of a 140-edge thread one of 16 stays in the L2 cache
    for (; start + 16 <= width; start += 16) solve_panel<16>(b.data() + start, width, first_row);
    for (; start < width; start += 4) solve_panel<4>(b.data() + start, width, first_row);
}

}  // namespace atropos::sim
