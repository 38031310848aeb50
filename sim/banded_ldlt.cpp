#include "sim/banded_ldlt.hpp"

#include <algorithm>
#include <cmath>

namespace atropos::sim {

void BandedLdlt::reset(int rows) {
    rows_ = rows;
    columns_.assign(static_cast<size_t>((rows + kHalfBandwidth) * kStride), 0.0);
    inverse_pivots_.assign(static_cast<size_t>(rows), 0.0);
}

void BandedLdlt::fix_node(int node) {
    for (int j = 3 * node; j < 3 * node + 3; ++j) {
        double* column = &columns_[static_cast<size_t>(j * kStride)];
        std::fill(column, column + kHalfBandwidth + 1, 0.0);
        for (int k = 1; k <= kHalfBandwidth && k <= j; ++k)
            columns_[static_cast<size_t>((j - k) * kStride + k)] = 0.0;
        column[0] = 1.0;
    }
}

bool BandedLdlt::factor() {
    for (int j = 0; j < rows_; ++j) {
        double* column = &columns_[static_cast<size_t>(j * kStride)];
        if (!(column[0] > 0.0) || !std::isfinite(column[0])) return false;
        const double inverse = 1.0 / column[0];
        inverse_pivots_[static_cast<size_t>(j)] = inverse;
        for (int m = 1; m <= kHalfBandwidth; ++m) {
            const double l = column[m] * inverse;
            double* target = column + m * kStride;
            for (int k = 0; k < kHalfBandwidth; ++k) target[k] -= l * column[m + k];
        }
        for (int m = 1; m <= kHalfBandwidth; ++m) column[m] *= inverse;
    }
    return true;
}

void BandedLdlt::solve(Eigen::VectorXd& b) const {
    const int last = rows_ - 1;
    for (int j = 0; j < rows_; ++j) {
        const double* column = &columns_[static_cast<size_t>(j * kStride)];
        const int reach = std::min(kHalfBandwidth, last - j);
        for (int k = 1; k <= reach; ++k) b[j + k] -= column[k] * b[j];
    }
    for (int j = last; j >= 0; --j) {
        const double* column = &columns_[static_cast<size_t>(j * kStride)];
        const int reach = std::min(kHalfBandwidth, last - j);
        double sum = b[j] * inverse_pivots_[static_cast<size_t>(j)];
        for (int k = 1; k <= reach; ++k) sum -= column[k] * b[j + k];
        b[j] = sum;
    }
}

namespace {

constexpr int kPanel = 16;  // columns solved together: one panel of a 140-edge thread stays in the L2 cache

}  // namespace

void BandedLdlt::solve(std::vector<double>& b, int width, int first_row) const {
    const int last = rows_ - 1;
    for (int start = 0; start < width; start += kPanel) {
        const int count = std::min(kPanel, width - start);
        double* panel = b.data() + start;
        const auto row = [&](int j) { return panel + static_cast<std::ptrdiff_t>(j) * width; };
        const auto subtract = [count](double* __restrict to, const double* __restrict from, double factor) {
            if (count == kPanel)
                for (int c = 0; c < kPanel; ++c) to[c] -= factor * from[c];
            else
                for (int c = 0; c < count; ++c) to[c] -= factor * from[c];
        };
        for (int j = first_row; j < rows_; ++j) {
            const double* column = &columns_[static_cast<size_t>(j * kStride)];
            const int reach = std::min(kHalfBandwidth, last - j);
            for (int k = 1; k <= reach; ++k) subtract(row(j + k), row(j), column[k]);
        }
        for (int j = last; j >= first_row; --j) {
            const double* column = &columns_[static_cast<size_t>(j * kStride)];
            double* to = row(j);
            const double inverse = inverse_pivots_[static_cast<size_t>(j)];
            for (int c = 0; c < count; ++c) to[c] *= inverse;
            const int reach = std::min(kHalfBandwidth, last - j);
            for (int k = 1; k <= reach; ++k) subtract(to, row(j + k), column[k]);
        }
    }
}

}  // namespace atropos::sim
