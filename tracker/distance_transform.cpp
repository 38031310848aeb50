#include "tracker/distance_transform.hpp"

#include <immintrin.h>

#include <algorithm>
#include <stdexcept>
#include <string>

namespace atropos::tracker {
namespace {

constexpr int kBlock = 32;  // pixels a block of the row pass: two vector registers

/// Least dx^2 + row[i + dx] of each of a block's pixels i, outwards from dx = 0 until no farther one can be
/// less.
void nearest_in_row(const std::uint16_t* row, int truncation, std::uint16_t* best) {
    const auto load = [](const std::uint16_t* from) {
        return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
    };
    __m256i first = load(row), second = load(row + 16);
    __m256i nearest = load(row + truncation + kBlock - 16);
    for (int x = -truncation; x < truncation + kBlock - 15; x += 16)
        nearest = _mm256_min_epu16(nearest, load(row + x));
    const __m256i far = _mm256_set1_epi16(static_cast<short>(truncation * truncation));
    if (_mm256_movemask_epi8(_mm256_cmpeq_epi16(nearest, far)) == -1) truncation = 0;  // no ridge in reach
    for (int dx = 1; dx < truncation; ++dx) {
        const __m256i add = _mm256_set1_epi16(static_cast<short>(dx * dx));
        // Is dx^2 >= all found so far (max(best, dx^2) == dx^2)? Squares stay below 2^16: compared unsigned.
        const __m256i largest = _mm256_max_epu16(_mm256_max_epu16(first, second), add);
        if (_mm256_movemask_epi8(_mm256_cmpeq_epi16(largest, add)) == -1) break;
        const auto nearer = [&](const std::uint16_t* at, __m256i found) {
            const __m256i either = _mm256_min_epu16(load(at - dx), load(at + dx));
            return _mm256_min_epu16(found, _mm256_add_epi16(either, add));
        };
        first = nearer(row, first);
        second = nearer(row + 16, second);
    }
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(best), first);
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(best + 16), second);
}

}  // namespace

void DistanceTransform::reserve(int width, int height, int truncation) {
    column_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    padded_.reserve(static_cast<std::size_t>(2 * truncation + width + 2 * kBlock));
}

void DistanceTransform::apply(const std::uint8_t* mask, int mask_stride, int width, int height,
                              int truncation, const cv::Rect& wanted, std::uint16_t* squared,
                              int squared_stride) {
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

    const int blocks = (wanted.width + kBlock - 1) / kBlock;
    const std::uint16_t far_squared = static_cast<std::uint16_t>(truncation * truncation);
    padded_.assign(static_cast<std::size_t>(2 * truncation + blocks * kBlock), far_squared);
    // What of the columns reaches the wanted pixels: [begin, end), written from `padded_`'s `shift` on.
    const int begin = std::max(0, wanted.x - truncation);
    const int end = std::min(width, wanted.br().x + truncation);
    const int shift = begin - (wanted.x - truncation);
    for (int y = 0; y < wanted.height; ++y) {
        const std::uint8_t* column = column_.data() + static_cast<std::size_t>(wanted.y + y) * w + begin;
        std::uint16_t* row = padded_.data() + shift;
        for (int x = 0; x < end - begin; ++x)
            row[x] = static_cast<std::uint16_t>(static_cast<std::uint16_t>(column[x]) * column[x]);
        std::uint16_t* out = squared + static_cast<std::ptrdiff_t>(y) * squared_stride;
        for (int block = 0; block < blocks; ++block) {
            const int x0 = block * kBlock;
            std::uint16_t best[kBlock];
            nearest_in_row(padded_.data() + truncation + x0, truncation, best);
            std::copy(best, best + std::min(kBlock, wanted.width - x0), out + x0);
        }
    }
}

}  // namespace atropos::tracker
