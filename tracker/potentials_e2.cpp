#include "tracker/potentials.hpp"
#include "tracker/sample_batch.hpp"

namespace atropos::tracker {
namespace {

/// How the eyes see: kParallel shares row and depth between them, kDistorted bends every sample.
enum class Sight { kParallel, kPinhole, kDistorted };

/// The cost of both eyes at eight homogeneous points each, weighted.
template <Sight kSight>
__m256 data_cost(const EnergyContext& context, const __m256* w, const std::array<Vector8, 2>& h) {
    if constexpr (kSight == Sight::kParallel) {
        const CostImage &left = *context.costs[0], &right = *context.costs[1];
        const __m256 inverse = inverse_depth(h[0].z);
        const Between y = Between::of(_mm256_mul_ps(h[0].y, inverse), left.height);
        const __m256i row = _mm256_mullo_epi32(y.pixel, _mm256_set1_epi32(left.stride));
        const Between x_left = Between::of(_mm256_mul_ps(h[0].x, inverse), left.width);
        const Between x_right = Between::of(_mm256_mul_ps(h[1].x, inverse), right.width);
        return _mm256_add_ps(_mm256_mul_ps(w[0], bilinear(left, x_left, row, y.share)),
                             _mm256_mul_ps(w[1], bilinear(right, x_right, row, y.share)));
    } else {
        constexpr bool kDistorted = kSight == Sight::kDistorted;
        const __m256 left = context.eyes[0].look_up<kDistorted>(*context.costs[0], h[0].x, h[0].y, h[0].z);
        const __m256 right = context.eyes[1].look_up<kDistorted>(*context.costs[1], h[1].x, h[1].y, h[1].z);
        return _mm256_add_ps(_mm256_mul_ps(w[0], left), _mm256_mul_ps(w[1], right));
    }
}

/// What the labels of a node add at one sample, all channels (NodeLabels::row) times R or R'.
class ScaledLabels {
  public:
    void set(const NodeLabels& labels, int node, double R, double dR) {
        for (int channel = 0; channel < kChannels; ++channel) {
            const float factor = static_cast<float>(channel < 3 ? dR : R);
            const float* from = labels.row(node, channel);
            for (std::size_t l = 0; l < static_cast<std::size_t>(labels.stride()); ++l)
                rows_[static_cast<std::size_t>(channel)][l] = factor * from[l];
        }
    }
    /// base + the displacements of labels l to l + 7 in channels `channel` to `channel` + 2.
    Vector8 moved(const Vector8& base, std::size_t channel, int l) const {
        return {_mm256_add_ps(base.x, _mm256_load_ps(rows_[channel] + l)),
                _mm256_add_ps(base.y, _mm256_load_ps(rows_[channel + 1] + l)),
                _mm256_add_ps(base.z, _mm256_load_ps(rows_[channel + 2] + l))};
    }

  private:
    static constexpr int kChannels = 9;
    alignas(32) float rows_[kChannels][NodeLabels::kMost];
};

/// V^2a (eq. 16) + lambda_1 V^2b (eq. 17) of the pair p, q = p + 1, summed over the samples that both move.
template <Sight kSight>
void fill_pair(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
               const NodeLabels& labels, int p, std::span<float> table) {
    const CurveSampling& sampling = context.sampling;
    const int q = p + 1;
    const CurveSampling::Range range = sampling.pair_support(p);
    ScaledLabels scaled;
    for (int j = range.first; j < range.last; ++j) {
        const double alpha = sampling.alpha_pair(p, j);  // eq. 18
        const Eigen::Vector3d velocity = sampling.velocity(control_points, j);
        const std::array<Eigen::Vector3d, 2> seen = {context.seen(0, control_points, j),
                                                     context.seen(1, control_points, j)};
        scaled.set(labels, q, sampling.R(q, j), sampling.dR(q, j));
        const __m256 w_length = _mm256_set1_ps(length_weight(context, alpha));
        const __m256 w_data[2] = {_mm256_set1_ps(data_weight(context, 0, alpha)),
                                  _mm256_set1_ps(data_weight(context, 1, alpha))};
        const float speed = static_cast<float>(context.reference_speed_m[static_cast<std::size_t>(j)]);
        for (int lp = 0; lp < labels.labels(); ++lp) {
            const Eigen::Vector3d l = labels.displacement(p, lp);
            const Vector8 velocity_p = Vector8::all(velocity + sampling.dR(p, j) * l);
            const std::array<Vector8, 2> seen_p = {
                Vector8::all(seen[0] + sampling.R(p, j) * labels.seen(p, lp, 0)),
                Vector8::all(seen[1] + sampling.R(p, j) * labels.seen(p, lp, 1))};
            float* row = table.data() + static_cast<std::ptrdiff_t>(lp) * labels.stride();
            for (int lq = 0; lq < labels.stride(); lq += 8) {
                const __m256 stretch = squared_stretch(scaled.moved(velocity_p, 0, lq), speed);
                const std::array<Vector8, 2> h = {scaled.moved(seen_p[0], 3, lq),
                                                  scaled.moved(seen_p[1], 6, lq)};
                const __m256 cost =
                    _mm256_add_ps(_mm256_mul_ps(w_length, stretch), data_cost<kSight>(context, w_data, h));
                _mm256_storeu_ps(row + lq, _mm256_add_ps(_mm256_loadu_ps(row + lq), cost));
            }
        }
    }
}

}  // namespace

void PotentialsE2::fill(const EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                        const NodeLabels& labels, scenes::WorkerPool& pool, ChainProblem& chain) {
    chain.clear();
    const auto fill = context.eyes[0].is_distorted()                      ? fill_pair<Sight::kDistorted>
                      : !context.image_points && rows_agree(context.eyes) ? fill_pair<Sight::kParallel>
                                                                          : fill_pair<Sight::kPinhole>;
    pool.run(chain.nodes() - 1, [&](int p) { fill(context, control_points, labels, p, chain.pairwise(p)); });
    add_node_costs(context, control_points, labels, chain);
}

}  // namespace atropos::tracker
