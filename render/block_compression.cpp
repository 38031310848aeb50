#include "render/block_compression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace atropos::render {
namespace {

constexpr int kSide = 8;
constexpr int kBlock = kSide * kSide;
constexpr int kLanes =
    8;  // blocks worked on side by side, so that loops over them become vector instructions

using Block = std::array<std::array<float, kLanes>, kBlock>;
using Table = std::array<float, kBlock>;

// ITU-T T.81, tables K.1 and K.2.
constexpr std::array<int, kBlock> kLuminance = {
    16, 11,  10,  16, 24, 40, 51, 61, 12,  12,  14,  19,  26, 58, 60, 55,  14,  13,  16,  24, 40, 57,
    69, 56,  14,  17, 22, 29, 51, 87, 80,  62,  18,  22,  37, 56, 68, 109, 103, 77,  24,  35, 55, 64,
    81, 104, 113, 92, 49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98,  112, 100, 103, 99};
constexpr std::array<int, kBlock> kChrominance = {
    17, 18, 24, 47, 99, 99, 99, 99, 18, 21, 26, 66, 99, 99, 99, 99, 24, 26, 56, 99, 99, 99,
    99, 99, 47, 66, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99,
    99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99, 99};

Table quantisation(const std::array<int, kBlock>& base, int quality) {
    const int scale = quality < 50 ? 5000 / quality : 200 - 2 * quality;
    Table table{};
    for (std::size_t i = 0; i < base.size(); ++i)
        table[i] = static_cast<float>(std::clamp((base[i] * scale + 50) / 100, 1, 255));
    return table;
}

/// Orthonormal: row k is the k-th cosine.
Table cosines() {
    Table table{};
    for (int k = 0; k < kSide; ++k)
        for (int x = 0; x < kSide; ++x)
            table[static_cast<std::size_t>(k * kSide + x)] =
                static_cast<float>(std::sqrt((k == 0 ? 1.0 : 2.0) / kSide) *
                                   std::cos((2 * x + 1) * k * std::numbers::pi / (2 * kSide)));
    return table;
}

using Lanes = std::array<float, kLanes>;

Lanes combined(const Lanes& a, const Lanes& b, float sign) {
    Lanes out;
    for (std::size_t lane = 0; lane < kLanes; ++lane) out[lane] = a[lane] + sign * b[lane];
    return out;
}

/// Sum of four cosines of one parity times `in`; `at(k, x)` indexes the table.
template <class At>
Lanes product(const Table& cosine, const std::array<Lanes, 4>& in, int k, At at) {
    Lanes sum{};
    for (int x = 0; x < 4; ++x) {
        const float c = cosine[static_cast<std::size_t>(at(k, x))];
        for (std::size_t lane = 0; lane < kLanes; ++lane)
            sum[lane] += c * in[static_cast<std::size_t>(x)][lane];
    }
    return sum;
}

/// One cosine transform of eight values that lie `step` apart. Even cosines are symmetric and odd ones
/// antisymmetric about the middle: half of the products.
void forward(const Table& cosine, Block& block, int first, int step) {
    const auto at = [&](int i) -> Lanes& { return block[static_cast<std::size_t>(first + i * step)]; };
    std::array<Lanes, 4> sums, differences;
    for (int x = 0; x < 4; ++x) {
        sums[static_cast<std::size_t>(x)] = combined(at(x), at(7 - x), 1.0f);
        differences[static_cast<std::size_t>(x)] = combined(at(x), at(7 - x), -1.0f);
    }
    const auto index = [](int k, int x) { return k * kSide + x; };
    for (int k = 0; k < kSide; k += 2) {
        at(k) = product(cosine, sums, k, index);
        at(k + 1) = product(cosine, differences, k + 1, index);
    }
}

/// Undoes `forward`: the transpose.
void backward(const Table& cosine, Block& block, int first, int step) {
    const auto at = [&](int i) -> Lanes& { return block[static_cast<std::size_t>(first + i * step)]; };
    std::array<Lanes, 4> even, odd;
    for (int k = 0; k < 4; ++k) {
        even[static_cast<std::size_t>(k)] = at(2 * k);
        odd[static_cast<std::size_t>(k)] = at(2 * k + 1);
    }
    for (int x = 0; x < 4; ++x) {
        const Lanes a = product(cosine, even, x, [](int column, int k) { return 2 * k * kSide + column; });
        const Lanes b =
            product(cosine, odd, x, [](int column, int k) { return (2 * k + 1) * kSide + column; });
        at(x) = combined(a, b, 1.0f);
        at(7 - x) = combined(a, b, -1.0f);
    }
}

/// `plane`: CV_32F with sides that are multiples of 8, rows padded to a multiple of 8 blocks; in place.
void quantise(cv::Mat& plane, const Table& table, const Table& cosine) {
    Block a;
    for (int y = 0; y < plane.rows; y += kSide) {
        for (int x = 0; x < plane.cols; x += kSide * kLanes) {
            for (int j = 0; j < kSide; ++j) {
                const float* row = plane.ptr<float>(y + j) + x;
                for (int i = 0; i < kSide; ++i)
                    for (int lane = 0; lane < kLanes; ++lane)
                        a[static_cast<std::size_t>(j * kSide + i)][static_cast<std::size_t>(lane)] =
                            row[lane * kSide + i];
            }
            for (int line = 0; line < kSide; ++line) forward(cosine, a, line * kSide, 1);
            for (int line = 0; line < kSide; ++line) forward(cosine, a, line, kSide);
            for (std::size_t i = 0; i < kBlock; ++i)
                for (float& value : a[i]) value = table[i] * std::nearbyint(value / table[i]);
            for (int line = 0; line < kSide; ++line) backward(cosine, a, line * kSide, 1);
            for (int line = 0; line < kSide; ++line) backward(cosine, a, line, kSide);
            for (int j = 0; j < kSide; ++j) {
                float* row = plane.ptr<float>(y + j) + x;
                for (int i = 0; i < kSide; ++i)
                    for (int lane = 0; lane < kLanes; ++lane)
                        row[lane * kSide + i] =
                            a[static_cast<std::size_t>(j * kSide + i)][static_cast<std::size_t>(lane)];
            }
        }
    }
}

int padded(int size, int multiple) {
    return (size + multiple - 1) / multiple * multiple;
}

struct Planes {
    cv::Mat y, cb, cr;  // CV_32F about 0, borders repeated; chroma at half size
};

/// ITU-R BT.601 in full range, as JFIF has it: whole numbers. Bytes may alias anything: without `__restrict`
/// no vector instructions.
void to_jfif(const std::uint8_t* __restrict bgr, int count, float* __restrict y, float* __restrict cb,
             float* __restrict cr) {
    for (int i = 0; i < count; ++i) {
        const float b = bgr[3 * i], g = bgr[3 * i + 1], r = bgr[3 * i + 2];
        y[i] = std::nearbyint(0.299f * r + 0.587f * g + 0.114f * b) - 128.0f;
        cb[i] = std::nearbyint(0.5f * b - 0.168736f * r - 0.331264f * g);
        cr[i] = std::nearbyint(0.5f * r - 0.418688f * g - 0.081312f * b);
    }
}

Planes to_planes(const cv::Mat& picture) {
    constexpr int kWide = 2 * kSide * kLanes, kHigh = 2 * kSide;
    const int width = padded(picture.cols, kWide), height = padded(picture.rows, kHigh);
    Planes p{cv::Mat(height, width, CV_32F), cv::Mat::zeros(height / 2, width / 2, CV_32F),
             cv::Mat::zeros(height / 2, width / 2, CV_32F)};
    std::vector<float> blue(static_cast<std::size_t>(width)), red(blue.size());
    std::vector<std::uint8_t> row(3 * blue.size());
    for (int j = 0; j < height; ++j) {
        const auto* in = picture.ptr<std::uint8_t>(std::min(j, picture.rows - 1));
        float *cb = p.cb.ptr<float>(j / 2), *cr = p.cr.ptr<float>(j / 2);
        std::copy_n(in, 3 * picture.cols, row.begin());
        for (std::size_t i = 3 * static_cast<std::size_t>(picture.cols); i < row.size(); ++i)
            row[i] = row[i - 3];
        to_jfif(row.data(), width, p.y.ptr<float>(j), blue.data(), red.data());
        for (int i = 0; i < width / 2; ++i) {
            const auto k = static_cast<std::size_t>(2 * i);
            cb[i] += 0.25f * (blue[k] + blue[k + 1]);
            cr[i] += 0.25f * (red[k] + red[k + 1]);
            if (j % 2 == 1) {
                cb[i] = std::nearbyint(cb[i]);
                cr[i] = std::nearbyint(cr[i]);
            }
        }
    }
    return p;
}

/// Row `j` of a plane at twice its size: three parts of the nearer sample, one of the farther, in both
/// directions.
void enlarge(const cv::Mat& plane, int j, std::vector<float>& between, std::vector<float>& out) {
    const float* near = plane.ptr<float>(j / 2);
    const float* far = plane.ptr<float>(std::clamp(j / 2 + (j % 2 == 0 ? -1 : 1), 0, plane.rows - 1));
    const auto n = static_cast<std::size_t>(plane.cols);
    for (std::size_t i = 0; i < n; ++i) between[i] = 0.75f * near[i] + 0.25f * far[i];
    out[0] = between[0];
    out[2 * n - 1] = between[n - 1];
    for (std::size_t i = 0; i + 1 < n; ++i) {
        out[2 * i + 1] = 0.75f * between[i] + 0.25f * between[i + 1];
        out[2 * i + 2] = 0.25f * between[i] + 0.75f * between[i + 1];
    }
}

std::uint8_t byte(float value) {
    return static_cast<std::uint8_t>(std::min(std::max(value, 0.0f), 255.0f) + 0.5f);
}

void to_bgr(const float* __restrict y, const float* __restrict cb, const float* __restrict cr, int count,
            std::uint8_t* __restrict bgr) {
    for (int i = 0; i < count; ++i) {
        const float luma = y[i] + 128.0f;
        bgr[3 * i] = byte(luma + 1.772f * cb[i]);
        bgr[3 * i + 1] = byte(luma - 0.344136f * cb[i] - 0.714136f * cr[i]);
        bgr[3 * i + 2] = byte(luma + 1.402f * cr[i]);
    }
}

cv::Mat to_picture(const Planes& p, cv::Size size) {
    cv::Mat picture(size, CV_8UC3);
    const auto width = static_cast<std::size_t>(p.y.cols);
    std::vector<float> between(width / 2), cb(width), cr(width);
    for (int j = 0; j < size.height; ++j) {
        enlarge(p.cb, j, between, cb);
        enlarge(p.cr, j, between, cr);
        to_bgr(p.y.ptr<float>(j), cb.data(), cr.data(), size.width, picture.ptr<std::uint8_t>(j));
    }
    return picture;
}

}  // namespace

cv::Mat compressed(const cv::Mat& picture, int quality) {
    if (picture.type() != CV_8UC3 || picture.empty() || quality < 1 || quality > 100)
        throw std::invalid_argument("can't compress, expected a colour picture and a quality of 1 to 100");
    static const Table cosine = cosines();
    Planes planes = to_planes(picture);
    const Table luminance = quantisation(kLuminance, quality),
                chrominance = quantisation(kChrominance, quality);
    quantise(planes.y, luminance, cosine);
    quantise(planes.cb, chrominance, cosine);
    quantise(planes.cr, chrominance, cosine);
    return to_picture(planes, picture.size());
}

}  // namespace atropos::render
