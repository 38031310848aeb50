#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/append_file.hpp"
#include "experiments/endoscope_view.hpp"
#include "experiments/rectifier.hpp"
#include "experiments/testbed.hpp"

namespace atropos::experiments {

/// Columns of truth/thread.csv, and a frame's rows.
constexpr std::string_view kTruthThreadColumns =
    "frame,strand,i,s_mm,in_span,x_mm,y_mm,z_mm,u_left_px,v_left_px,u_right_px,v_right_px,visible_left,"
    "visible_right";
std::string truth_rows(int frame, const std::vector<TruthSample>& samples);

/// Which layers of a sequence are written besides pictures and tables.
struct SequenceLayers {
    bool depth = true;
    bool mask = true;
    bool coverage = true;
    bool rectified =
        false;  ///< rectified/left, rectified/right, and truth/ disparity_, occlusion_ of both eyes
};

/// Writes a sequence folder (design: "Sequence") frame by frame.
class SequenceWriter {
  public:
    SequenceWriter(std::filesystem::path folder, const Testbed& testbed, const SequenceLayers& layers);

    void add(const Testbed& testbed, const View& view);

    /// Events, meta.json with the checksums of everything; `extra` is merged into it.
    void finish(const Testbed& testbed, const nlohmann::ordered_json& extra);

    int frames() const { return frame_; }

  private:
    void write_pictures(const View& view);
    void write_rectified(const View& view);
    void write_tips(const Testbed& testbed);
    void write_kinematics(const Testbed& testbed);

    std::filesystem::path folder_;
    SequenceLayers layers_;
    std::unique_ptr<Rectifier> rectifier_;
    int frame_ = 0;
    std::optional<Eigen::Vector3d> knot_C_;
    std::vector<double> frame_times_s_;
    AppendFile frames_, tips_, kinematics_, thread_, true_kinematics_;
};

/// The rows of truth/events.csv; a contact force above its limit is no event of that table.
std::string events_csv(const std::vector<sim::Event>& events, const std::vector<double>& frame_times_s,
                       const Eigen::Isometry3d& X_CW);

}  // namespace atropos::experiments
