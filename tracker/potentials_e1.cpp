#include "tracker/potentials.hpp"
#include "tracker/sample_batch.hpp"

namespace atropos::tracker {
namespace {

/// V^1a (eq. 11) + lambda_1 V^1b (eq. 12) of node p, summed over the samples it moves.
template <bool kDistorted>
void fill_node(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
               const NodeLabels& labels, int p, std::span<float> unary) {
    const CurveSampling& sampling = context.sampling;
    const CurveSampling::Range range = sampling.support(p);
    for (int j = range.first; j < range.last; ++j) {
        const double alpha = sampling.alpha(p, j);  // eq. 14
        const Vector8 velocity = Vector8::all(sampling.velocity(control_points, j));
        const std::array<Vector8, 2> seen = {Vector8::all(context.seen(0, control_points, j)),
                                             Vector8::all(context.seen(1, control_points, j))};
        const __m256 R = _mm256_set1_ps(static_cast<float>(sampling.R(p, j)));
        const __m256 dR = _mm256_set1_ps(static_cast<float>(sampling.dR(p, j)));
        const __m256 w_length = _mm256_set1_ps(length_weight(context, alpha));
        const float speed = static_cast<float>(context.reference_speed_m[static_cast<std::size_t>(j)]);
        for (int l = 0; l < labels.stride(); l += 8) {
            const auto moved = [&](const Vector8& base, __m256 factor, int channel) {
                return base.plus(factor, labels.row(p, channel) + l, labels.row(p, channel + 1) + l,
                                 labels.row(p, channel + 2) + l);
            };
            __m256 sum = _mm256_mul_ps(w_length, squared_stretch(moved(velocity, dR, 0), speed));
            for (std::size_t eye = 0; eye < 2; ++eye) {
                const Vector8 h = moved(seen[eye], R, 3 + 3 * static_cast<int>(eye));
                const __m256 cost = context.eyes[eye].look_up<kDistorted>(*context.costs[eye], h.x, h.y, h.z);
                sum =
                    _mm256_add_ps(sum, _mm256_mul_ps(_mm256_set1_ps(data_weight(context, eye, alpha)), cost));
            }
            float* out = unary.data() + l;
            _mm256_storeu_ps(out, _mm256_add_ps(_mm256_loadu_ps(out), sum));
        }
    }
}

/// lambda_2 V^1c (eq. 13).
void fill_smoothness(const NodeLabels& labels, int p, double weight_per_m, int stride,
                     std::span<float> table) {
    for (int l = 0; l < labels.labels(); ++l)
        for (int m = 0; m < labels.labels(); ++m)
            table[static_cast<std::size_t>(l * stride + m)] = static_cast<float>(
                weight_per_m * (labels.displacement(p, l) - labels.displacement(p + 1, m)).norm());
}

}  // namespace

void PotentialsE1::fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                        const NodeLabels& labels, scenes::WorkerPool& pool, ChainProblem& chain) {
    chain.clear();
    const bool distorted = context.eyes[0].is_distorted();
    pool.run(chain.nodes(), [&](int p) {
        if (distorted)
            fill_node<true>(context, control_points, labels, p, chain.unary(p));
        else
            fill_node<false>(context, control_points, labels, p, chain.unary(p));
        if (p + 1 < chain.nodes())
            fill_smoothness(labels, p, context.weights.smooth_per_m, chain.stride(), chain.pairwise(p));
    });
    add_node_costs(context, control_points, labels, chain);
}

}  // namespace atropos::tracker
