#include "experiments/external_tracker.hpp"

#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cerrno>
#include <cmath>

#include "scenes/stereo_rig.hpp"
#include "tests/experiments/temporary_folder.hpp"

namespace atropos::experiments {
namespace {
using scenes::TrackStatus;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kWidth = 32, kHeight = 24;
const char* const kGood =
    R"(echo "{\"frame\":$n,\"status\":\"tracking\",\"curve_mm\":[[0,0,100],[10,0,100],[10,$n.5,100]]}")";

/// A child that reads frames as it should and then runs `body` with the frame's number in $n.
std::string child(const std::string& body) {
    return "while read -r line; do n=${line#*:}; n=${n%%,*}; head -c " +
           std::to_string(2 * kWidth * kHeight) + " >/dev/null; " + body + "; done";
}

struct Answers {
    std::string statuses;  ///< t, c or l a frame
    std::string log;
    tracker::TrackResult last;
};

Answers run(const std::string& command, int frames, double timeout_s = 20.0) {
    const scenes::StereoRig rig = scenes::parallel_rig(kWidth, kHeight, 30.0, 0.005);
    Answers answers;
    {
        const auto tracker = make_external_tracker({command, timeout_s, 3}, rig, answers.log, true);
        for (int i = 0; i < frames; ++i) {
            tracker::StereoFrame frame;
            frame.index = i;
            frame.capture_time_s = 0.1 * i;
            frame.left = cv::Mat(kHeight, kWidth, CV_8U, cv::Scalar(7));
            frame.right = frame.left.clone();
            answers.last = tracker->track(frame);
            answers.statuses += scenes::to_string(answers.last.estimate.status)[0];
            EXPECT_EQ(answers.last.frame, i);
            EXPECT_EQ(answers.last.estimate.capture_time_s, 0.1 * i);
        }
    }
    EXPECT_TRUE(waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD) << "a zombie is left";
    return answers;
}

TEST(ExternalTracker, takes_the_curve_that_the_child_answers) {
    const Answers answers = run(child(kGood), 3);
    EXPECT_EQ(answers.statuses, "ttt");
    EXPECT_THAT(answers.log, IsEmpty());
    const auto& samples = answers.last.estimate.samples;
    ASSERT_EQ(samples.size(), 3u);
    EXPECT_NEAR(samples[2].p_C.y(), 0.0025, 1e-15);
    EXPECT_NEAR(answers.last.estimate.length_m(), 0.0125, 1e-15);
}

TEST(ExternalTracker, hands_over_time_sizes_calibration_and_pixels) {
    const std::string checks =
        R"(case "$line" in *'"time_s":0.1,"width":32,"height":24,"channels":1,"calibration":{"M1":[[30.0,0.0,'*'"tips":[null,null]'*) )" +
        std::string(kGood) + R"(;; *) echo "{\"frame\":$n,\"status\":\"lost\"}";; esac)";
    EXPECT_EQ(run(child(checks), 2).statuses, "lt") << "frame 1 alone is at 0.1 s";
    const std::string pixels =
        "read -r line; head -c 1536 | tr -d '\\007' | wc -c | "
        "sed 's/\\(.*\\)/{\"frame\":0,\"status\":\"coasting\",\"curve_mm\":[[\\1,0,9],[1,1,9]]}/'";
    const Answers answers = run(pixels, 1);
    EXPECT_EQ(answers.statuses, "c");
    EXPECT_EQ(answers.last.estimate.samples.front().p_C.x(), 0.0) << "bytes other than the pictures' 7";
}

TEST(ExternalTracker, that_hangs_costs_the_frame_it_hangs_in) {
    const Answers answers = run(child("[ $n = 1 ] && sleep 100; " + std::string(kGood)), 4, 3.0);
    EXPECT_EQ(answers.statuses, "tltt");
    EXPECT_EQ(answers.log, "frame 1: lost: no answer within 3 s\n");
}

TEST(ExternalTracker, that_crashes_costs_the_frame_it_crashes_in) {
    EXPECT_EQ(run(child("[ $n = 1 ] && kill -SEGV $$; " + std::string(kGood)), 4).statuses, "tltt");
    const Answers answers = run(child("[ $n = 1 ] && exit 3; " + std::string(kGood)), 4);
    EXPECT_EQ(answers.statuses, "tltt");
    EXPECT_EQ(answers.log, "frame 1: lost: the tracker ended or closed its pipe\n");
}

TEST(ExternalTracker, that_closes_a_pipe_costs_its_frame) {
    EXPECT_EQ(run(child("[ $n = 1 ] && exec >&-; " + std::string(kGood)), 4).statuses, "tltt");
    EXPECT_EQ(run(child(std::string(kGood) + "; [ $n = 1 ] && exec <&-"), 5).statuses, "ttltt");
}

TEST(ExternalTracker, that_prints_rubbish_costs_the_frames_of_its_rubbish) {
    const std::pair<std::string, std::string> cases[] = {
        {"hello", "expected a JSON line"},
        {"[1]", "expected a JSON line"},
        {R"({\"frame\":1})", "lacks status"},
        {R"({\"frame\":1,\"status\":\"fine\"})", "status is 'fine'"},
        {R"({\"frame\":1,\"status\":\"tracking\"})", "lacks status or curve_mm"},
        {R"({\"frame\":1,\"status\":\"tracking\",\"curve_mm\":[[0,0,9]]})", "1 points"},
        {R"({\"frame\":1,\"status\":\"tracking\",\"curve_mm\":[[0,0,9],[0,9]]})", "not x, y, z"},
        {R"({\"frame\":1,\"status\":\"tracking\",\"curve_mm\":[[0,0,9],[0,1,-9]]})", "not before the camera"},
        {R"({\"frame\":1,\"status\":\"tracking\",\"curve_mm\":[[0,0,9],[0,0,9]]})", "twice in a row"},
        {R"({\"frame\":1,\"status\":\"tracking\",\"curve_mm\":[[0,0,9],[0,1,null]]})",
         "lacks status or curve_mm"},
        {R"({\"frame\":1,\"status\":\"tracking\",\"curve_mm\":[[0,0,9],[1,0,9]],\"sigma_depth_mm\":[1]})",
         "sigma_depth_mm has 1 numbers"},
        {R"({\"frame\":1,\"status\":\"tracking\",\"curve_mm\":[[0,0,9],[1,0,9]],\"confidence\":7})",
         "confidence"},
    };
    for (const auto& [rubbish, why] : cases) {
        const Answers answers =
            run(child("if [ $n = 1 ]; then echo \"" + rubbish + "\"; else " + kGood + "; fi"), 3);
        EXPECT_EQ(answers.statuses, "tlt") << rubbish;
        EXPECT_THAT(answers.log, HasSubstr("frame 1: lost: ")) << rubbish;
        EXPECT_THAT(answers.log, HasSubstr(why)) << rubbish;
    }
}

TEST(ExternalTracker, that_greets_is_late_by_no_more_than_the_greeting) {
    EXPECT_EQ(run("echo welcome; " + child(kGood), 3).statuses, "ltt");
}

TEST(ExternalTracker, that_floods_its_pipe_or_does_not_exist_is_given_up) {
    const Answers flood = run("yes '{\"x\":1' | tr -d '\\n'", 5);
    EXPECT_EQ(flood.statuses, "lllll");
    EXPECT_THAT(flood.log, HasSubstr("an answer without an end"));
    const Answers nothing = run("exec /no/such/tracker 2>/dev/null", 5);
    EXPECT_EQ(nothing.statuses, "lllll");
    EXPECT_THAT(nothing.log, HasSubstr("frame 2: given up after 3 starts without an answer"));
}

TEST(ExternalTracker, that_talks_before_it_listens_blocks_nobody) {
    const std::string talk = "head -c 3000000 /dev/zero | tr '\\0' ' '; ";
    EXPECT_EQ(run(talk + child(kGood), 2).statuses, "tt") << "blanks before the first answer's brace";
}

}  // namespace
}  // namespace atropos::experiments
