#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "tracker/image_view.hpp"

namespace atropos::tracker {

/// Where a patch of the left picture is in the right one.
struct PatchMatch {
    Eigen::Vector2d left_px = Eigen::Vector2d::Zero();
    Eigen::Vector2d right_px = Eigen::Vector2d::Zero();
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< on the difference, by the noise seen, 1/px^2
};

/// Finds square patches of one picture in another: by correlation to whole pixels, then by least squares on
/// place, brightness and contrast (Lucas, Kanade 1981). Along an edge a patch may slide; its information says
/// so.
class PatchMatcher {
  public:
    static constexpr int kHalf = 10;  ///< patches are 2 kHalf + 1 pixels wide

    /// Chooses the patch with its centre in `cell` that tells its row best, columns unknown; its centre.
    /// Nothing where patches would reach out of the picture.
    std::optional<cv::Point> choose(const ImageView& left, const cv::Rect& cell);

    /// Looks for the chosen patch with its centre in `region`. Nothing when it is not found there.
    std::optional<PatchMatch> find(const ImageView& right, const cv::Rect& region);

  private:
    static constexpr int kSide = 2 * kHalf + 1;
    static constexpr int kCount = kSide * kSide;
    using Values = Eigen::Array<float, kCount, 1>;  ///< of a patch, row by row

    /// A blurred part of a picture.
    struct Window {
        cv::Rect at;
        cv::Mat1f grey;
    };
    void blur(const ImageView& image, const cv::Rect& region, Window& out);
    void describe(const cv::Point& centre);
    std::optional<cv::Point> best_correlated() const;
    std::optional<PatchMatch> refine(const cv::Point& first) const;

    Window left_, right_;
    cv::Mat1f raw_, half_blurred_;
    cv::Mat1d sums_xx_, sums_xy_, sums_yy_;

    // The chosen patch: grey levels and their gradients less their means.
    Eigen::Vector2d centre_px_ = Eigen::Vector2d::Zero();
    Values grey_ = Values::Zero(), by_x_ = Values::Zero(), by_y_ = Values::Zero();
    Eigen::Matrix2d normal_matrix_ = Eigen::Matrix2d::Identity();
};

}  // namespace atropos::tracker
