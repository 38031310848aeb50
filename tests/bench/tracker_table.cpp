// The paper's tracker on generated sequences, as Markdown beside Table I.
//   tracker_table paper  CAMERA FOLDER [FRAMES]   Table I: accelerations 1-5, seeds 1-3; default | A | B
//   tracker_table rigs   FOLDER [FRAMES [SEEDS]]  converging and distorted rigs beside the pinhole rig
//   tracker_table starts [CURVES]                 curves found from a straight line between the ends
//   tracker_table ablation [FRAMES]               one choice changed at a time
//   tracker_table sigmas CAMERA FOLDER [FRAMES]   standard deviations, on seeds apart from those above
//   tracker_table tune   CAMERA [FRAMES]          a grid of parameters on seeds apart from those above
//   tracker_table refined [FRAMES [SEEDS [CASE]]]           the refined tracker against its bounds; SEEDS as
//   1-5 tracker_table refined-ablation [FRAMES [SEEDS [CASE]]]  one of its terms changed at a time, E1 and E2
//   beside tracker_table refined-frames [FRAMES [SEEDS [CASE]]]    one line a frame tracker_table
//   refined-worst FOLDER [FRAMES [SEEDS [CASE]]]  pictures of the ten worst frames of each case
//   tracker_table prior [FRAMES [SEEDS [CASE [FILE...]]]]  learned priors and the rod on hard rows
//   tracker_table loops  [SEQUENCES [FRAMES [SEED [verbose]]]]  threads that cross themselves
// FOLDER keeps what is done, so that an interrupted run goes on where it stopped.
#include <malloc.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <vector>

#include "tests/bench/tracker_tables.hpp"

int main(int argc, char** argv) {
    using namespace atropos::bench;
    mallopt(M_MMAP_THRESHOLD, 1 << 30);  // pictures come and go: their pages stay
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    const std::vector<std::string> words(argv + 1, argv + argc);
    const auto number = [&](std::size_t i, int otherwise) {
        return i < words.size() ? std::atoi(words[i].c_str()) : otherwise;
    };
    const auto seeds = [&](std::size_t i) {
        SeedRange range;
        if (i >= words.size()) return range;
        range.first = range.last = std::stoull(words[i]);
        if (const auto dash = words[i].find('-'); dash != std::string::npos)
            range.last = std::stoull(words[i].substr(dash + 1));
        return range;
    };
    const std::string wanted = words.size() > 3 ? words[3] : "";
    try {
        if (!words.empty() && words[0] == "refined")
            return print_refined_table(number(1, 100), seeds(2), wanted);
        if (!words.empty() && words[0] == "refined-ablation")
            return print_refined_ablation(number(1, 100), seeds(2), wanted);
        if (!words.empty() && words[0] == "refined-frames")
            return print_refined_frames(number(1, 100), seeds(2), wanted);
        if (!words.empty() && words[0] == "prior")
            return print_prior_table(
                number(1, 100), seeds(2), wanted,
                {words.begin() + std::min<long>(4, static_cast<long>(words.size())), words.end()});
        if (!words.empty() && words[0] == "loops")
            return print_loop_table({.sequences = number(1, 200),
                                     .frames = number(2, 120),
                                     .first_seed = static_cast<std::uint64_t>(number(3, 1)),
                                     .verbose = words.size() > 4});
        if (words.size() >= 2 && words[0] == "refined-worst")
            return draw_worst_frames(words[1], number(2, 100), seeds(3), words.size() > 4 ? words[4] : "");
        if (words.size() >= 3 && words[0] == "paper")
            return print_paper_table(words[1], words[2], number(3, 1000));
        if (words.size() >= 2 && words[0] == "rigs")
            return print_rig_table(words[1], number(2, 300), number(3, 12));
        if (words.size() >= 3 && words[0] == "sigmas")
            return print_sigma_table(words[1], words[2], number(3, 1000));
        if (words.size() >= 1 && words[0] == "starts") return print_start_table(number(1, 200));
        if (words.size() >= 1 && words[0] == "ablation") return print_ablation_table(number(1, 200));
        if (words.size() >= 2 && words[0] == "tune") return print_tuning(words[1], number(2, 200));
        std::fprintf(stderr,
                     "tracker_table: unknown words, expected paper or sigmas CAMERA FOLDER, rigs FOLDER, "
                     "starts, ablation, tune CAMERA, refined, refined-ablation, prior, refined-frames or "
                     "refined-worst FOLDER\n");
    } catch (const std::exception& error) {
        std::fprintf(stderr, "tracker_table: %s\n", error.what());
    }
    return 2;
}
