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

/// Bilinear cost at eight pixels (u, v), in steps of the image's unit; clamped to the border.
inline __m256 bilinear(const CostImage& image, __m256 u, __m256 v) {
    // The operand order of min and max makes NaN the border.
    const __m256 x = _mm256_min_ps(_mm256_max_ps(u, _mm256_set1_ps(-1.0f)),
                                   _mm256_set1_ps(static_cast<float>(image.width)));
    const __m256 y = _mm256_min_ps(_mm256_max_ps(v, _mm256_set1_ps(-1.0f)),
                                   _mm256_set1_ps(static_cast<float>(image.height)));
    const __m256 x_floor = _mm256_floor_ps(x);
    const __m256 y_floor = _mm256_floor_ps(y);
    const __m256 tx = _mm256_sub_ps(x, x_floor);
    const __m256 ty = _mm256_sub_ps(y, y_floor);
    const __m256i index =
        _mm256_add_epi32(_mm256_mullo_epi32(_mm256_cvttps_epi32(y_floor), _mm256_set1_epi32(image.stride)),
                         _mm256_cvttps_epi32(x_floor));
    const __m256i top = _mm256_i32gather_epi32(reinterpret_cast<const int*>(image.origin()), index, 1);
    const __m256i low =
        _mm256_i32gather_epi32(reinterpret_cast<const int*>(image.origin() + image.stride), index, 1);
    const __m256i byte = _mm256_set1_epi32(255);
    const auto along_row = [&](__m256i four) {
        const __m256 first = _mm256_cvtepi32_ps(_mm256_and_si256(four, byte));
        const __m256 second = _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(four, 8), byte));
        return _mm256_add_ps(first, _mm256_mul_ps(tx, _mm256_sub_ps(second, first)));
    };
    const __m256 above = along_row(top);
    return _mm256_add_ps(above, _mm256_mul_ps(ty, _mm256_sub_ps(along_row(low), above)));
}

template <bool kDistorted>
__m256 Eye::look_up(const CostImage& image, __m256 x, __m256 y, __m256 z) const {
    const __m256 inverse =
        _mm256_div_ps(_mm256_set1_ps(1.0f), _mm256_max_ps(z, _mm256_set1_ps(float(kNearest))));
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
