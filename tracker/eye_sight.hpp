#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "scenes/stereo_rig.hpp"
#include "tracker/eye_correction.hpp"
#include "tracker/image_view.hpp"
#include "tracker/patch_match.hpp"

namespace atropos::tracker {

/// What the right eye is off by, from all that both pictures show: patches of the left one are found in the
/// right one beside the lines on which the calibration expects them. How far beside does not depend on depth.
///
/// The left picture is divided into cells; each remembers what its patch said. A patch errs the same way in
/// frame after frame (a slope, an edge of something nearer), so that the belief's covariance comes from how
/// much cells disagree, not from the number of frames.
class EyeSight {
  public:
    struct Options {
        double row_sigma_px = 1.0;       ///< of the rows, at 640, before anything is seen
        double roll_sigma_rad = 0.0035;  ///< and of the roll
        double nearest_m = 0.05;         ///< nothing is nearer to the eyes
        double farthest_m = 0.3;
        double forget_s = 60.0;  ///< age at which what a cell said counts for 1/e
    };

    EyeSight(const Options& options, const scenes::StereoRig& rig);

    void reset();
    /// Some of the cells look for their patches; all of them in the first frame.
    void look(const std::array<ImageView, 2>& images, double dt_s);
    const EyeFound& found() const { return found_; }

    static constexpr int kColumns = 20, kRows = 12;  ///< of cells
    static constexpr std::size_t kStateSize = 1 + 5 * kColumns * kRows;
    double* save(double* out) const;
    const double* load(const double* in);

  private:
    /// What a cell's patches said, in the mean: `off_px` = `by_eye` . (row, roll) if they are right.
    struct Cell {
        double information = 0.0;  ///< of off_px, by noise, 1/px^2
        double off_px = 0.0;
        Eigen::Vector2d by_eye = Eigen::Vector2d::Zero();
        double nearness = 0.0;  ///< 1 / depth where it was found last, 1/m; 0: not found
    };

    /// A place on the line of the right picture on which a left pixel is expected.
    struct OnLine {
        Eigen::Vector2d px;
        Eigen::Vector2d by_nearness;  ///< px m
        Eigen::Vector2d by_roll;      ///< px
    };
    OnLine on_line(const Eigen::Vector3d& ray_C, double nearness) const;
    cv::Rect region(const Eigen::Vector3d& ray_C, const Cell& cell) const;
    void look_in(const std::array<ImageView, 2>& images, int index, Cell& cell);
    void conclude();

    Options options_;
    scenes::StereoRig rig_;
    double scale_;  ///< image width over 640
    PatchMatcher matcher_;
    std::vector<Cell> cells_;
    int turn_ = 0;
    EyeFound found_;
};

}  // namespace atropos::tracker
