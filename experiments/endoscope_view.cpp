#include "experiments/endoscope_view.hpp"

#include <algorithm>
#include <cmath>

#include "scenes/scene_file.hpp"

namespace atropos::experiments {
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace {

constexpr int kSpanSamples = 101;
constexpr int kTailSamples = 5;
constexpr double kRibbonStep_m = 1.5e-4;  ///< of the drawn curve: 0.005 px of sag at bends of 5 mm

render::EndoscopeOptions endoscope_options(const scenes::RenderConfig& config, bool cache_tissue,
                                           int threads) {
    render::EndoscopeOptions options =
        render::endoscope_preset(config.preset == scenes::RenderPreset::kFast ? "fast" : "quality");
    options.shadows = config.shadows;
    options.threads = threads;
    options.psf_sigma_at_640_px = config.blur_px;
    options.cache_layer_at_rest = cache_tissue;
    options.backend = config.back_end == "egl" ? render::Backend::kEgl : render::Backend::kOSMesa;
    return options;
}

render::SensorOptions sensor_options(const scenes::SensorConfig& config) {
    render::SensorOptions options =
        render::sensor_preset(config.preset == scenes::SensorPreset::kIdeal ? "ideal" : "realistic");
    const auto replace = [](auto& own, auto value) {
        if (value >= 0) own = value;
    };
    options.exposure = config.exposure;
    if (config.auto_gain != scenes::AutoGain::kPreset)
        options.auto_gain = config.auto_gain == scenes::AutoGain::kOn;
    replace(options.vignetting, config.vignetting);
    replace(options.read_noise, config.read_noise);
    replace(options.shot_noise, config.shot_noise);
    replace(options.jpeg_quality, config.jpeg_quality);
    options.exposure_time_s = config.exposure_time_s;
    options.right_eye_delay_s = config.right_eye_delay_s;
    return options;
}

/// The tool's own model, with a user's meshes in the place of the links that they have.
render::InstrumentModel instrument_model(std::string_view tool, const scenes::ArmConfig& keys) {
    const std::string folder = "meshes/" + render::instrument_folder(tool);
    render::InstrumentModel model = render::load_instrument(scenes::resolve_path("", folder).string());
    if (!keys.meshes.empty()) render::replace_links(model, keys.meshes, keys.mesh_scale_m);
    return model;
}

void add_samples(const sim::ThreadTruth& thread, int strand, double from_m, double to_m, int count,
                 bool in_span, const Isometry3d& X_CW, std::vector<TruthSample>& samples) {
    for (int k = 0; k < count; ++k) {
        TruthSample sample;
        sample.strand = strand;
        sample.s_m = from_m + (to_m - from_m) * k / (count - 1);
        sample.in_span = in_span;
        sample.p_C = X_CW * thread.sample(strand, sample.s_m);
        samples.push_back(sample);
    }
}

}  // namespace

std::vector<TruthSample> truth_samples(const sim::ThreadTruth& thread, const Isometry3d& X_CW) {
    std::vector<TruthSample> samples;
    const sim::JudgedSpan& span = thread.span;
    for (size_t strand = 0; strand < thread.strands.size(); ++strand) {
        const auto& s_m = thread.strands[strand].s_m;
        const auto index = static_cast<int>(strand);
        const size_t begin = samples.size();
        const bool spanned = span.intact && thread.strand_at(0.5 * (span.s0_m + span.s1_m)) == index;
        if (spanned) {
            const double gap_m = 1e-6;  // tails end beside the span's own end points
            if (span.s0_m - s_m.front() > 2 * gap_m)
                add_samples(thread, index, s_m.front(), span.s0_m - gap_m, kTailSamples, false, X_CW,
                            samples);
            add_samples(thread, index, span.s0_m, span.s1_m, kSpanSamples, true, X_CW, samples);
            if (s_m.back() - span.s1_m > 2 * gap_m)
                add_samples(thread, index, span.s1_m + gap_m, s_m.back(), kTailSamples, false, X_CW, samples);
        } else {
            const auto count = std::max(2, static_cast<int>(std::ceil((s_m.back() - s_m.front()) / 7e-4)));
            add_samples(thread, index, s_m.front(), s_m.back(), count, false, X_CW, samples);
        }
        for (size_t i = begin; i < samples.size(); ++i) samples[i].i = static_cast<int>(i - begin);
    }
    return samples;
}

std::array<render::InstrumentModel, kArms> load_instruments(const scenes::SceneConfig& scene) {
    std::array<render::InstrumentModel, kArms> instruments;
    for (int arm = 0; arm < kArms; ++arm) {
        const scenes::ArmConfig& keys = arm_config(scene, arm);
        instruments[static_cast<size_t>(arm)] = instrument_model(robot::tool(keys.tool).name, keys);
    }
    return instruments;
}

EndoscopeView::EndoscopeView(const Testbed& testbed, bool cache_tissue)
    : pool_(testbed.scene().tracking.tracker.threads),
      endoscope_(
          endoscope_options(testbed.scene().render, cache_tissue, testbed.scene().tracking.tracker.threads),
          testbed.rig()),
      sensor_(sensor_options(testbed.scene().sensor), testbed.rig(), testbed.scene().seed),
      look_(render::thread_look(testbed.scene().thread.colour,
                                testbed.scene().thread.braided ? "braided" : "monofilament")),
      instruments_(load_instruments(testbed.scene())) {
    if (testbed.tissue()) testbed.tissue()->add_textures(endoscope_);
}

std::vector<scenes::RenderItem> EndoscopeView::items(const Testbed& testbed, const Moment& moment) const {
    std::vector<scenes::RenderItem> items;
    if (testbed.tissue()) items.push_back(testbed.tissue()->item(testbed.X_WTissue()));
    for (size_t arm = 0; arm < kArms; ++arm) {
        const auto label =
            static_cast<scenes::Label>(static_cast<int>(scenes::Label::kPSM1) + static_cast<int>(arm));
        for (int link = 0; link < robot::kLinkCount; ++link)
            instruments_[arm].append(link, moment.X_WL[arm][static_cast<size_t>(link)], label, items);
    }
    return items;
}

std::vector<render::ThreadRibbon> EndoscopeView::ribbons(const sim::ThreadTruth& thread) const {
    std::vector<render::ThreadRibbon> result;
    for (size_t strand = 0; strand < thread.strands.size(); ++strand) {
        const auto& s_m = thread.strands[strand].s_m;
        const auto count =
            std::max(2, static_cast<int>(std::ceil((s_m.back() - s_m.front()) / kRibbonStep_m)) + 1);
        render::ThreadRibbon ribbon{{}, thread.radius_m, look_};
        for (int k = 0; k < count; ++k)
            ribbon.curve_W.points.push_back(thread.sample(
                static_cast<int>(strand), s_m.front() + (s_m.back() - s_m.front()) * k / (count - 1)));
        result.push_back(std::move(ribbon));
    }
    return result;
}

render::StereoFrame EndoscopeView::expose(const Testbed& testbed, const std::vector<double>& times_s,
                                          const std::vector<render::SamplePoint>& samples) {
    std::vector<render::StereoFrame> frames;
    for (size_t i = 0; i < times_s.size(); ++i) {
        const Moment moment = testbed.moment(times_s[i]);
        const auto drawn = items(testbed, moment);
        const auto threads = ribbons(moment.thread);
        const bool middle = i == times_s.size() / 2;
        frames.push_back(
            endoscope_.render({.X_WC = testbed.X_WC(),
                               .items = drawn,
                               .ribbons = threads,
                               .samples = middle ? std::span(samples) : std::span(samples).first(0),
                               .light = {}}));
    }
    return frames.size() == 1 ? std::move(frames[0]) : render::mean_exposure(frames);
}

View EndoscopeView::capture(const Testbed& testbed, int frame) {
    View view;
    const auto points = [&](const std::vector<TruthSample>& samples, const sim::ThreadTruth& thread) {
        std::vector<render::SamplePoint> result;
        for (const TruthSample& s : samples)
            result.push_back({testbed.X_WC() * s.p_C, s.strand,
                              s.s_m - thread.strands[static_cast<size_t>(s.strand)].s_m.front()});
        return result;
    };
    const Isometry3d X_CW = testbed.X_WC().inverse();
    const auto left_s = sensor_.exposure_times_s(testbed.time_s(), 0),
               right_s = sensor_.exposure_times_s(testbed.time_s(), 1);
    const sim::ThreadTruth thread = testbed.moment(left_s[left_s.size() / 2]).thread;
    view.samples = truth_samples(thread, X_CW);
    view.truth = expose(testbed, left_s, points(view.samples, thread));
    if (left_s != right_s) {
        const sim::ThreadTruth later = testbed.moment(right_s[right_s.size() / 2]).thread;
        const auto samples = truth_samples(later, X_CW);
        const bool same = samples.size() == view.samples.size();  // not when it was cut in between
        view.truth.right =
            expose(testbed, right_s, same ? points(samples, later) : points(view.samples, thread)).right;
    }
    finish(view, frame);
    return view;
}

View EndoscopeView::capture_curve(const Testbed& testbed, const scenes::Polyline& curve_C, int frame) {
    View view;
    render::ThreadRibbon ribbon{{}, 0.5 * testbed.scene().thread.diameter_m, look_};
    for (const Vector3d& p_C : curve_C.points) ribbon.curve_W.points.push_back(testbed.X_WC() * p_C);
    const double length_m = curve_C.length_m();
    for (int k = 0; k < kSpanSamples; ++k) {
        TruthSample sample;
        sample.i = k;
        sample.s_m = length_m * k / (kSpanSamples - 1);
        sample.in_span = true;
        sample.p_C = curve_C.point_at(sample.s_m);
        view.samples.push_back(sample);
    }
    std::vector<render::SamplePoint> points;
    for (const TruthSample& s : view.samples) points.push_back({testbed.X_WC() * s.p_C, 0, s.s_m});
    std::vector<scenes::RenderItem> items;
    if (testbed.tissue()) items.push_back(testbed.tissue()->item(testbed.X_WTissue()));
    view.truth = endoscope_.render({.X_WC = testbed.X_WC(),
                                    .items = items,
                                    .ribbons = std::span(&ribbon, 1),
                                    .samples = points,
                                    .light = {}});
    finish(view, frame);
    return view;
}

/// Where the samples are seen, and the pictures.
void EndoscopeView::finish(View& view, int frame) {
    for (size_t i = 0; i < view.samples.size(); ++i) {
        const render::SampleView* eyes[] = {&view.truth.left.samples[i], &view.truth.right.samples[i]};
        for (size_t eye = 0; eye < 2; ++eye) {
            view.samples[i].pixel[eye] = eyes[eye]->pixel;
            view.samples[i].visible[eye] = eyes[eye]->visibility == render::Visibility::kVisible;
        }
    }
    const render::StereoImages images = sensor_.develop(view.truth, frame, &pool_);
    view.left = images.left;
    view.right = images.right;
}

}  // namespace atropos::experiments
