#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "experiments/append_file.hpp"
#include "experiments/closed_loop.hpp"
#include "experiments/metrics.hpp"
#include "experiments/run_report.hpp"
#include "experiments/track_writer.hpp"
#include "experiments/video_writer.hpp"

namespace atropos::experiments {

/// Writes a run's folder frame by frame and judges it at the end (design: "Run").
class RunRecorder {
  public:
    RunRecorder(std::filesystem::path folder, const ClosedLoop& loop, bool video);

    void add(const LoopFrame& frame);

    /// Judges, writes what is left, and returns summary.json.
    nlohmann::ordered_json finish(double wall_s);

  private:
    void write_truth(const LoopFrame& frame);
    void write_loop(const LoopFrame& frame);
    void add_metrics(const LoopFrame& frame);
    void draw(const LoopFrame& frame);
    nlohmann::ordered_json judge() const;
    nlohmann::ordered_json motion() const;
    nlohmann::ordered_json budget() const;

    std::filesystem::path folder_;
    const ClosedLoop& loop_;
    TrackWriter track_;
    std::vector<EvaluatedFrame> evaluated_;
    std::vector<double> frame_times_s_;
    std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>>
        middles_;  ///< of the true span, C and left image
    AppendFile loop_csv_, thread_;
    RunReport report_;
    std::unique_ptr<VideoWriter> video_;
    cv::Mat inset_;  ///< of the video, from outside
    bool wants_video_;
    const tracker::TrackResult* last_track_ = nullptr;
    scenes::ThreadEstimate last_estimate_;
    std::vector<Eigen::Vector3d> last_control_points_;
};

}  // namespace atropos::experiments
