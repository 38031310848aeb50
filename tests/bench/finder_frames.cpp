// How often the finder is right on frames of a kind, and whether it knows.
#include "tests/bench/finder_frames.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/metrics.hpp"

namespace atropos::bench {
namespace fs = std::filesystem;
namespace {

constexpr double kRight_px = 8.0;  // discrete Frechet distance, in both eyes

struct Tally {
    int frames = 0, right = 0, sure_right = 0, sure_wrong = 0;
    std::vector<double> lengths_percent, times_ms;
};

/// Of the found curve from what is to be seen, in the worse eye, from whichever end it begins.
double off_px(const tracker::FoundThread& found, const FinderFrame& drawn) {
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

/// What is wrong with it, in the left eye: how far it strays, and what is missing at either end of the truth.
std::string where_wrong(const tracker::FoundThread& found, const FinderFrame& drawn) {
    const ImageLine line = image_of(found, 0), &truth = drawn.visible_px[0];
    const auto distance = [](const Eigen::Vector2d& p, const ImageLine& to) {
        double least = 1e9;
        for (const Eigen::Vector2d& q : to) least = std::min(least, (p - q).norm());
        return least;
    };
    double strays = 0.0;
    for (std::size_t i = 0; i < line.size(); i += 5) strays = std::max(strays, distance(line[i], truth));
    const auto missing = [&](auto begin, auto end) {
        double length = 0.0;
        for (; begin + 1 != end && distance(*begin, line) > 3.0; ++begin)
            length += (begin[1] - begin[0]).norm();
        return length;
    };
    return fmt::format("strays {:.0f} px, misses {:.0f} and {:.0f} px at the ends", strays,
                       missing(truth.begin(), truth.end()), missing(truth.rbegin(), truth.rend()));
}

void add(const FinderTableOptions& options, const char* kind, std::uint64_t seed, const FinderFrame& drawn,
         Tally& tally) {
    const auto [found, ms] = timed_find(drawn.rig, drawn.frame, 1, drawn.config);
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
        fmt::print("  seed {}: {:.1f} px, {}, doubt {}, score {:.2f}\n", seed, off,
                   where_wrong(*found, drawn), name(found->doubt), found->score);
    if (right) {
        ++tally.right;
        tally.lengths_percent.push_back(std::abs(
            experiments::compare(estimate_of(*found), drawn.visible_C, drawn.rig).length_error_percent));
    } else if (!options.pictures.empty()) {
        draw(fs::path(options.pictures) / fmt::format("{} {}.png", kind, seed), drawn.frame, *found,
             drawn.visible_px);
    }
}

void print_case(const FinderTableOptions& options, const FinderCase& which) {
    Tally tally;
    for (auto seed = static_cast<std::uint64_t>(options.first_seed); tally.frames < options.frames; ++seed)
        if (const std::optional<FinderFrame> drawn = which.draw(seed))
            add(options, which.name, seed, *drawn, tally);
    const auto percent = [&](int count) { return 100.0 * count / std::max(tally.frames, 1); };
    fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {:.1f} % | {:.1f} % | {:.0f} |\n", which.name, tally.frames,
               percent(tally.right), percent(tally.sure_right), percent(tally.sure_wrong),
               median(tally.lengths_percent), median(tally.times_ms));
    std::fflush(stdout);
}

}  // namespace

void print_cases(const FinderTableOptions& options, const std::vector<FinderCase>& cases) {
    fmt::print(
        "\n| frames of one kind | frames | right | sure and right | sure and wrong | length error | ms |\n"
        "|---|---|---|---|---|---|---|\n");
    for (const FinderCase& which : cases) print_case(options, which);
}

bool is_whole(const std::array<ImageLine, 2>& line_px, const scenes::StereoRig& rig, int crossings) {
    for (const std::size_t eye : {0, 1}) {
        if (self_crossings(line_px[eye]) != crossings) return false;
        for (const Eigen::Vector2d& p : line_px[eye])
            if (!(eye == 0 ? rig.left : rig.right).contains(p)) return false;
    }
    return true;
}

}  // namespace atropos::bench
