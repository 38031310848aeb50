#include "experiments/sequence_bound.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/file_error.hpp"
#include "tracker/cramer_rao_bound.hpp"
#include "tracker/thread_contrast.hpp"

namespace atropos::experiments {
namespace {

constexpr int kEvery = 10;

tracker::BoundOptions priors_of(const scenes::TrackerConfig& config) {
    tracker::BoundOptions options;
    options.width_m = config.thread.width_m;
    options.blur_px = config.refined.blur_px;
    if (config.refined.control_points > 0) options.control_points = config.refined.control_points;
    options.length_sigma_m = config.refined.length_sigma_m;
    options.tip_sigma_m = std::hypot(config.refined.tip_bias_sigma_m, config.refined.tip_sigma_m);
    return options;
}

}  // namespace

SequenceBound sequence_bound(const Sequence& sequence, const std::vector<TruthFrame>& truth,
                             const scenes::TrackerConfig& config) {
    tracker::BoundOptions options = priors_of(config);
    const tracker::ValleyFilterOptions look{.polarity = config.thread.polarity,
                                            .blur_px = config.refined.blur_px};
    SequenceBound bound;
    double contrast = 0.0, noise = 0.0;
    const int frames = std::min(sequence.frames(), static_cast<int>(truth.size()));
    for (int i = 0; i < frames; i += kEvery) {
        const scenes::Polyline& span_C = truth[static_cast<size_t>(i)].span_C;
        if (span_C.points.size() < 2) continue;
        const tracker::StereoFrame frame = sequence.frame(i);
        std::array<cv::Mat, 2> buffers;
        const std::array<tracker::ImageView, 2> images = {
            tracker::channel_view(frame.left, config.thread.channel, buffers[0]),
            tracker::channel_view(frame.right, config.thread.channel, buffers[1])};
        const auto seen =
            tracker::thread_contrast(images, span_C, sequence.rig(), config.thread.width_m, look);
        if (!seen) continue;
        options.contrast_levels = seen->contrast_levels;
        options.noise_levels = seen->noise_levels;
        bound.mean_3d_mm.push_back(1e3 *
                                   tracker::cramer_rao_bound(span_C, sequence.rig(), {}, options).mean_3d_m);
        contrast += seen->contrast_levels;
        noise += seen->noise_levels;
    }
    if (bound.mean_3d_mm.empty())
        throw scenes::FileError(sequence.folder().string(),
                                "no picture that shows the thread, expected one for --bound");
    const double n = static_cast<double>(bound.mean_3d_mm.size());
    bound.assumed["bound_contrast_levels"] = contrast / n;
    bound.assumed["bound_noise_levels"] = noise / n;
    bound.assumed["bound_blur_px"] = options.blur_px;
    bound.assumed["bound_width_mm"] = 1e3 * options.width_m;
    bound.assumed["bound_prior_control_points"] = options.control_points;
    bound.assumed["bound_prior_length_sigma_mm"] = 1e3 * options.length_sigma_m;
    bound.assumed["bound_prior_stretch_sigma_percent"] = 1e2 * options.stretch_sigma;
    bound.assumed["bound_prior_tip_sigma_mm"] = 1e3 * options.tip_sigma_m;
    return bound;
}

}  // namespace atropos::experiments
