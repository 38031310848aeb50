#include "tracker/potentials.hpp"
#include "tracker/sample_batch.hpp"

namespace atropos::tracker {
namespace {

/// V^2a (eq. 16) + lambda_1 V^2b (eq. 17) of the pair p, q = p + 1, summed over the samples that both move.
template <bool kDistorted>
void fill_pair(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
               const NodeLabels& labels, int p, std::span<float> table) {
    const CurveSampling& sampling = context.sampling;
    const int q = p + 1;
    const CurveSampling::Range range = sampling.pair_support(p);
    for (int j = range.first; j < range.last; ++j) {
        const double alpha = sampling.alpha_pair(p, j);  // eq. 18
        const Eigen::Vector3d p_C = sampling.point(control_points, j);
        const Eigen::Vector3d velocity = sampling.velocity(control_points, j);
        const std::array<Eigen::Vector3d, 2> seen = {context.eyes[0].homogeneous(p_C),
                                                     context.eyes[1].homogeneous(p_C)};
        const __m256 R_q = _mm256_set1_ps(static_cast<float>(sampling.R(q, j)));
        const __m256 dR_q = _mm256_set1_ps(static_cast<float>(sampling.dR(q, j)));
        const __m256 w_length = _mm256_set1_ps(length_weight(context, alpha));
        const __m256 w_data[2] = {_mm256_set1_ps(data_weight(context, 0, alpha)),
                                  _mm256_set1_ps(data_weight(context, 1, alpha))};
        const float speed = static_cast<float>(context.reference_speed_m[static_cast<std::size_t>(j)]);
        for (int lp = 0; lp < labels.labels(); ++lp) {
            const Eigen::Vector3d l = labels.displacement(p, lp);
            const Vector8 velocity_p = Vector8::all(velocity + sampling.dR(p, j) * l);
            const std::array<Vector8, 2> seen_p = {
                Vector8::all(seen[0] + sampling.R(p, j) * (context.eyes[0].M() * l)),
                Vector8::all(seen[1] + sampling.R(p, j) * (context.eyes[1].M() * l))};
            float* row = table.data() + static_cast<std::ptrdiff_t>(lp) * labels.stride();
            for (int lq = 0; lq < labels.stride(); lq += 8) {
                const auto moved = [&](const Vector8& base, __m256 factor, int channel) {
                    return base.plus(factor, labels.row(q, channel) + lq, labels.row(q, channel + 1) + lq,
                                     labels.row(q, channel + 2) + lq);
                };
                __m256 sum = _mm256_mul_ps(w_length, squared_stretch(moved(velocity_p, dR_q, 0), speed));
                for (std::size_t eye = 0; eye < 2; ++eye) {
                    const Vector8 h = moved(seen_p[eye], R_q, 3 + 3 * static_cast<int>(eye));
                    const __m256 cost =
                        context.eyes[eye].look_up<kDistorted>(*context.costs[eye], h.x, h.y, h.z);
                    sum = _mm256_add_ps(sum, _mm256_mul_ps(w_data[eye], cost));
                }
                _mm256_storeu_ps(row + lq, _mm256_add_ps(_mm256_loadu_ps(row + lq), sum));
            }
        }
    }
}

}  // namespace

void PotentialsE2::fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                        const NodeLabels& labels, WorkerPool& pool, ChainProblem& chain) {
    chain.clear();
    const bool distorted = context.eyes[0].is_distorted();
    pool.run(chain.nodes() - 1, [&](int p) {
        if (distorted)
            fill_pair<true>(context, control_points, labels, p, chain.pairwise(p));
        else
            fill_pair<false>(context, control_points, labels, p, chain.pairwise(p));
    });
    add_tip_costs(context, control_points, labels, chain);
}

}  // namespace atropos::tracker
