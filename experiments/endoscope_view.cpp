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

render::EndoscopeOptions endoscope_options(const scenes::RenderConfig& config) {
    render::EndoscopeOptions options =
        render::endoscope_preset(config.preset == scenes::RenderPreset::kFast ? "fast" : "quality");
    options.shadows = config.shadows;
    options.backend = config.back_end == "egl" ? render::Backend::kEgl : render::Backend::kOSMesa;
    return options;
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
        const std::string_view tool = robot::tool(arm_config(scene, arm).tool).name;
        const std::string folder = "meshes/" + render::instrument_folder(tool);
        instruments[static_cast<size_t>(arm)] =
            render::load_instrument(scenes::resolve_path("", folder).string());
    }
    return instruments;
}

EndoscopeView::EndoscopeView(const Testbed& testbed)
    : endoscope_(endoscope_options(testbed.scene().render), testbed.rig()),
      sensor_(render::sensor_preset(
                  testbed.scene().sensor.preset == scenes::SensorPreset::kIdeal ? "ideal" : "realistic"),
              testbed.rig(), testbed.scene().seed),
      look_(render::thread_look(testbed.scene().thread.colour,
                                testbed.scene().thread.braided ? "braided" : "monofilament")),
      instruments_(load_instruments(testbed.scene())) {
    if (testbed.tissue()) testbed.tissue()->add_textures(endoscope_);
}

std::vector<scenes::RenderItem> EndoscopeView::items(const Testbed& testbed) const {
    std::vector<scenes::RenderItem> items;
    if (testbed.tissue()) items.push_back(testbed.tissue()->item(testbed.X_WTissue()));
    for (int arm = 0; arm < kArms; ++arm) {
        const auto X_WL = testbed.arm(arm).true_links_W();
        const auto label = static_cast<scenes::Label>(static_cast<int>(scenes::Label::kPSM1) + arm);
        for (int link = 0; link < robot::kLinkCount; ++link)
            instruments_[static_cast<size_t>(arm)].append(link, X_WL.value[static_cast<size_t>(link)], label,
                                                          items);
    }
    return items;
}

View EndoscopeView::capture(const Testbed& testbed, int frame) {
    View view;
    const sim::ThreadTruth thread = testbed.thread();
    std::vector<render::ThreadRibbon> ribbons;
    for (size_t strand = 0; strand < thread.strands.size(); ++strand) {
        const auto& s_m = thread.strands[strand].s_m;
        const auto count =
            std::max(2, static_cast<int>(std::ceil((s_m.back() - s_m.front()) / kRibbonStep_m)) + 1);
        render::ThreadRibbon ribbon{{}, thread.radius_m, look_};
        for (int k = 0; k < count; ++k)
            ribbon.curve_W.points.push_back(thread.sample(
                static_cast<int>(strand), s_m.front() + (s_m.back() - s_m.front()) * k / (count - 1)));
        ribbons.push_back(std::move(ribbon));
    }
    view.samples = truth_samples(thread, testbed.X_WC().inverse());
    std::vector<double> begins_m;
    for (const auto& strand : thread.strands) begins_m.push_back(strand.s_m.front());
    draw(view, testbed.X_WC(), items(testbed), ribbons, begins_m, frame);
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
    std::vector<scenes::RenderItem> items;
    if (testbed.tissue()) items.push_back(testbed.tissue()->item(testbed.X_WTissue()));
    draw(view, testbed.X_WC(), items, {ribbon}, {0.0}, frame);
    return view;
}

/// Pictures and truth of items and ribbons; `view.samples` get their pixels and visibility.
void EndoscopeView::draw(View& view, const Isometry3d& X_WC, const std::vector<scenes::RenderItem>& items,
                         const std::vector<render::ThreadRibbon>& ribbons,
                         const std::vector<double>& strand_begin_s_m, int frame) {
    std::vector<render::SamplePoint> points;
    for (const TruthSample& s : view.samples)
        points.push_back({X_WC * s.p_C, s.strand, s.s_m - strand_begin_s_m[static_cast<size_t>(s.strand)]});
    view.truth =
        endoscope_.render({.X_WC = X_WC, .items = items, .ribbons = ribbons, .samples = points, .light = {}});
    for (size_t i = 0; i < view.samples.size(); ++i) {
        const render::SampleView* eyes[] = {&view.truth.left.samples[i], &view.truth.right.samples[i]};
        for (size_t eye = 0; eye < 2; ++eye) {
            view.samples[i].pixel[eye] = eyes[eye]->pixel;
            view.samples[i].visible[eye] = eyes[eye]->visibility == render::Visibility::kVisible;
        }
    }
    const render::StereoImages images = sensor_.develop(view.truth, frame);
    view.left = images.left;
    view.right = images.right;
}

}  // namespace atropos::experiments
