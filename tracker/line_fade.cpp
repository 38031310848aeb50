#include "tracker/line_fade.hpp"

#include <algorithm>
#include <array>

namespace atropos::tracker {
namespace {

constexpr std::ptrdiff_t kMost = 50, kBefore = 20;  // nodes

double usual_contrast(std::span<const LineNode> line, std::size_t eye) {
    std::array<double, kBefore> contrast{};
    std::transform(line.end() - kBefore, line.end(), contrast.begin(),
                   [&](const LineNode& node) { return node.contrast[eye]; });
    std::nth_element(contrast.begin(), contrast.begin() + kBefore / 2, contrast.end());
    return std::max(contrast[kBefore / 2], 1e-6);
}

}  // namespace

std::ptrdiff_t fainter_at_back(std::span<const LineNode> line, double share) {
    double most = 0.0;
    std::ptrdiff_t count = 0;
    for (std::ptrdiff_t k = 1; k <= kMost && k + kBefore <= std::ssize(line); ++k) {
        const std::span<const LineNode> before = line.first(line.size() - static_cast<std::size_t>(k));
        const double left = usual_contrast(before, 0), right = usual_contrast(before, 1);
        double below = 0.0;
        for (const LineNode& node : line.last(static_cast<std::size_t>(k)))
            below += share - 0.5 * (node.contrast[0] / left + node.contrast[1] / right);
        if (below <= most) continue;
        most = below;
        count = k;
    }
    return count;
}

}  // namespace atropos::tracker
