#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "experiments/closed_loop.hpp"
#include "experiments/metrics.hpp"

namespace atropos::experiments {

/// report.html of a run: one page that needs no network and no other file. True and tracked thread and arms
/// in space with a time slider, the stereo pair with overlays, errors and states over time, verdict and
/// budget.
class RunReport {
  public:
    /// Throws std::runtime_error when Debian's libjs-three or libjs-dygraphs is not there.
    RunReport();

    /// `metrics`: of this frame's estimate against the truth; none when there is no curve.
    void add(const LoopFrame& frame, const ClosedLoop& loop, const scenes::ThreadEstimate& estimate,
             const std::vector<Eigen::Vector3d>& control_points, const std::optional<FrameMetrics>& metrics);

    void write(const std::filesystem::path& file, const nlohmann::ordered_json& summary,
               const ClosedLoop& loop) const;

  private:
    void add_picture(const LoopFrame& frame, const ClosedLoop& loop, const scenes::ThreadEstimate& estimate,
                     const std::vector<Eigen::Vector3d>& control_points);

    std::string page_;  ///< with the libraries in it, the data not yet
    nlohmann::ordered_json frames_ = nlohmann::ordered_json::array();
    nlohmann::ordered_json pictures_ = nlohmann::ordered_json::array();
    Eigen::Vector3d centre_mm_ = Eigen::Vector3d::Zero();  ///< sum of the true middles, C
};

}  // namespace atropos::experiments
