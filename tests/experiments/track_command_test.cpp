// The program itself on good and bad sequences: what it says, its exit status, and what it writes.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "experiments/track_reader.hpp"
#include "scenes/calibration_file.hpp"
#include "tests/experiments/temporary_folder.hpp"
#include "tests/support/synthetic_sequence.hpp"

namespace atropos::experiments {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

const scenes::StereoRig kRig = scenes::parallel_rig(320, 180, 287.5, 0.005);

class TrackCommandTest : public TemporaryFolder {
  protected:
    struct Outcome {
        int status;
        std::string complaint;
    };

    /// `frames` pictures of a moving thread with measured ends, as a folder.
    fs::path sequence(int frames = 1) const {
        static const support::SyntheticSequence drawn({.seed = 7, .rig = kRig});
        const fs::path folder = folder_ / "sequence";
        write("sequence/calib/stereo.yaml", scenes::to_opencv_yaml(kRig));
        std::ostringstream tips;
        tips << "frame,end,kind,x_mm,y_mm,z_mm\n";
        fs::create_directories(folder / "left");
        fs::create_directories(folder / "right");
        for (int i = 0; i < frames; ++i) {
            const support::SyntheticFrame frame = drawn.frame(i);
            cv::imwrite(picture("left", i), frame.left);
            cv::imwrite(picture("right", i), frame.right);
            for (std::size_t end = 0; end < 2; ++end)
                tips << i << ',' << end << ",held," << 1e3 * frame.tips_C[end].x() << ','
                     << 1e3 * frame.tips_C[end].y() << ',' << 1e3 * frame.tips_C[end].z() << '\n';
        }
        write("sequence/tips.csv", tips.str());
        return folder;
    }

    /// The same without instruments on even ground, and no end measured.
    void bare_sequence(int frames) const {
        sequence(frames);
        fs::remove(folder_ / "sequence/tips.csv");
        for (int i = 0; i < frames; ++i) show_bare(i, 7);
    }

    void show_bare(int frame, std::uint64_t seed) const {
        const support::SyntheticSequence drawn(
            {.seed = seed, .rig = kRig, .clutter = false, .instruments = false});
        const support::SyntheticFrame images = drawn.frame(frame);
        cv::imwrite(picture("left", frame), images.left);
        cv::imwrite(picture("right", frame), images.right);
    }

    /// The status of each frame.
    std::vector<std::string> statuses() const {
        std::vector<std::string> list;
        for (const TrackedFrame& frame : read_track(folder_ / "track"))
            list.emplace_back(scenes::to_string(frame.estimate.status));
        return list;
    }

    std::string picture(const std::string& eye, int frame) const {
        const std::string number = std::to_string(frame);
        return (folder_ / "sequence" / eye / (std::string(6 - number.size(), '0') + number + ".png"))
            .string();
    }

    Outcome track(const std::string& words = "--method e2", const std::string& to = "track") const {
        const fs::path complaint = folder_ / "complaint.txt";
        const auto quoted = [](const fs::path& path) { return "'" + path.string() + "'"; };
        const std::string command = quoted(ATROPOS_PROGRAM) + " track " + quoted(folder_ / "sequence") +
                                    " -o " + quoted(folder_ / to) + " --quiet " + words + " 2> " +
                                    quoted(complaint);
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read(complaint)};
    }

    /// Exit status 2, one line that holds `what`, and no output.
    void expect_refused(const std::string& what) const {
        const Outcome outcome = track();
        EXPECT_EQ(outcome.status, 2) << what;
        EXPECT_THAT(outcome.complaint, HasSubstr(what));
        EXPECT_EQ(std::count(outcome.complaint.begin(), outcome.complaint.end(), '\n'), 1)
            << outcome.complaint;
        EXPECT_FALSE(fs::exists(folder_ / "track"));
    }
};

TEST_F(TrackCommandTest, refuses_a_missing_eye) {
    fs::remove_all(sequence() / "right");
    expect_refused("right: no such folder");
}

TEST_F(TrackCommandTest, refuses_eyes_of_different_counts) {
    sequence(2);
    fs::remove(picture("right", 1));
    expect_refused("2 left and 1 right");
}

TEST_F(TrackCommandTest, refuses_pictures_of_another_size) {
    sequence();
    cv::imwrite(picture("right", 0), cv::Mat1b(90, 160, std::uint8_t{100}));
    expect_refused("160x90");
}

TEST_F(TrackCommandTest, refuses_pictures_of_one_pixel) {
    const fs::path folder = sequence();
    cv::imwrite(picture("left", 0), cv::Mat1b(1, 1, std::uint8_t{100}));
    cv::imwrite(picture("right", 0), cv::Mat1b(1, 1, std::uint8_t{100}));
    expect_refused("1x1");
    write("sequence/calib/stereo.yaml", scenes::to_opencv_yaml(scenes::parallel_rig(1, 1, 575.0, 0.005)));
    expect_refused("1x1");
}

TEST_F(TrackCommandTest, refuses_pictures_of_16_bit) {
    sequence();
    cv::imwrite(picture("left", 0), cv::Mat1w(180, 320, std::uint16_t{1000}));
    expect_refused("16");
}

TEST_F(TrackCommandTest, refuses_corrupt_pictures) {
    sequence();
    std::string bytes = read(picture("left", 0));
    bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
    write("sequence/left/000000.png", bytes);
    expect_refused("000000.png");
    write("sequence/left/000000.png", bytes.substr(0, bytes.size() / 3));
    expect_refused("000000.png");
    write("sequence/left/000000.png", "");
    expect_refused("000000.png");
}

TEST_F(TrackCommandTest, refuses_ends_that_are_no_numbers_or_behind_the_camera) {
    sequence();
    const std::string head = "frame,end,kind,x_mm,y_mm,z_mm\n";
    write("sequence/tips.csv", head + "0,0,held,1,nan,100\n");
    expect_refused("tips.csv:2");
    write("sequence/tips.csv", head + "0,1,held,1,2,-100\n");
    expect_refused("behind");
}

TEST_F(TrackCommandTest, refuses_a_sequence_of_no_frames) {
    sequence();
    fs::remove(picture("left", 0));
    fs::remove(picture("right", 0));
    expect_refused("no pictures");
}

TEST_F(TrackCommandTest, says_lost_where_there_is_no_thread) {
    sequence(3);
    for (const int level : {0, 140})
        for (const char* method : {"e1", "e2", "refined"}) {
            for (const char* eye : {"left", "right"})
                for (int i = 0; i < 3; ++i)
                    cv::imwrite(picture(eye, i), cv::Mat1b(180, 320, static_cast<std::uint8_t>(level)));
            EXPECT_EQ(track(std::string("--force --method ") + method).status, 0);
            const std::string frames = read(folder_ / "track/frames.csv");
            EXPECT_EQ(std::count(frames.begin(), frames.end(), '\n'), 4);
            EXPECT_THAT(frames, HasSubstr("lost"));
            EXPECT_THAT(frames, Not(HasSubstr("tracking")));
            EXPECT_THAT(frames, Not(HasSubstr("nan")));
        }
}

TEST_F(TrackCommandTest, tracks_a_sequence_of_one_frame) {
    sequence(1);
    for (const char* method : {"e1", "e2", "refined"}) {
        EXPECT_EQ(track(std::string("--force --set tracker.thread.length_mm=70 --method ") + method).status,
                  0);
        EXPECT_THAT(read(folder_ / "track/frames.csv"), HasSubstr("tracking")) << method;
        const std::string curve = read(folder_ / "track/track.csv");
        EXPECT_EQ(std::count(curve.begin(), curve.end(), '\n'), 102);
        EXPECT_THAT(curve, Not(HasSubstr("nan")));
    }
}

TEST_F(TrackCommandTest, finds_a_thread_of_which_no_end_is_measured_and_finds_it_elsewhere_once_lost) {
    constexpr int kFrames = 30;
    bare_sequence(kFrames);
    for (int i = 1; i + 2 < kFrames; ++i)
        for (const char* eye : {"left", "right"})
            cv::imwrite(picture(eye, i), cv::Mat1b(180, 320, std::uint8_t{150}));
    for (const int i : {kFrames - 2, kFrames - 1}) show_bare(i, 3);
    for (const char* method : {"e2", "refined"}) {
        EXPECT_EQ(track(std::string("--force --method ") + method).status, 0);
        const std::vector<std::string> status = statuses();
        ASSERT_EQ(status.size(), static_cast<std::size_t>(kFrames));
        EXPECT_EQ(status.front(), "tracking") << method;
        EXPECT_NE(status[kFrames - 3], "tracking") << method;
        EXPECT_EQ(status[kFrames - 2], "tracking") << method;
        EXPECT_EQ(status.back(), "tracking") << method;
    }
}

TEST_F(TrackCommandTest, starts_only_at_the_given_point) {
    bare_sequence(1);
    const support::SyntheticSequence drawn({.seed = 7, .rig = kRig});
    const Eigen::Vector2d on = kRig.project_left(drawn.truth(0).point_at(0.03));
    const auto at = [&](double u, double v) {
        EXPECT_EQ(track("--force --seed-point " + std::to_string(u) + "," + std::to_string(v)).status, 0);
        return statuses();
    };
    EXPECT_THAT(at(on.x(), on.y()), ElementsAre("tracking"));
    EXPECT_THAT(at(2.0, 2.0), ElementsAre("lost"));
    for (const char* outside : {"9999,1", "-1,5", "nan,5"})
        EXPECT_EQ(track(std::string("--force --seed-point=") + outside).status, 2) << outside;
}

TEST_F(TrackCommandTest, gives_the_same_bytes_without_the_truth) {
    const fs::path folder = sequence(3);
    write("sequence/truth/thread.csv",
          "frame,strand,i,s_mm,in_span,x_mm,y_mm,z_mm,u_left_px,v_left_px,u_right_px,v_right_px,visible_left,"
          "visible_right\n0,0,0,0,1,1,2,100,10,10,10,10,1,1\n");
    ASSERT_EQ(track("--method e2", "with").status, 0);
    fs::remove_all(folder / "truth");
    ASSERT_EQ(track("--method e2", "without").status, 0);
    for (const char* file : {"track.csv", "control_points.csv", "frames.csv", "meta.json"})
        EXPECT_EQ(read(folder_ / "with" / file), read(folder_ / "without" / file)) << file;
    EXPECT_GT(read(folder_ / "with/track.csv").size(), 1000u);
}

}  // namespace
}  // namespace atropos::experiments
