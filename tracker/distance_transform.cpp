#include "tracker/distance_transform.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

namespace atropos::tracker {
namespace {

constexpr int kBlock = 32;  // pixels a block of the row pass: two vector registers

}  // namespace

void DistanceTransform::reserve(int width, int height, int truncation) {
    column_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    padded_.reserve(static_cast<std::size_t>(2 * truncation + width + 2 * kBlock));
}

void DistanceTransform::apply(const std::uint8_t* mask, int mask_stride, int width, int height,
                              int truncation, std::uint16_t* squared, int squared_stride) {
    if (truncation < 1 || truncation > kMaxTruncation)
        throw std::invalid_argument("a distance truncated at " + std::to_string(truncation) +
                                    " px, expected 1 to " + std::to_string(kMaxTruncation));
    const std::uint8_t far = static_cast<std::uint8_t>(truncation);
    const std::size_t w = static_cast<std::size_t>(width);
    column_.resize(w * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
        const std::uint8_t* m = mask + static_cast<std::ptrdiff_t>(y) * mask_stride;
        std::uint8_t* here = column_.data() + static_cast<std::size_t>(y) * w;
        const std::uint8_t* above = y > 0 ? here - w : nullptr;
        for (std::size_t x = 0; x < w; ++x) {
            const std::uint8_t next =
                above ? std::min<std::uint8_t>(static_cast<std::uint8_t>(above[x] + 1), far) : far;
            here[x] = m[x] ? std::uint8_t{0} : next;
        }
    }
    for (int y = height - 2; y >= 0; --y) {
        std::uint8_t* here = column_.data() + static_cast<std::size_t>(y) * w;
        const std::uint8_t* below = here + w;
        for (std::size_t x = 0; x < w; ++x)
            here[x] = std::min<std::uint8_t>(here[x], static_cast<std::uint8_t>(below[x] + 1));
    }

    const int blocks = (width + kBlock - 1) / kBlock;
    const std::uint16_t far_squared = static_cast<std::uint16_t>(truncation * truncation);
    padded_.assign(static_cast<std::size_t>(2 * truncation + blocks * kBlock), far_squared);
    for (int y = 0; y < height; ++y) {
        const std::uint8_t* column = column_.data() + static_cast<std::size_t>(y) * w;
        std::uint16_t* row = padded_.data() + truncation;
        for (std::size_t x = 0; x < w; ++x)
            row[x] = static_cast<std::uint16_t>(static_cast<std::uint16_t>(column[x]) * column[x]);
        std::uint16_t* out = squared + static_cast<std::ptrdiff_t>(y) * squared_stride;
        for (int block = 0; block < blocks; ++block) {
            const int x0 = block * kBlock;
            const int count = std::min(kBlock, width - x0);
            std::uint16_t best[kBlock];
            std::fill(best, best + kBlock, far_squared);
            for (int dx = -truncation + 1; dx < truncation; ++dx) {
                const std::uint16_t add = static_cast<std::uint16_t>(dx * dx);
                const std::uint16_t* from = row + x0 + dx;
                for (int i = 0; i < kBlock; ++i)
                    best[i] = std::min<std::uint16_t>(best[i], static_cast<std::uint16_t>(from[i] + add));
            }
            std::copy(best, best + count, out + x0);
        }
    }
}

}  // namespace atropos::tracker
