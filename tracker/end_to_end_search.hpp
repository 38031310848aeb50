#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "scenes/polyline.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/tracker_config.hpp"
#include "tracker/ridge_points.hpp"
#include "tracker/stereo_tracker.hpp"

namespace atropos::tracker {

/// Own choices; costs are of one step in one eye.
struct EndToEndOptions {
    scenes::ImageChannel channel = scenes::ImageChannel::kGray;
    RidgePointOptions ridge;
    double step_m = 0.001;
    int breadth = 600;              ///< ways that are followed at a time
    double margin = 25.0;           ///< that a way may cost more than the best of as many steps
    double turn_rad = 0.1;          ///< between neighbouring directions, across the ray
    double slope_rad = 0.15;        ///< and along it
    double usual_turn_rad = 0.12;   ///< one sigma, of a step
    double line_sigma_px = 0.7;     ///< of a ridge point against the way
    double direction_weight = 4.0;  ///< of sin^2 of the angle between line and way
    double usual_slope_rad = 1.2;   ///< one sigma, along the ray: what is not seen is not long
    double usual_levels = 10.0;     ///< strength of a line that looks like a thread's
    double faint_cost = 1.5;        ///< of a line of no strength
    double unseen_cost = 4.0;       ///< where no line is near; at most
    double hidden_cells = 1.5;      ///< times as large as others: there, ways are kept
    double hidden_cost = 1.6;       ///< where instruments hide what there is
    double instrument_margin_px = 3.5;
    double snap_m = 0.0003;      ///< one sigma of what a line's place may correct in a step
    double length_error = 0.06;  ///< share of the given length
    double end_sigma_m = 0.002;  ///< of where the other end is measured
    double largest_end_off_m = 0.006;
    double dearest = 1.5;  ///< a step, both eyes: another line, or none
};

/// The way of a thread of known length from one measured end to the other, loops, crossings and stretches
/// behind instruments and all: many ways are grown in space at once, a step of arc length at a time, and
/// those kept that lie on lines in both eyes and bend least (beam search). What ends there and has the length
/// is the thread: a crossing is left straight on, and the eyes decide together.
class EndToEndSearch {
  public:
    explicit EndToEndSearch(const scenes::StereoRig& rig, const EndToEndOptions& options = {});

    /// From end 0 to end 1 of `frame`, in C; coarse. Nothing when an end is unknown, or when no way of about
    /// that length leads from one to the other along lines.
    std::optional<scenes::Polyline> find(const StereoFrame& frame, double length_m);

  private:
    struct Place {
        Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
        double heading_rad = 0.0;  ///< across the viewing ray, from the image's rows
        double slope_rad = 0.0;    ///< along the ray, away from the eye
        double cost = 0.0;
        std::int32_t parent = -1;
        bool hidden = false;  ///< from an eye
        std::array<Eigen::Vector2d, 2> px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};
    };
    /// The ridge points of an eye, and which is nearest to each pixel.
    struct EyeRidges {
        cv::Mat buffer;
        RidgePointMap map;
        std::vector<std::int32_t> nearest;
    };

    struct Arrival {
        double cost = std::numeric_limits<double>::infinity();  ///< a step
        std::size_t step = 0;
        std::size_t place = 0;
    };

    void look(const StereoFrame& frame);
    void begin(const Eigen::Vector3d& p_C);
    std::int32_t ridge_at(std::size_t eye, const Eigen::Vector2d& px) const;
    bool take_step(const Place& from, double dearest, Place& to) const;
    void arrive(const Eigen::Vector3d& goal_C, Arrival& arrival) const;
    scenes::Polyline way_to(const Arrival& arrival) const;
    double cost_of_step(std::size_t eye, const Eigen::Vector2d& from_px, const Eigen::Vector2d& to_px) const;
    void grow(const Eigen::Vector3d& goal_C, double reach_m);
    void keep_best();
    void snap(Place& place) const;
    Eigen::Vector2d project(std::size_t eye, const Eigen::Vector3d& p_C) const;
    Eigen::Vector3d in_eye(std::size_t eye, const Eigen::Vector3d& p_C) const;
    const scenes::Camera& camera(std::size_t eye) const { return eye == 0 ? rig_.left : rig_.right; }

    scenes::StereoRig rig_;
    EndToEndOptions options_;
    RidgePointDetector detector_;
    std::array<EyeRidges, 2> eyes_;
    std::vector<std::vector<Place>> steps_;
    std::vector<Place> children_;
    std::vector<std::int32_t> order_;
};

}  // namespace atropos::tracker
