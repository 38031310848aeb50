#pragma once

#include <immintrin.h>

#include "tracker/energy.hpp"

namespace atropos::tracker {

/// Eight values of one vector quantity: the same sample under eight labellings.
struct Vector8 {
    __m256 x, y, z;

    static Vector8 all(const Eigen::Vector3d& v) {
        return {_mm256_set1_ps(static_cast<float>(v.x())), _mm256_set1_ps(static_cast<float>(v.y())),
                _mm256_set1_ps(static_cast<float>(v.z()))};
    }
    /// this + factor * (rows x, y, z of the labels from `l` on)
    Vector8 plus(__m256 factor, const float* rx, const float* ry, const float* rz) const {
        return {_mm256_add_ps(x, _mm256_mul_ps(factor, _mm256_loadu_ps(rx))),
                _mm256_add_ps(y, _mm256_mul_ps(factor, _mm256_loadu_ps(ry))),
                _mm256_add_ps(z, _mm256_mul_ps(factor, _mm256_loadu_ps(rz)))};
    }
    __m256 norm() const {
        return _mm256_sqrt_ps(
            _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(x, x), _mm256_mul_ps(y, y)), _mm256_mul_ps(z, z)));
    }
};

/// (1 - |C'| / |C'_ref|)^2, the integrand of eq. 7, 12 and 17.
inline __m256 squared_stretch(const Vector8& velocity, float reference_speed_m) {
    const __m256 stretch = _mm256_sub_ps(
        _mm256_set1_ps(1.0f), _mm256_mul_ps(velocity.norm(), _mm256_set1_ps(1.0f / reference_speed_m)));
    return _mm256_mul_ps(stretch, stretch);
}

/// Weight of a look-up in an eye: 1/2 alpha du of eq. 11 and 16, times the unit of the cost image.
inline float data_weight(const EnergyContext& context, std::size_t eye, double alpha) {
    return static_cast<float>(0.5 * alpha * context.sampling.du() * context.weights.px_scale) *
           context.costs[eye]->unit_px;
}

/// Weight of the length at a sample: lambda_1 alpha du of eq. 10 and 15.
inline float length_weight(const EnergyContext& context, double alpha) {
    return static_cast<float>(context.weights.length * alpha * context.sampling.du());
}

}  // namespace atropos::tracker
