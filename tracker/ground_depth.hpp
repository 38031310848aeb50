#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <span>

#include "tracker/image_path.hpp"
#include "tracker/image_view.hpp"
#include "tracker/ridge_points.hpp"
#include "tracker/stereo_pairing.hpp"

namespace atropos::tracker {

/// How far away what lies around the thread is: coarse disparities of the ground's texture, lines and
/// instruments left out. Vessels lie on that ground, a held thread does not.
class GroundDepth {
  public:
    explicit GroundDepth(const scenes::StereoRig& rig);

    /// What is left out of an eye's image: the lines and what the map marks as hidden.
    struct Eye {
        const ImageView& image;
        const RidgePointMap& map;
        std::span<const ImagePath> lines;
    };

    /// Compares both eyes' textures over disparities from that of `farthest_m` to `largest_px`, in px of
    /// RectifiedView.
    void look(const Eye& left, const Eye& right, double farthest_m, double largest_px);

    void forget() { disparity_px_.release(); }
    bool has_looked() const { return !disparity_px_.empty(); }

    /// Disparity of the ground around a point of RectifiedView's left eye; nothing where its texture doesn't
    /// tell.
    std::optional<double> disparity_px(const Eigen::Vector2d& left) const;

  private:
    /// Levels without slow changes, and 1 where they are the ground's.
    struct Texture {
        cv::Mat1f level, known;
    };
    Texture texture(const Eye& eye, int which);

    RectifiedView view_;
    double scale_;                    ///< coarse pixels a pixel of an image
    Eigen::Vector2d corner_;          ///< of the coarse pixel (0, 0) in the view
    std::array<cv::Mat1f, 2> u_, v_;  ///< place in an eye's shrunk image, for every coarse pixel
    cv::Mat1b bytes_, shrunk_;
    cv::Mat1f disparity_px_;  ///< of the view; negative = unknown
};

}  // namespace atropos::tracker
