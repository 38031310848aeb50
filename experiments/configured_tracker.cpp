#include "experiments/configured_tracker.hpp"

#include "experiments/prior_file.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {

std::unique_ptr<tracker::StereoTracker> make_configured_tracker(const scenes::TrackerConfig& config,
                                                                const scenes::StereoRig& rig) {
    const std::string& file = config.refined.prior_file;
    if (file.empty() || config.method != scenes::TrackerMethod::kRefined)
        return tracker::make_tracker(config, rig);
    const tracker::DeformationPrior prior = read_deformation_prior(file);
    const int K = config.refined.control_points;
    if (K > 0 && prior.control_points != K)
        throw scenes::FileError(file, "learned of " + std::to_string(prior.control_points) +
                                          " control points, expected tracker.refined.K, " +
                                          std::to_string(K));
    return tracker::make_tracker(config, rig, &prior);
}

}  // namespace atropos::experiments
