#pragma once

#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "experiments/testbed.hpp"
#include "render/instrument.hpp"
#include "render/sensor.hpp"
#include "render/stereo_endoscope.hpp"
#include "scenes/worker_pool.hpp"

namespace atropos::experiments {

/// A point of the true thread as a camera pair sees it.
struct TruthSample {
    int strand = 0;
    int i = 0;
    double s_m = 0.0;
    bool in_span = false;
    Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
    std::array<Eigen::Vector2d, 2> pixel{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};  ///< left, right
    std::array<bool, 2> visible{};
};

/// What the cameras see at one instant: `left` and `right` are all that a real system would have.
struct View {
    cv::Mat left, right;        ///< 8-bit BGR
    render::StereoFrame truth;  ///< depth, labels, coverage
    std::vector<TruthSample> samples;
};

/// The endoscope over a testbed: draws arms, tissue and thread, and turns light into pictures.
class EndoscopeView {
  public:
    /// Throws scenes::FileError when there is no renderer or a mesh can't be used.
    /// `cache_tissue` false draws the tissue anew in each frame, as a moving camera would: the same bytes.
    explicit EndoscopeView(const Testbed& testbed, bool cache_tissue = true);

    View capture(const Testbed& testbed, int frame);

    /// The tissue and, in the thread's place, a curve given in C; no arms. All of the curve is its span.
    View capture_curve(const Testbed& testbed, const scenes::Polyline& curve_C, int frame);
    std::string description() const { return endoscope_.description(); }

    /// What the arms' instruments are drawn from.
    const std::array<render::InstrumentModel, kArms>& instruments() const { return instruments_; }

  private:
    std::vector<scenes::RenderItem> items(const Testbed& testbed, const Moment& moment) const;
    std::vector<render::ThreadRibbon> ribbons(const sim::ThreadTruth& thread) const;
    /// Light averaged over the moments at `times_s`; samples are looked up in the middle one.
    render::StereoFrame expose(const Testbed& testbed, const std::vector<double>& times_s,
                               const std::vector<render::SamplePoint>& samples);
    void finish(View& view, int frame);

    scenes::WorkerPool pool_;
    render::StereoEndoscope endoscope_;
    render::Sensor sensor_;
    render::ThreadLook look_;
    std::array<render::InstrumentModel, kArms> instruments_;
};

/// What the instruments of a scene's arms are drawn from. Throws std::runtime_error when a mesh is missing.
std::array<render::InstrumentModel, kArms> load_instruments(const scenes::SceneConfig& scene);

/// Samples of every strand: 101 over the judged span, and its tails.
std::vector<TruthSample> truth_samples(const sim::ThreadTruth& thread, const Eigen::Isometry3d& X_CW);

}  // namespace atropos::experiments
