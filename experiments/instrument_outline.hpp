#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "render/instrument.hpp"
#include "robot/tool.hpp"
#include "scenes/camera.hpp"

namespace atropos::experiments {

/// An instrument's drawn parts as convex pieces: each link is cut across its z axis and every slice replaced
/// by its convex hull. From them its outline in an image costs next to nothing.
class InstrumentOutline {
  public:
    struct Piece {
        int link = 0;
        Eigen::Matrix3Xd points;  ///< extreme points, in the link's frame (m)
    };

    explicit InstrumentOutline(const render::InstrumentModel& model);

    const std::vector<Piece>& pieces() const { return pieces_; }

    /// A piece's outline in an image: corners in order, and where in the link's frame each comes from. Empty
    /// when it isn't before the camera.
    struct Polygon {
        int link = 0;
        std::vector<Eigen::Vector2d> px;
        std::vector<Eigen::Vector3d> p_L;
    };
    /// `X_EL`: link poses in the camera's frame.
    std::vector<Polygon> project(const scenes::Camera& camera,
                                 std::span<const Eigen::Isometry3d, robot::kLinkCount> X_EL) const;

    /// Takes the corners to where they are seen with the links elsewhere, not far away: which points are
    /// corners stays. A twentieth of the cost of projecting anew.
    static void move(const scenes::Camera& camera, std::span<const Eigen::Isometry3d, robot::kLinkCount> X_EL,
                     std::vector<Polygon>& polygons);

  private:
    std::vector<Piece> pieces_;
};

/// Fills the union of the pieces with `value`.
void paint(const std::vector<InstrumentOutline::Polygon>& polygons, int value, cv::Mat& mask);

}  // namespace atropos::experiments
