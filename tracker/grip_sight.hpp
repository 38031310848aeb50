#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "scenes/capsule.hpp"
#include "scenes/stereo_rig.hpp"
#include "tracker/cubic_basis.hpp"
#include "tracker/image_view.hpp"
#include "tracker/valley_filter.hpp"

namespace atropos::tracker {

/// Where along the curve the jaws really grip the thread, as images show it. Lengths along the thread beyond
/// the curve's end, outwards (m).
struct GripSighting {
    double offset_m = 0.0;  ///< of the grip point from the curve's end
    double sigma_m = 0.0;
    std::optional<double> excess_m;  ///< jaws seen wider than their capsules on each side, when it was seen
    double excess_sigma_m = 0.0;
};

/// What is known before looking.
struct GripQuery {
    std::size_t end = 0;
    Eigen::Vector3d measured_C = Eigen::Vector3d::Zero();  ///< the grip point by kinematics
    std::span<const scenes::Capsule> instruments_C;        ///< of all arms, by the same kinematics
    double expected_m = 0.0;                               ///< of offset_m
    double sigma_m = 0.0;
    double excess_m = 0.0;  ///< learned before
    double excess_variance_m2 = 0.0;
};

/// Jaws hide the thread where they hold it: it ends at their outline, and where a tail is left it begins
/// again on the other side. Both edges are looked for along the fitted curve and its straight continuation,
/// and compared with those that the instrument's capsules predict. This, not the curve's shape, tells where
/// along the thread the jaws are.
class GripSight {
  public:
    static constexpr double kSameArm_m = 0.010;  ///< capsules nearer to the grip move with it

    GripSight(const scenes::StereoRig& rig, const ValleyFilterOptions& filter, double thread_width_m);

    /// Other cameras from now on.
    void set_rig(const scenes::StereoRig& rig) { rig_ = rig; }

    /// Nothing when the thread is not seen to vanish there.
    std::optional<GripSighting> look(const std::array<ImageView, 2>& images, const CubicBasis& basis,
                                     const Eigen::Matrix3Xd& Q, double length_m, const GripQuery& query);

    /// Where along the curve the thread ends of itself, no jaws about it. Nothing when it is not seen to end.
    std::optional<GripSighting> look_free(const std::array<ImageView, 2>& images, const CubicBasis& basis,
                                          const Eigen::Matrix3Xd& Q, double length_m, std::size_t end,
                                          std::span<const scenes::Capsule> instruments_C);

  private:
    /// Where the capsules begin or end to hide the path, and how far that moves if they grow, per length.
    struct Border {
        double at_m;
        double slope;
    };
    struct Outline {
        std::optional<Border> inner, outer;
    };

    /// Lengths at which the thread vanishes and appears again.
    struct Edges {
        std::optional<double> inner_m;
        std::optional<double> outer_m;
    };

    void follow(const CubicBasis& basis, const Eigen::Matrix3Xd& Q, double length_m, std::size_t end);
    Outline predict(const Eigen::Vector3d& eye_C, std::span<const scenes::Capsule> jaws_C) const;
    void weigh(const ImageView& image, std::size_t eye, std::span<const scenes::Capsule> others_C);
    Edges find(const Outline& predicted, const GripQuery& query);
    bool vanishes_at(int index) const;

    scenes::StereoRig rig_;
    ValleyFilter filter_;
    double thread_width_m_;
    double threshold_levels_;

    // Working memory: the path along the thread, from inside to outside.
    std::vector<Eigen::Vector3d> path_C_;
    std::vector<Eigen::Vector3d> tangent_C_;
    std::vector<double> depth_levels_;
    std::vector<double> sorted_;
    std::vector<double> sum_;   ///< log odds of "visible" up to here
    std::vector<double> tail_;  ///< the best of a visible stretch that begins here
    std::vector<scenes::Capsule> jaws_C_;
    std::vector<scenes::Capsule> others_C_;
};

}  // namespace atropos::tracker
