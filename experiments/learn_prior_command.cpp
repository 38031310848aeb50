#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "experiments/commands.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/prior_file.hpp"
#include "experiments/recorded_curves.hpp"
#include "scenes/file_error.hpp"
#include "tracker/deformation_learner.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

struct LearnPriorOptions {
    std::vector<std::string> tracks;
    std::string output;
    int modes = 5;
    bool quiet = false, force = false;
};

void check_output_file(const fs::path& file, bool force) {
    std::error_code error;
    if (fs::is_directory(file, error)) throw FileError(file.string(), "is a folder, expected a file");
    if (fs::exists(file, error) && !force)
        throw FileError(file.string(), "is there already, expected a new file or --force");
}

/// The file appears whole or not at all.
void put_file(const fs::path& file, const std::string& text) {
    std::error_code error;
    if (file.has_parent_path()) fs::create_directories(file.parent_path(), error);
    fs::path partial = file;
    partial += ".partial";
    write_file(partial, text);
    fs::rename(partial, file, error);
    if (error) {
        fs::remove(partial, error);
        throw FileError(file.string(), "can't be put in place: " + error.message());
    }
}

/// Frames of one track that follow one another; a gap begins anew.
void learn_from(const fs::path& track, std::optional<tracker::DeformationLearner>& learner) {
    const std::vector<RecordedCurve> curves = read_recorded_curves(track);
    int last = -1;
    for (const RecordedCurve& curve : curves) {
        if (!learner) learner.emplace(static_cast<int>(curve.Q.cols()));
        if (last < 0 || curve.frame != last + 1) learner->begin_track();
        last = curve.frame;
        try {
            learner->add(curve.Q, curve.time_s);
        } catch (const std::invalid_argument& error) {
            throw FileError(track.string(), fmt::format("frame {}: {}", curve.frame, error.what()));
        }
    }
}

int learn_prior(const LearnPriorOptions& options) {
    check_output_file(options.output, options.force);
    std::vector<fs::path> folders;
    for (const std::string& folder : options.tracks)
        for (const fs::path& track : track_folders(folder)) folders.push_back(track);
    std::optional<tracker::DeformationLearner> learner;
    for (const fs::path& track : folders) learn_from(track, learner);
    tracker::DeformationPrior prior;
    try {
        if (!learner)
            throw std::invalid_argument("no frame in which the thread is seen, expected some hundred");
        prior = learner->learn(options.modes);
    } catch (const std::invalid_argument& error) {
        throw FileError(options.tracks.front(), error.what());
    }
    prior.tracks = static_cast<int>(folders.size());
    put_file(options.output, to_json_text(prior));
    if (!options.quiet) {
        fmt::print(stderr, "{} tracks, {} frames, K = {}, {:.3g} a second\n", prior.tracks, prior.frames,
                   prior.control_points, prior.frame_rate_hz);
        for (int m = 0; m < prior.count(); ++m)
            fmt::print(stderr, "mode {}: {:.4f} mm\n", m, 1e3 * prior.sigmas_m[m]);
        fmt::print(stderr, "every other: {:.4f} mm\n", 1e3 * prior.rest_sigma_m);
    }
    return kDone;
}

}  // namespace

void add_learn_prior_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand(
        "learn-prior", "learns from tracks how threads deform, for tracker.refined.prior_file");
    const auto options = std::make_shared<LearnPriorOptions>();
    app->add_option("TRACKS", options->tracks, "folders of track or run, or folders of such")->required();
    app->add_option("-o,--output", options->output, "file of the prior")->required()->type_name("FILE");
    app->add_option("--modes", options->modes, "principal components to keep")->check(CLI::Range(1, 12));
    app->add_flag("--quiet", options->quiet, "no summary on stderr");
    app->add_flag("--force", options->force, "replace the file");
    app->footer(
        "Example: atropos learn-prior results/runs -o results/prior.json\n"
        "         atropos track SEQUENCE -o DIR --set tracker.refined.prior_file=results/prior.json");
    app->callback([&chosen, options] { chosen = [options] { return learn_prior(*options); }; });
}

}  // namespace atropos::experiments
