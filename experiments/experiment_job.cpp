#include "experiments/experiment_job.hpp"

#include <fmt/format.h>

#include <chrono>

#include "experiments/closed_loop.hpp"
#include "experiments/configured_tracker.hpp"
#include "experiments/external_tracker.hpp"
#include "experiments/knot_ends.hpp"
#include "experiments/metrics.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/overlay.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/recorded_run.hpp"
#include "experiments/reprojection.hpp"
#include "experiments/sequence_arms.hpp"
#include "experiments/sequence_generator.hpp"
#include "experiments/thread_starter.hpp"
#include "experiments/track_writer.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;
namespace {

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

bool keeps(Keep keep, bool failed) {
    return keep == Keep::kAll || (keep == Keep::kFailures && failed);
}

ordered_json result_head(const JobSpec& job, const char* status) {
    return {{"id", job.id}, {"status", status}};
}

void write_json(const fs::path& file, const ordered_json& json) {
    write_file(file, json.dump(2) + "\n");
}

/// The frame in which a curve was furthest from the truth.
struct WorstFrame {
    int frame = 0, base_frame = 0;
    double symmetric_2d_px = 0.0;
    scenes::ThreadEstimate estimate;
    std::vector<Eigen::Vector3d> control_points;
    bool has_curve() const { return !estimate.samples.empty(); }
};

/// Every `accel`-th frame, renumbered; judged against the truth of the frame it is.
void track_job(const JobSpec& job, const fs::path& sequence_folder, const fs::path& folder, Keep keep) {
    const auto begin = Clock::now();
    const Sequence sequence = Sequence::open(sequence_folder);
    const scenes::StereoRig rig = degraded(sequence.rig(), job.degradation);
    std::string log;
    const std::unique_ptr<tracker::StereoTracker> tracker =
        job.command.empty() ? make_configured_tracker(job.scene.tracking.tracker, rig)
                            : make_external_tracker({job.command}, rig, log, true);
    ThreadStarter starter(job.scene.tracking.tracker, rig);
    const bool refined =
        job.command.empty() && job.scene.tracking.tracker.method == scenes::TrackerMethod::kRefined;
    const std::unique_ptr<SequenceArms> arms =  // the paper's trackers know no instruments
        refined ? SequenceArms::open(sequence, rig, job.scene.tracking.tracker.threads) : nullptr;
    const std::vector<TruthFrame> truth = read_truth(sequence_folder, sequence.frames());
    TrackWriter writer;
    KnotEnds knots;
    std::vector<EvaluatedFrame> frames;
    std::vector<scenes::Polyline> spans;
    WorstFrame worst;
    for (int k = 0, n = 0; k < sequence.frames(); k += job.accel, ++n) {
        tracker::StereoFrame frame = sequence.frame(k);
        frame.index = n;
        degrade(frame, job.degradation, job.scene.seed);
        if (arms) arms->add_to(frame, k);
        knots.place(frame);
        const tracker::TrackResult& result =
            job.command.empty() ? starter.track(*tracker, frame) : tracker->track(frame);
        knots.learn(frame, result.estimate);
        writer.add(result);
        writer.add_timings(tracker->timings());
        const scenes::Polyline& span = truth[static_cast<size_t>(k)].span_C;
        if (span.points.size() < 2) continue;
        spans.push_back(span);
        const scenes::ThreadEstimate estimate = resampled(result.estimate, kTrackSamples);
        EvaluatedFrame f{n, estimate.status, estimate.samples.size() >= 2, {}};
        if (f.has_curve) f.metrics = compare(estimate, span, sequence.rig());
        frames.push_back(f);
        if (!worst.has_curve() || (f.has_curve && f.metrics.symmetric_2d_px > worst.symmetric_2d_px))
            worst = {n, k, f.has_curve ? f.metrics.symmetric_2d_px : 0.0, estimate, result.control_points};
    }
    ordered_json result = result_head(job, "done");
    result["metrics"] = summarise(frames);
    result["metrics"].update(deformation(spans, sequence.rig()));
    if (worst.has_curve()) {
        result["worst"] = {{"symmetric_2d_px", worst.symmetric_2d_px},
                           {"frame", worst.frame},
                           {"base_frame", worst.base_frame},
                           {"sequence", job.sequence_id}};
        const tracker::StereoFrame frame = sequence.frame(worst.base_frame);
        const Overlay overlay{&worst.estimate, worst.control_points,
                              &truth[static_cast<size_t>(worst.base_frame)].span_C,
                              fmt::format("frame {}", worst.frame)};
        write_jpeg(folder / "worst.jpg",
                   draw_stereo_overlay(frame.left, frame.right, sequence.rig(), overlay));
    }
    write_json(folder / "result.json", result);
    write_file(folder / "frames.csv", per_frame_csv(frames));
    if (!job.command.empty()) write_file(folder / "tracker.log", log);
    if (keeps(keep, result["metrics"]["failure_rate"].get<double>() > 0.0))
        writer.write(folder / "track", {{"sequence", job.sequence_id}, {"accel", job.accel}});
    write_json(folder / "timing.json", {{"wall_s", seconds_since(begin)}, {"frames", frames.size()}});
}

void run_job(const JobSpec& job, const fs::path& folder, Keep keep) {
    std::string log;
    RunRequest request;
    request.video = false;
    request.quiet = true;
    if (!job.command.empty())
        request.make_tracker = [&](const scenes::StereoRig& rig) {
            return make_external_tracker({job.command}, rig, log, true);
        };
    ordered_json result = result_head(job, "done");
    result.update(record_run(job.scene, folder / "run", request));
    write_json(folder / "result.json", result);
    if (!job.command.empty()) write_file(folder / "tracker.log", log);
    fs::rename(folder / "run" / "timing.json", folder / "timing.json");
    if (!keeps(keep, result["verdict"] != "cut")) fs::remove_all(folder / "run");
}

}  // namespace

void make_sequence(const JobSpec& job, const fs::path& folder) {
    OutputFolder output(folder, true);
    if (job.reprojected)
        make_reprojected_sequence(job.scene, output.path());
    else
        generate_sequence(job.scene, 1, output.path(), {false, false, false, false}, [](int) {});
    output.commit();
}

void do_job(const JobSpec& job, const fs::path& sequence, const fs::path& folder, Keep keep) {
    OutputFolder output(folder, true);
    write_file(output.path() / "scene.yaml", scenes::to_yaml(job.scene));
    if (job.kind == JobSpec::Kind::kRun)
        run_job(job, output.path(), keep);
    else
        track_job(job, sequence, output.path(), keep);
    output.commit();
}

void write_failure(const JobSpec& job, const std::string& reason, const fs::path& folder) {
    std::error_code error;
    fs::remove_all(fs::path(folder) += ".partial", error);
    OutputFolder output(folder, true);
    write_file(output.path() / "scene.yaml", scenes::to_yaml(job.scene));
    ordered_json result = result_head(job, "failed");
    result["reason"] = reason;
    write_json(output.path() / "result.json", result);
    output.commit();
}

}  // namespace atropos::experiments
