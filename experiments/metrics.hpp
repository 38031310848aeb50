#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/sequence.hpp"
#include "scenes/stereo_rig.hpp"
#include "scenes/thread_estimate.hpp"

namespace atropos::experiments {

/// Errors of one frame's curve against the true span. Distances of eq. 20-22 and those that see what they
/// hide.
struct FrameMetrics {
    double accuracy_3d_mm = 0.0;   ///< eq. 20: mean distance from the estimate to the truth
    double accuracy_2d_px = 0.0;   ///< eq. 21: the same in the images, mean of both eyes
    double symmetric_3d_mm = 0.0;  ///< mean of both directions
    double symmetric_2d_px = 0.0;
    double disparity_equivalent_px = 0.0;  ///< accuracy_3d over what a pixel of disparity is worth there
    double arc_length_3d_mm = 0.0;         ///< mean distance at equal arc length
    double midpoint_mm = 0.0;              ///< between the points at half of each length
    double tip_mm = 0.0;                   ///< mean of both ends
    double end_slide_px = 0.0;             ///< mean shift of the ends along the thread, in the images
    double length_error_percent = 0.0;     ///< signed
    // Share of samples whose offset to the nearest true point lies within k sigma.
    double coverage_depth_1_sigma = 0.0, coverage_depth_2_sigma = 0.0;
    double coverage_lateral_1_sigma = 0.0, coverage_lateral_2_sigma = 0.0;
};

/// Name and place of each entry, in the order of the tables.
const std::vector<std::pair<std::string, double FrameMetrics::*>>& metric_fields();

/// `estimate` must have samples and `truth` at least two points.
FrameMetrics compare(const scenes::ThreadEstimate& estimate, const scenes::Polyline& truth_C,
                     const scenes::StereoRig& rig);

struct EvaluatedFrame {
    int frame = 0;
    scenes::TrackStatus status = scenes::TrackStatus::kLost;
    bool has_curve = false;
    FrameMetrics metrics;  ///< of frames with a curve and a truth
};

/// Mean, std, p95 and max; null of none.
nlohmann::ordered_json statistics(std::vector<double> values);

/// Statistics over frames: lost frames are left out of the means, and counted.
nlohmann::ordered_json summarise(const std::vector<EvaluatedFrame>& frames);

/// How far eight points at equal steps of arc length move from one true span to the next (Table I's columns
/// of deformation): deformation_3d_mm, deformation_2d_px (left picture).
nlohmann::ordered_json deformation(const std::vector<scenes::Polyline>& spans_C,
                                   const scenes::StereoRig& rig);
const std::vector<std::string>& deformation_names();

/// The metrics of each frame as a CSV text; empty fields where there is no curve.
std::string per_frame_csv(const std::vector<EvaluatedFrame>& frames);

/// A summary as a text table.
std::string summary_table(const nlohmann::ordered_json& summary);

}  // namespace atropos::experiments
