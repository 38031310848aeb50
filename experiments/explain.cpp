#include "experiments/explain.hpp"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "experiments/output_folder.hpp"
#include "experiments/overlay.hpp"
#include "experiments/picture_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

std::string file_name(std::string_view stage) {
    std::string name(stage);
    for (char& c : name)
        if (c == ' ') c = '_';
    return name;
}

/// Any single-channel picture stretched to 8 bits, so that a person can look at it.
cv::Mat visible(const cv::Mat& picture) {
    if (picture.type() == CV_8UC1 || picture.type() == CV_8UC3) {
        double low = 0.0, high = 255.0;
        if (picture.channels() == 1) cv::minMaxLoc(picture, &low, &high);
        if (high > 32.0) return picture.clone();
    }
    cv::Mat stretched;
    cv::normalize(picture, stretched, 0, 255, cv::NORM_MINMAX, CV_8U);
    return stretched;
}

class Explainer final : public tracker::TrackObserver {
  public:
    Explainer(const tracker::StereoFrame& frame, const Sequence& sequence, const scenes::Polyline* truth,
              fs::path folder)
        : frame_(frame), sequence_(sequence), truth_(truth), folder_(std::move(folder)) {}

    void image(std::string_view stage, int eye, const cv::Mat& picture) override {
        write_png(folder_ / fmt::format("{}_{}.png", file_name(stage), eye == 0 ? "left" : "right"),
                  visible(picture));
    }

    void curve(std::string_view stage, std::span<const Eigen::Vector3d> control_points) override {
        const tracker::NurbsCurve spline(3, {control_points.begin(), control_points.end()});
        scenes::ThreadEstimate estimate;
        for (int i = 0; i <= 100; ++i) estimate.samples.push_back({0.0, spline.point(0.01 * i), 0.0, 0.0});
        const Overlay overlay{&estimate, control_points, truth_, std::string(stage)};
        write_png(folder_ / fmt::format("curve_{}_{}.png", curves_++, file_name(stage)),
                  draw_stereo_overlay(frame_.left, frame_.right, sequence_.rig(), overlay, 2));
    }

    void node(int step, int k, int label, const Eigen::Vector3d& displacement, double cost) override {
        const Eigen::Vector3d d = 1e3 * displacement;
        nodes_ +=
            fmt::format("{},{},{},{:.4f},{:.4f},{:.4f},{:.6f}\n", step, k, label, d.x(), d.y(), d.z(), cost);
    }

    const std::string& nodes() const { return nodes_; }

  private:
    const tracker::StereoFrame& frame_;
    const Sequence& sequence_;
    const scenes::Polyline* truth_;
    fs::path folder_;
    int curves_ = 0;
    std::string nodes_ = "step,k,label,dx_mm,dy_mm,dz_mm,cost\n";
};

}  // namespace

void explain_frame(tracker::StereoTracker& tracker, const tracker::TrackerState& before,
                   const Sequence& sequence, const tracker::StereoFrame& frame, const fs::path& folder) {
    fs::create_directories(folder);
    const auto index = static_cast<size_t>(frame.index);
    std::vector<TruthFrame> truth;
    if (fs::exists(sequence.folder() / "truth" / "thread.csv"))
        truth = read_truth(sequence.folder(), sequence.frames());
    const scenes::Polyline* span =
        truth.empty() || truth[index].span_C.points.size() < 2 ? nullptr : &truth[index].span_C;
    write_png(folder / "input_left.png", frame.left);
    write_png(folder / "input_right.png", frame.right);
    Explainer explainer(frame, sequence, span, folder);
    tracker.restore(before);
    tracker.set_observer(&explainer);
    const tracker::TrackResult& result = tracker.track(frame);
    tracker.set_observer(nullptr);
    write_file(folder / "nodes.csv", explainer.nodes());
    write_file(
        folder / "energy.csv",
        fmt::format("term,value\ndata,{:.6f}\nlength,{:.6f}\ntips,{:.6f}\ntotal,{:.6f}\nsupport,{:.4f}\n",
                    result.energy.data, result.energy.length, result.energy.tips, result.energy.total,
                    result.support));
}

}  // namespace atropos::experiments
