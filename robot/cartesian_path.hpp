#pragma once

#include <Eigen/Geometry>
#include <vector>

namespace atropos::robot {

/// A path of poses through way-points, in the way-points' frame: straight stretches (rotation about a fixed
/// axis) with rounded corners that stay within the blend radius of their way-point. Twice continuously
/// differentiable in its parameter, a length in which turning by one radian counts `kTurn_m`; |dX/du| <= 1.
class CartesianPath {
  public:
    static constexpr double kTurn_m = 0.03;

    /// At least two way-points. `blend_m` > 0 when there are corners; it is cut to half of each neighbouring
    /// stretch. Throws std::invalid_argument on repeated way-points, half turns or more in one stretch,
    /// non-poses.
    explicit CartesianPath(std::vector<Eigen::Isometry3d> waypoints, double blend_m = 0.0);

    double length_m() const { return length_m_; }

    /// Pose at `u_m`, clamped to [0, length].
    Eigen::Isometry3d at(double u_m) const;

  private:
    using Step =
        Eigen::Matrix<double, 6, 1>;  // translation over kTurn_m * rotation vector, in way-point axes
    static Step step(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to);
    static Eigen::Isometry3d moved(const Eigen::Isometry3d& from, const Step& step);

    // Pieces in order: straight from a way-point along `in` (begin..end), or a corner from -blend to +blend.
    struct Piece {
        double u_begin_m, u_length_m;
        size_t waypoint;
        bool corner;
        Step in,
            out;  // unit directions at the way-point: arriving (reversed for straights: leaving), leaving
        double offset_m;
    };

    std::vector<Eigen::Isometry3d> waypoints_;
    std::vector<Piece> pieces_;
    double length_m_ = 0.0;
};

}  // namespace atropos::robot
