#include <gmock/gmock.h>

#include <opencv2/imgcodecs.hpp>

#include "experiments/csv_file.hpp"
#include "experiments/knot_ends.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/sequence.hpp"
#include "experiments/sha256.hpp"
#include "experiments/track_reader.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"
#include "tests/experiments/temporary_folder.hpp"

namespace atropos::experiments {
namespace {
namespace fs = std::filesystem;
using scenes::FileError;
using testing::HasSubstr;

template <class Action>
std::string error_of(const Action& action) {
    try {
        action();
    } catch (const FileError& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return error.what();
    }
    return "no error";
}

class OutputFolderTest : public TemporaryFolder {};
class CsvFileTest : public TemporaryFolder {};
class PictureFileTest : public TemporaryFolder {};
class TrackReaderTest : public TemporaryFolder {};
class ChecksumTest : public TemporaryFolder {};

TEST_F(OutputFolderTest, appears_whole_or_not_at_all) {
    {
        OutputFolder output(folder_ / "a", false);
        write_file(output.path() / "x", "1");
        EXPECT_FALSE(fs::exists(folder_ / "a"));
    }
    EXPECT_TRUE(fs::is_empty(folder_)) << "an abandoned output leaves nothing";
    OutputFolder output(folder_ / "a", false);
    write_file(output.path() / "x", "1");
    output.commit();
    EXPECT_EQ(read(folder_ / "a/x"), "1");
    EXPECT_FALSE(fs::exists(folder_ / "a.partial"));
}

TEST_F(OutputFolderTest, refuses_a_folder_with_something_in_it_unless_forced) {
    write("a/old", "1");
    EXPECT_THAT(error_of([&] { check_output(folder_ / "a", false); }), HasSubstr("not empty"));
    OutputFolder output(folder_ / "a/", true);
    output.commit();
    EXPECT_FALSE(fs::exists(folder_ / "a/old"));
    write("file", "1");
    EXPECT_THAT(error_of([&] { check_output(folder_ / "file", true); }), HasSubstr("is a file"));
}

TEST_F(CsvFileTest, reads_numbers_and_names_the_line_of_what_is_wrong) {
    const fs::path file = write("a.csv", "a,b\n1,2.5\r\n\n3,x\n4,nan\n");
    const CsvFile csv = CsvFile::read(file, "a,b");
    ASSERT_EQ(csv.rows(), 3u);
    EXPECT_EQ(csv.integer(0, 0, 0, 9), 1);
    EXPECT_DOUBLE_EQ(csv.number(0, 1), 2.5);
    EXPECT_THAT(error_of([&] { csv.number(1, 1); }), HasSubstr("a.csv:4: b is 'x'"));
    EXPECT_THAT(error_of([&] { csv.number(2, 1); }), HasSubstr("finite"));
    EXPECT_THAT(error_of([&] { csv.integer(1, 0, 0, 2); }), HasSubstr("from 0 to 2"));
}

TEST_F(CsvFileTest, refuses_other_columns_and_short_rows) {
    EXPECT_THAT(error_of([&] { CsvFile::read(write("a.csv", "a,c\n"), "a,b"); }),
                HasSubstr("a.csv:1: columns are 'a,c'"));
    EXPECT_THAT(error_of([&] { CsvFile::read(write("a.csv", "a,b\n1\n"), "a,b"); }),
                HasSubstr("a.csv:2: 1 fields, expected 2"));
    EXPECT_THAT(error_of([&] { CsvFile::read(folder_ / "none.csv", "a,b"); }), HasSubstr("no such file"));
}

TEST_F(ChecksumTest, of_a_file_is_that_of_its_bytes_whatever_its_length) {
    for (const std::size_t size : {0, 1, 63, 64, 65535, 65536, 65537, 200000}) {
        std::string bytes(size, ' ');
        for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 31 % 251);
        EXPECT_EQ(sha256_of_file(write("bytes", bytes)), sha256(bytes)) << size;
    }
}

TEST(Sha256, agrees_with_the_standards_examples) {
    EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
    EXPECT_EQ(sha256(std::string(1000000, 'a')),
              "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_F(PictureFileTest, reads_what_it_wrote) {
    cv::Mat3b picture(20, 30);
    for (int i = 0; i < 600; ++i) picture(i / 30, i % 30) = cv::Vec3b(uchar(i), uchar(i * 3), uchar(i * 7));
    write_png(folder_ / "a.png", picture);
    EXPECT_EQ(cv::norm(read_picture(folder_ / "a.png", 30, 20), picture, cv::NORM_INF), 0.0);
    EXPECT_EQ(picture_size(folder_ / "a.png"), cv::Size(30, 20));
}

TEST_F(PictureFileTest, refuses_other_sizes_depths_and_broken_files) {
    const cv::Mat gray(20, 30, CV_8U, cv::Scalar(3)), deep(20, 30, CV_16U, cv::Scalar(3));
    write_png(folder_ / "a.png", gray);
    write_png(folder_ / "deep.png", deep);
    const std::string bytes = read(folder_ / "a.png");
    write("cut.png", bytes.substr(0, bytes.size() / 2));
    std::string flipped = bytes;
    flipped[bytes.size() / 2] = static_cast<char>(flipped[bytes.size() / 2] ^ 0x55);
    write("flipped.png", flipped);
    write("text.png", "hello");
    write("empty.png", "");
    write("jpeg.jpg", "\xff\xd8\xff\xe0 nothing");
    const auto at = [&](const std::string& name) {
        return error_of([&] { read_picture(folder_ / name, 30, 20); });
    };
    EXPECT_THAT(error_of([&] { read_picture(folder_ / "a.png", 31, 20); }), HasSubstr("30x20 px, expected"));
    EXPECT_THAT(at("deep.png"), HasSubstr("16 bits"));
    EXPECT_THAT(at("cut.png"), HasSubstr("truncated PNG"));
    EXPECT_THAT(at("flipped.png"), HasSubstr("PNG"));
    EXPECT_THAT(at("text.png"), HasSubstr("no picture"));
    EXPECT_THAT(at("empty.png"), HasSubstr("no picture"));
    EXPECT_THAT(at("jpeg.jpg"), HasSubstr("corrupt JPEG"));
    EXPECT_THAT(at("none.png"), HasSubstr("no such picture"));
}

/// A sequence of two black frames that each test breaks in one place.
class SequenceTest : public TemporaryFolder {
  protected:
    SequenceTest() {
        write("calib/stereo.yaml", scenes::to_opencv_yaml(scenes::parallel_rig(32, 24, 30.0, 0.005)));
        fs::create_directories(folder_ / "left");
        fs::create_directories(folder_ / "right");
        for (const char* name :
             {"left/000000.png", "left/000001.png", "right/000000.png", "right/000001.png"})
            write_png(folder_ / name, cv::Mat(24, 32, CV_8U, cv::Scalar(0)));
    }
    std::string broken() {
        return error_of([&] {
            const Sequence sequence = Sequence::open(folder_);
            for (int i = 0; i < sequence.frames(); ++i) sequence.frame(i);
        });
    }
};

TEST_F(SequenceTest, needs_only_a_calibration_and_pictures) {
    const Sequence sequence = Sequence::open(folder_);
    EXPECT_EQ(sequence.frames(), 2);
    EXPECT_DOUBLE_EQ(sequence.time_s(1), 1.0 / 30.0);
    EXPECT_FALSE(sequence.frame(0).tips[0]);
}

TEST_F(SequenceTest, reads_times_and_ends) {
    write("frames.csv", "frame,time_s\n0,0.5\n1,0.75\n");
    write("tips.csv", "frame,end,kind,x_mm,y_mm,z_mm\n1,0,held,1,2,100\n1,1,fixed,3,4,110\n");
    const Sequence sequence = Sequence::open(folder_);
    EXPECT_DOUBLE_EQ(sequence.time_s(1), 0.75);
    const tracker::StereoFrame frame = sequence.frame(1);
    ASSERT_TRUE(frame.tips[0] && frame.tips[1]);
    EXPECT_NEAR((frame.tips[1]->p_C - Eigen::Vector3d(0.003, 0.004, 0.110)).norm(), 0.0, 1e-15);
    EXPECT_EQ(frame.tips[1]->kind, tracker::MeasuredTip::Kind::kFixed);
}

TEST(KnotEnds, fix_an_end_where_the_curve_ended_when_it_was_last_held_not_where_it_was_measured) {
    using Kind = tracker::MeasuredTip::Kind;
    const Eigen::Vector3d measured(0.02, 0.0, 0.1), found(0.021, 0.001, 0.099), moved(0.0, 0.0, 0.1);
    const auto frame_of = [&](Kind kind) {
        tracker::StereoFrame frame;
        frame.tips = {tracker::MeasuredTip{measured, kind}, tracker::MeasuredTip{moved, Kind::kHeld}};
        return frame;
    };
    KnotEnds knots;
    tracker::StereoFrame first = frame_of(Kind::kHeld), next = frame_of(Kind::kFixed);
    knots.place(next);
    EXPECT_EQ(next.tips[0]->p_C, measured) << "never held: as it was measured";
    scenes::ThreadEstimate estimate;
    estimate.samples.resize(2);
    estimate.samples[0].p_C = found;
    knots.place(first);
    knots.learn(first, estimate);
    knots.place(next);
    EXPECT_EQ(next.tips[0]->p_C, found);
    estimate.samples[0].p_C = moved;
    knots.learn(next, estimate);
    next = frame_of(Kind::kFixed);
    knots.place(next);
    EXPECT_EQ(next.tips[0]->p_C, found) << "later curves don't move it";
    EXPECT_EQ(next.tips[1]->p_C, moved) << "held ends are as measured";
}

TEST_F(SequenceTest, refuses_what_is_not_whole_in_one_line) {
    const std::string tips = "frame,end,kind,x_mm,y_mm,z_mm\n";
    const std::tuple<std::string, std::string, std::string> cases[] = {
        {"tips.csv", tips + "0,0,held,nan,0,100\n", "tips.csv:2: x_mm is 'nan'"},
        {"tips.csv", tips + "0,0,held,0,0,-5\n", "behind the camera"},
        {"tips.csv", tips + "0,2,held,0,0,100\n", "end is '2'"},
        {"tips.csv", tips + "7,0,held,0,0,100\n", "frame is '7'"},
        {"tips.csv", tips + "0,0,loose,0,0,100\n", "expected held or fixed"},
        {"frames.csv", "frame,time_s\n0,0\n", "1 rows"},
        {"frames.csv", "frame,time_s\n0,0\n1,0\n", "time does not rise"},
        {"frames.csv", "frame,time_s\n0,0\n2,1\n", "frame is '2'"},
        {"right/000001.png", "x", "no picture"},
        {"calib/stereo.yaml", "x: 1\n", "no key 'image_size'"},
    };
    for (const auto& [name, bytes, expected] : cases) {
        const bool existed = fs::exists(folder_ / name);
        const std::string before = existed ? read(folder_ / name) : "";
        write(name, bytes);
        EXPECT_THAT(broken(), HasSubstr(expected)) << name;
        if (existed)
            write(name, before);
        else
            fs::remove(folder_ / name);
    }
    EXPECT_EQ(broken(), "no error");
}

TEST_F(SequenceTest, refuses_a_missing_eye_gaps_and_unequal_counts) {
    fs::rename(folder_ / "right/000001.png", folder_ / "right/000002.png");
    EXPECT_THAT(broken(), HasSubstr("expected picture number 000001"));
    fs::remove(folder_ / "right/000002.png");
    EXPECT_THAT(broken(), HasSubstr("2 left and 1 right"));
    fs::remove_all(folder_ / "right");
    EXPECT_THAT(broken(), HasSubstr("no such folder"));
    fs::create_directories(folder_ / "right");
    EXPECT_THAT(broken(), HasSubstr("no pictures"));
    EXPECT_THAT(error_of([&] { Sequence::open(folder_ / "none"); }), HasSubstr("no such folder"));
}

TEST_F(SequenceTest, refuses_eyes_of_different_colour) {
    write_png(folder_ / "right/000001.png", cv::Mat(24, 32, CV_8UC3, cv::Scalar(0, 0, 9)));
    EXPECT_THAT(broken(), HasSubstr("gray and colour"));
}

TEST_F(TrackReaderTest, takes_a_bare_curve_file_without_sigmas) {
    const fs::path file =
        write("track.csv",
              "frame,i,s_mm,x_mm,y_mm,z_mm\n3,0,0,0,0,100\n3,1,5,5,0,100\n5,0,0,0,0,90\n5,1,2,2,0,90\n");
    const auto frames = read_track(file);
    ASSERT_EQ(frames.size(), 3u);
    EXPECT_EQ(frames[0].frame, 3);
    EXPECT_EQ(frames[1].estimate.status, scenes::TrackStatus::kLost);
    EXPECT_NEAR(frames[2].estimate.length_m(), 0.002, 1e-15);
}

TEST_F(TrackReaderTest, refuses_what_is_no_track) {
    const std::string head = "frame,i,s_mm,x_mm,y_mm,z_mm\n";
    EXPECT_THAT(error_of([&] { read_track(write("a.csv", head)); }), HasSubstr("no rows"));
    EXPECT_THAT(error_of([&] { read_track(write("a.csv", head + "0,0,0,0,0,-1\n")); }),
                HasSubstr("behind the camera"));
    EXPECT_THAT(error_of([&] { read_track(write("a.csv", head + "0,0,0,0,0,9\n0,1,0,0,0,9\n")); }),
                HasSubstr("does not rise"));
    EXPECT_THAT(error_of([&] { read_track(folder_ / "none"); }), HasSubstr("no such track"));
}

}  // namespace
}  // namespace atropos::experiments
