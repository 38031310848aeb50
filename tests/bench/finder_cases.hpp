#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/thread_estimate.hpp"
#include "tests/bench/image_line.hpp"
#include "tests/support/synthetic_sequence.hpp"
#include "tracker/thread_finder.hpp"

namespace atropos::bench {

struct FinderTableOptions {
    std::string data;      ///< folder that holds stereo-pairs/
    std::string pictures;  ///< folder for the curves drawn over the images; empty: none
    int frames = 200;
    int first_seed = 1;
    bool verbose = false;
};

/// Tables as Markdown on the standard output: pairs of real and of rendered images; generated and
/// rendered frames without and with crossings; the refined tracker on generated sequences of which no end is
/// measured.
void print_real_pairs(const FinderTableOptions& options);
void print_rendered_pairs(const FinderTableOptions& options);
void print_generated(const FinderTableOptions& options);
void print_rendered(const FinderTableOptions& options);
void print_on_pad(const FinderTableOptions& options);
void print_tracked(const FinderTableOptions& options);

/// What the finder found, and the least processor time of some runs after the first.
struct TimedFind {
    std::optional<tracker::FoundThread> found;
    double ms = 0.0;
};
TimedFind timed_find(const scenes::StereoRig& rig, const tracker::StereoFrame& frame, int runs,
                     const scenes::TrackerConfig& config = {});

const char* name(tracker::Doubt doubt);
scenes::ThreadEstimate estimate_of(const tracker::FoundThread& found);
double median(std::vector<double> values);

/// A line in C (m) as either eye sees it.
std::array<ImageLine, 2> images_of(const scenes::Polyline& line_C, const scenes::StereoRig& rig);
/// The curve as an eye (0 left, 1 right) sees it, densely.
ImageLine image_of(const tracker::FoundThread& found, int eye);

/// Both eyes side by side, twice their size: the reference blue, the curve green with a ring at its start.
void draw(const std::filesystem::path& file, const tracker::StereoFrame& frame,
          const tracker::FoundThread& found, const std::array<ImageLine, 2>& reference);

/// A thread and its motion by the seed; with crossings, one that turns into a loop.
support::SyntheticSequenceOptions finder_sequence(std::uint64_t seed, int crossings);

/// The part of a generated thread that its instruments leave to be seen: their noses are round, of 1.6 mm.
scenes::Polyline visible_part(const scenes::Polyline& truth,
                              const support::SyntheticSequenceOptions& options);

}  // namespace atropos::bench
