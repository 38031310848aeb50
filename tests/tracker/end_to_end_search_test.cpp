#include "tracker/end_to_end_search.hpp"

#include <gtest/gtest.h>

#include "tests/support/synthetic_sequence.hpp"

namespace atropos::tracker {
namespace {

using support::SyntheticFrame;
using support::SyntheticSequence;
using support::SyntheticSequenceOptions;

/// A thread of 70 mm that crosses itself over clutter.
SyntheticSequenceOptions loop(std::uint64_t seed) {
    SyntheticSequenceOptions options{.seed = seed};
    options.turning_rad = 4.7;
    options.turning_share = 0.45;
    return options;
}

StereoFrame frame_of(const SyntheticFrame& drawn) {
    StereoFrame frame;
    frame.left = drawn.left;
    frame.right = drawn.right;
    for (std::size_t end = 0; end < 2; ++end) frame.tips[end] = MeasuredTip{drawn.tips_C[end]};
    frame.instruments = drawn.instruments_C;
    return frame;
}

/// Mean distance of points at the same share of arc length: what takes the loop the other way round is far
/// off.
double order_error_m(const scenes::Polyline& line, const scenes::Polyline& truth) {
    constexpr int kPoints = 101;
    const scenes::Polyline a = line.resampled(kPoints), b = truth.resampled(kPoints);
    double sum = 0.0;
    for (std::size_t i = 0; i < a.points.size(); ++i) sum += (a.points[i] - b.points[i]).norm();
    return sum / kPoints;
}

TEST(EndToEndSearch, follows_a_loop_over_clutter_the_right_way_round) {
    for (const std::uint64_t seed : {11, 12}) {
        const SyntheticSequenceOptions options = loop(seed);
        const SyntheticFrame drawn = SyntheticSequence(options).frame(0);
        const auto line = EndToEndSearch(options.rig).find(frame_of(drawn), options.length_m);
        ASSERT_TRUE(line) << seed;
        EXPECT_LT(order_error_m(*line, drawn.truth_C), 0.003) << seed;
    }
}

TEST(EndToEndSearch, goes_on_behind_an_instrument) {
    SyntheticSequenceOptions options = loop(13);
    options.occlusion_begin = 0;
    options.occluded_share = 0.04;
    const SyntheticFrame drawn = SyntheticSequence(options).frame(options.occlusion_frames / 2);
    const auto line = EndToEndSearch(options.rig).find(frame_of(drawn), options.length_m);
    ASSERT_TRUE(line);
    EXPECT_LT(order_error_m(*line, drawn.truth_C), 0.003);
}

TEST(EndToEndSearch, finds_nothing_of_another_length) {
    const SyntheticSequenceOptions options = loop(11);
    const SyntheticFrame drawn = SyntheticSequence(options).frame(0);
    EndToEndSearch search(options.rig);
    for (const double share : {0.8, 1.3})
        EXPECT_FALSE(search.find(frame_of(drawn), share * options.length_m));
    EXPECT_FALSE(search.find(frame_of(drawn), 0.0));
}

TEST(EndToEndSearch, finds_nothing_where_no_thread_is_or_an_end_is_unknown) {
    const SyntheticSequenceOptions options = loop(11);
    StereoFrame frame = frame_of(SyntheticSequence(options).frame(0));
    EndToEndSearch search(options.rig);
    frame.tips[1].reset();
    EXPECT_FALSE(search.find(frame, options.length_m));
    frame = frame_of(SyntheticSequence(options).frame(0));
    frame.left = cv::Mat1b::zeros(frame.left.size());
    frame.right = cv::Mat1b::zeros(frame.right.size());
    EXPECT_FALSE(search.find(frame, options.length_m));
}

}  // namespace
}  // namespace atropos::tracker
