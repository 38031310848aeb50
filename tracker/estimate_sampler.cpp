#include "tracker/estimate_sampler.hpp"

namespace atropos::tracker {
namespace {

constexpr int kDense = 601;  // chords between them are shorter than their arcs by less than 1e-5

}  // namespace

EstimateSampler::EstimateSampler(int degree, int control_points)
    : table_(BasisTable::at_steps(BsplineBasis(degree, control_points), kDense)),
      dense_(kDense),
      arc_m_(kDense, 0.0) {}

void EstimateSampler::sample(std::span<const Eigen::Vector3d> control_points,
                             std::vector<scenes::ThreadSample>& samples) {
    for (std::size_t j = 0; j < dense_.size(); ++j) {
        Eigen::Vector3d p = Eigen::Vector3d::Zero();
        for (std::size_t k = 0; k < control_points.size(); ++k)
            p += table_.value(static_cast<int>(j), static_cast<int>(k)) * control_points[k];
        dense_[j] = p;
        if (j > 0) arc_m_[j] = arc_m_[j - 1] + (p - dense_[j - 1]).norm();
    }
    samples.resize(kSamples);
    std::size_t j = 1;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double s = arc_m_.back() * static_cast<double>(i) / (kSamples - 1);
        while (j + 1 < dense_.size() && arc_m_[j] < s) ++j;
        const double link = arc_m_[j] - arc_m_[j - 1];
        const double t = link > 0.0 ? (s - arc_m_[j - 1]) / link : 0.0;
        samples[i] = {.s_m = s, .p_C = dense_[j - 1] + t * (dense_[j] - dense_[j - 1])};
    }
}

}  // namespace atropos::tracker
