#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "scenes/capsule.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/tracker_config.hpp"
#include "tracker/cubic_basis.hpp"
#include "tracker/curve_refinement.hpp"
#include "tracker/image_view.hpp"
#include "tracker/normal_profile.hpp"
#include "tracker/occlusion_mask.hpp"
#include "tracker/valley_association.hpp"
#include "tracker/valley_filter.hpp"

namespace atropos::tracker {

/// Looks for the thread across a curve in both eyes: two-sided valleys along the normals, one of them chosen
/// for each sample so that neighbours agree, then its place to a fraction of a pixel with a sigma.
class CurveSight {
  public:
    /// How to look; px at 640.
    struct Look {
        double search_px;
        double threshold_share;  ///< of the configured contrast
        bool closely;            ///< sub-pixel places and sigmas
    };

    CurveSight(const scenes::TrackerConfig& config, const scenes::StereoRig& rig);

    /// Other cameras from now on.
    void set_rig(const scenes::StereoRig& rig) { rig_ = rig; }

    const ValleyFilterOptions& filter_options() const { return filter_.options(); }

    /// One line a sample and eye. `instruments_C` hide what lies behind them.
    void look(const std::array<ImageView, 2>& images, std::span<const CubicBasisValues> samples,
              const Eigen::Matrix3Xd& Q, std::span<const scenes::Capsule> instruments_C, const Look& look,
              std::array<std::vector<LineMeasurement>, 2>& lines);

    /// Forgets how dark each part of the thread was; learns it from lines that a good fit used.
    void reset();
    void learn(const std::array<std::vector<LineMeasurement>, 2>& lines);

    std::size_t state_size() const { return 2 * expected_depth_levels_[0].size(); }
    void save(double* out) const;
    void load(const double* in);

  private:
    void look_with(std::size_t eye, const ImageView& image, std::span<const CubicBasisValues> samples,
                   const Eigen::Matrix3Xd& Q, const OcclusionMask& mask, const Look& look,
                   std::vector<LineMeasurement>& measured);
    bool look_across(std::size_t eye, const ImageView& image, std::size_t j, const CubicBasisValues& sample,
                     const Eigen::Matrix3Xd& Q, const OcclusionMask& mask, const Look& look);
    std::span<const int> choose(const Look& look);
    void localise(const ImageView& image, std::vector<LineMeasurement>& measured);

    scenes::TrackerConfig config_;
    scenes::StereoRig rig_;
    double scale_;  ///< image width over 640
    ValleyFilter filter_;
    ValleyAssociation association_;
    std::array<std::vector<double>, 2> expected_depth_levels_;

    // Working memory of one eye.
    std::vector<ValleyCandidates> candidates_;
    std::vector<NormalLine> lines_;
    std::vector<double> widths_px_;
    std::vector<double> noises_, left_over_levels_, chosen_depths_;
};

}  // namespace atropos::tracker
