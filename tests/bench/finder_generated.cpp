// The finder on frames of the tests' own generator, instruments' poses known.
#include "scenes/random_stream.hpp"
#include "tests/bench/finder_frames.hpp"
#include "tests/support/tracking_trial.hpp"

namespace atropos::bench {

support::SyntheticSequenceOptions finder_sequence(std::uint64_t seed, int crossings) {
    support::SyntheticSequenceOptions options{.seed = seed};
    if (crossings > 0) {
        scenes::RandomStream random(seed, "finder table");
        options.turning_rad = random.uniform(4.0, 5.2);
        options.turning_share = random.uniform(0.35, 0.6);
    }
    return options;
}

namespace {

/// Nothing when the thread leaves the image or crosses itself in other numbers.
std::optional<FinderFrame> draw_case(bool clutter, int crossings, std::uint64_t seed) {
    support::SyntheticSequenceOptions options = finder_sequence(seed, crossings);
    options.clutter = clutter;
    const support::SyntheticSequence sequence(options);
    FinderFrame drawn{.rig = options.rig, .frame = {}, .visible_C = visible_part(sequence.truth(0), options)};
    drawn.visible_px = images_of(drawn.visible_C, options.rig);
    if (!is_whole(drawn.visible_px, drawn.rig, crossings)) return std::nullopt;
    drawn.frame = support::stereo_frame(sequence.frame(0), 0);
    drawn.frame.tips = {};
    return drawn;
}

FinderCase generated(const char* name, bool clutter, int crossings) {
    return {name, [=](std::uint64_t seed) { return draw_case(clutter, crossings, seed); }};
}

}  // namespace

void print_generated(const FinderTableOptions& options) {
    print_cases(
        options,
        {generated("no crossing, even ground", false, 0), generated("no crossing, cluttered", true, 0),
         generated("one crossing, even ground", false, 1), generated("one crossing, cluttered", true, 1)});
}

}  // namespace atropos::bench
