#pragma once

#include <immintrin.h>

#include <Eigen/Geometry>
#include <array>

#include "scenes/stereo_rig.hpp"
#include "tracker/cost_image.hpp"

namespace atropos::tracker {

/// One camera as the potentials need it: a point p of C has homogeneous image coordinates M p + m, in pixels,
/// or normalised when the lens distorts, in which case `look_up` distorts every sample exactly. The sum over
/// control points commutes with M, which is eq. 3: a label's displacement l moves a sample by N_k(u) M l.
class Eye {
  public:
    /// `distorted`: whether to distort samples; needed when the camera's lens does.
    Eye(const scenes::Camera& camera, const Eigen::Isometry3d& X_EC, bool distorted);

    const Eigen::Matrix3d& M() const { return M_; }
    Eigen::Vector3d homogeneous(const Eigen::Vector3d& p_C) const { return M_ * p_C + m_; }
    const Eigen::Vector3d& m() const { return m_; }
    bool is_distorted() const { return distorted_; }

    /// Pixel of homogeneous coordinates with depth at least `kNearest`.
    Eigen::Vector2d pixel(const Eigen::Vector3d& homogeneous) const;

    /// Cost, in steps of the image's unit, at eight homogeneous points.
    template <bool kDistorted>
    __m256 look_up(const CostImage& image, __m256 x, __m256 y, __m256 z) const;

    /// Points nearer than this (m) are looked up as if they were this far: labels may reach behind the
    /// camera.
    static constexpr double kNearest = 1e-3;

  private:
    scenes::Camera camera_;
    Eigen::Matrix3d M_;
    Eigen::Vector3d m_;
    bool distorted_;
    std::array<float, 8> k_;  ///< k1 k2 p1 p2 k3 k4 k5 k6
    float fx_, fy_, cx_, cy_;
};

/// Left and right camera of a rig; both distort when one of them does.
std::array<Eye, 2> make_eyes(const scenes::StereoRig& rig);

/// Whether both see every point in the same row and at the same depth: parallel, without distortion.
bool rows_agree(const std::array<Eye, 2>& eyes);

/// Where a coordinate falls between pixel centres: the one before it, and the share of the way to the next.
struct Between {
    __m256i pixel;
    __m256 share;

    /// Clamped to [-1, size]; the operand order of min and max makes NaN the border.
    static Between of(__m256 coordinate, int size) {
        const __m256 x = _mm256_min_ps(_mm256_max_ps(coordinate, _mm256_set1_ps(-1.0f)),
                                       _mm256_set1_ps(static_cast<float>(size)));
        const __m256 before = _mm256_floor_ps(x);
        return {_mm256_cvttps_epi32(before), _mm256_sub_ps(x, before)};
    }
};

/// Bilinear cost at eight places, in steps of the image's unit; `row_offset` = row times stride.
inline __m256 bilinear(const CostImage& image, const Between& x, __m256i row_offset, __m256 y_share) {
    const __m256i four = _mm256_i32gather_epi32(reinterpret_cast<const int*>(image.row(0)),
                                                _mm256_add_epi32(row_offset, x.pixel), 2);
    const __m256i byte = _mm256_set1_epi32(255);
    const auto value = [](__m256i word) { return _mm256_cvtepi32_ps(word); };
    const __m256 here = value(_mm256_and_si256(four, byte));
    const __m256 below = value(_mm256_and_si256(_mm256_srli_epi32(four, 8), byte));
    const __m256 right = value(_mm256_and_si256(_mm256_srli_epi32(four, 16), byte));
    const __m256 across = value(_mm256_srli_epi32(four, 24));
    const __m256 above = _mm256_add_ps(here, _mm256_mul_ps(x.share, _mm256_sub_ps(right, here)));
    const __m256 under = _mm256_add_ps(below, _mm256_mul_ps(x.share, _mm256_sub_ps(across, below)));
    return _mm256_add_ps(above, _mm256_mul_ps(y_share, _mm256_sub_ps(under, above)));
}

/// The same at eight pixels (u, v), clamped to the border.
inline __m256 bilinear(const CostImage& image, __m256 u, __m256 v) {
    const Between y = Between::of(v, image.height);
    return bilinear(image, Between::of(u, image.width),
                    _mm256_mullo_epi32(y.pixel, _mm256_set1_epi32(image.stride)), y.share);
}

/// 1 / z of points no nearer than `Eye::kNearest`.
inline __m256 inverse_depth(__m256 z) {
    return _mm256_div_ps(_mm256_set1_ps(1.0f), _mm256_max_ps(z, _mm256_set1_ps(float(Eye::kNearest))));
}

template <bool kDistorted>
__m256 Eye::look_up(const CostImage& image, __m256 x, __m256 y, __m256 z) const {
    const __m256 inverse = inverse_depth(z);
    __m256 u = _mm256_mul_ps(x, inverse);
    __m256 v = _mm256_mul_ps(y, inverse);
    if constexpr (kDistorted) {  // OpenCV's rational model, as scenes::Camera::distort
        const auto set = [](float value) { return _mm256_set1_ps(value); };
        const auto fma = [](__m256 a, __m256 b, __m256 c) { return _mm256_add_ps(_mm256_mul_ps(a, b), c); };
        const __m256 one = set(1.0f);
        const __m256 uu = _mm256_mul_ps(u, u);
        const __m256 vv = _mm256_mul_ps(v, v);
        const __m256 uv2 = _mm256_mul_ps(set(2.0f), _mm256_mul_ps(u, v));
        const __m256 r2 = _mm256_add_ps(uu, vv);
        const __m256 up = fma(r2, fma(r2, fma(r2, set(k_[4]), set(k_[1])), set(k_[0])), one);
        const __m256 down = fma(r2, fma(r2, fma(r2, set(k_[7]), set(k_[6])), set(k_[5])), one);
        const __m256 radial = _mm256_div_ps(up, down);
        const __m256 ud =
            fma(u, radial, fma(set(k_[2]), uv2, _mm256_mul_ps(set(k_[3]), fma(set(2.0f), uu, r2))));
        const __m256 vd =
            fma(v, radial, fma(set(k_[3]), uv2, _mm256_mul_ps(set(k_[2]), fma(set(2.0f), vv, r2))));
        u = fma(ud, set(fx_), set(cx_));
        v = fma(vd, set(fy_), set(cy_));
    }
    return bilinear(image, u, v);
}

}  // namespace atropos::tracker
