// The finder on generated frames: how often it is right, and whether it knows.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "experiments/metrics.hpp"
#include "scenes/random_stream.hpp"
#include "tests/bench/finder_cases.hpp"
#include "tests/support/tracking_trial.hpp"

namespace atropos::bench {
namespace fs = std::filesystem;
namespace {

constexpr double kRight_px = 8.0;  // discrete Frechet distance, in both eyes

struct Case {
    const char* name;
    bool clutter;
    int crossings;
};

struct Tally {
    int frames = 0, right = 0, sure_right = 0, sure_wrong = 0;
    std::vector<double> lengths_percent, times_ms;
};

/// One frame with the instruments' poses known and no end measured; nothing when its thread leaves the image
/// or crosses itself in other numbers than the case wants.
struct Drawn {
    scenes::StereoRig rig;
    tracker::StereoFrame frame;
    scenes::Polyline visible_C;
    std::array<ImageLine, 2> visible_px;
};
std::optional<Drawn> draw_case(const Case& which, std::uint64_t seed) {
    support::SyntheticSequenceOptions options{.seed = seed, .clutter = which.clutter};
    if (which.crossings > 0) {
        scenes::RandomStream random(seed, "finder table");
        options.turning_rad = random.uniform(4.0, 5.2);
        options.turning_share = random.uniform(0.35, 0.6);
    }
    const support::SyntheticSequence sequence(options);
    Drawn drawn;
    drawn.rig = options.rig;
    drawn.visible_C = visible_part(sequence.truth(0), options);
    drawn.visible_px = images_of(drawn.visible_C, options.rig);
    for (const ImageLine& line : drawn.visible_px)
        if (self_crossings(line) != which.crossings) return std::nullopt;
    for (const Eigen::Vector2d& p : drawn.visible_px[0])
        if (!options.rig.left.contains(p)) return std::nullopt;
    drawn.frame = support::stereo_frame(sequence.frame(0), 0);
    drawn.frame.tips = {};
    return drawn;
}

/// Of the found curve from what is to be seen, in the worse eye, from whichever end it begins.
double off_px(const tracker::FoundThread& found, const Drawn& drawn) {
    double off = 0.0;
    for (const std::size_t eye : {0, 1}) {
        const ImageLine line = image_of(found, static_cast<int>(eye));
        ImageLine thin;
        for (std::size_t i = 0; i < line.size(); i += 5) thin.push_back(line[i]);
        const double forwards = frechet_px(thin, drawn.visible_px[eye]);
        std::reverse(thin.begin(), thin.end());
        off = std::max(off, std::min(forwards, frechet_px(thin, drawn.visible_px[eye])));
    }
    return off;
}

void add(const FinderTableOptions& options, const Case& which, std::uint64_t seed, const Drawn& drawn,
         Tally& tally) {
    const auto [found, ms] = timed_find(drawn.rig, drawn.frame, 1);
    ++tally.frames;
    tally.times_ms.push_back(ms);
    if (!found) {
        if (options.verbose) fmt::print("  seed {}: nothing found\n", seed);
        return;
    }
    const double off = off_px(*found, drawn);
    const bool right = off <= kRight_px, sure = found->doubt == tracker::Doubt::kNone;
    if (sure) ++(right ? tally.sure_right : tally.sure_wrong);
    if (options.verbose && !(right && sure))
        fmt::print("  seed {}: {:.1f} px, doubt {}, score {:.2f}\n", seed, off, name(found->doubt),
                   found->score);
    if (right) {
        ++tally.right;
        tally.lengths_percent.push_back(std::abs(
            experiments::compare(estimate_of(*found), drawn.visible_C, drawn.rig).length_error_percent));
    } else if (!options.pictures.empty()) {
        draw(fs::path(options.pictures) / fmt::format("{}_{}.png", which.crossings, seed), drawn.frame,
             *found, drawn.visible_px);
    }
}

void print_case(const FinderTableOptions& options, const Case& which) {
    Tally tally;
    for (auto seed = static_cast<std::uint64_t>(options.first_seed); tally.frames < options.frames; ++seed)
        if (const std::optional<Drawn> drawn = draw_case(which, seed))
            add(options, which, seed, *drawn, tally);
    const auto percent = [&](int count) { return 100.0 * count / std::max(tally.frames, 1); };
    fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {:.1f} % | {:.1f} % | {:.0f} |\n", which.name, tally.frames,
               percent(tally.right), percent(tally.sure_right), percent(tally.sure_wrong),
               median(tally.lengths_percent), median(tally.times_ms));
}

}  // namespace

void print_generated(const FinderTableOptions& options, bool plain, bool crossing) {
    fmt::print(
        "\n| generated | frames | right | sure and right | sure and wrong | length error | ms |\n"
        "|---|---|---|---|---|---|---|\n");
    for (const Case& which : {Case{"no crossing, even ground", false, 0},
                              {"no crossing, cluttered", true, 0},
                              {"one crossing, even ground", false, 1},
                              {"one crossing, cluttered", true, 1}})
        if (which.crossings == 0 ? plain : crossing) print_case(options, which);
}

}  // namespace atropos::bench
