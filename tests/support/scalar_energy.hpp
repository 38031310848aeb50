#pragma once

#include <span>

#include "tracker/potentials.hpp"

namespace atropos::support {

/// The potentials as the paper writes them: each term from the displaced curve itself, one sample and one
/// label at a time, in double. Slow; what the fast ones are compared with, in value and in time.
double scalar_V1ab(const tracker::EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                   const Eigen::Vector3d& l_p, int p);  ///< V^1a + lambda_1 V^1b, eq. 11 and 12
double scalar_V2ab(const tracker::EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
                   const Eigen::Vector3d& l_p, const Eigen::Vector3d& l_q, int p);  ///< eq. 16 and 17

/// Fill whole chains by them, tips included.
class ScalarPotentialsE1 final : public tracker::Potentials {
  public:
    void fill(const tracker::EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
              const tracker::NodeLabels& labels, scenes::WorkerPool& pool,
              tracker::ChainProblem& chain) override;
};
class ScalarPotentialsE2 final : public tracker::Potentials {
  public:
    void fill(const tracker::EnergyContext& context, std::span<const Eigen::Vector3d> control_points,
              const tracker::NodeLabels& labels, scenes::WorkerPool& pool,
              tracker::ChainProblem& chain) override;
};

}  // namespace atropos::support
