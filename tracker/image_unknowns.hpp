#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "tracker/potentials.hpp"

namespace atropos::tracker {

/// The 2D parameterisation (II-B; the paper's comparison): 4K unknowns, the control points of both image
/// curves. A pair of them is one node of the chain. The pair's point in space, which length and ends are
/// taken on, is where its viewing rays come nearest, and its weights v_k (eq. 3) are that point's depths;
/// what keeps the rays together is a term of its own, the squared distance of the right point from the left
/// one's epipolar line.
class ImageUnknowns {
  public:
    ImageUnknowns(const scenes::StereoRig& rig, const scenes::TrackerConfig& config);

    static int labels_per_node(int r) { return 24 * r + 1; }

    /// The images of the control points.
    void begin(std::span<const Eigen::Vector3d> control_points);

    /// Puts fixed ends where they are.
    void fix_ends(const std::array<std::optional<MeasuredTip>, 2>& tips);

    /// Homogeneous control points of both image curves, as the eyes give them.
    const ImageControlPoints& points() const { return points_; }

    /// Labels around every pair: as L(r, s), on four axes and their eight diagonals: both points moved right
    /// or down by s as it looks at the point's depth, and against each other by half a step of what
    /// `depth_factor` s in depth is worth. A label whose rays meet nowhere before both eyes is forbidden.
    void place_labels(std::span<const Eigen::Vector3d> control_points, double s_m, NodeLabels& labels) const;

    void move(const NodeLabels& labels, std::span<const int> labelling);

    /// E_stereo: lambda_stereo times the squared distance from the epipolar line, px at 640, mean over u.
    double stereo_energy() const;

    /// 6K numbers that bring everything back.
    std::vector<double> state() const;
    void restore(std::span<const double> state);

  private:
    using Pair = std::array<Eigen::Vector2d, 2>;
    Eigen::Vector2d pixel(int eye, const Eigen::Vector2d& point) const;
    double epipolar_distance_px(const Pair& pixels) const;
    double stereo_cost(int k, const Pair& pixels) const;

    scenes::StereoRig pinhole_;  ///< the rig without its lenses' distortion
    std::array<Eye, 2> eyes_;
    int r_;
    double depth_factor_;
    double px_scale_;
    double lambda_stereo_;
    Eigen::Matrix3d fundamental_;                    ///< right^T F left = 0 in pixels without distortion
    std::vector<double> share_;                      ///< integral of N_k over u
    std::vector<std::array<double, 4>> directions_;  ///< right, down, disparity, its like across
    ImageControlPoints points_;
};

}  // namespace atropos::tracker
