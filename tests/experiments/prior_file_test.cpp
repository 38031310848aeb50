// What learn-prior writes, reads back, and says of files that are none; the program itself on tracks.
#include "experiments/prior_file.hpp"

#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "scenes/file_error.hpp"
#include "scenes/random_stream.hpp"
#include "tests/experiments/temporary_folder.hpp"

namespace atropos::experiments {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

tracker::DeformationPrior a_prior() {
    tracker::DeformationPrior prior{.control_points = 4,
                                    .frame_rate_hz = 30.0,
                                    .tracks = 3,
                                    .frames = 400,
                                    .modes = Eigen::MatrixXd::Zero(12, 2),
                                    .sigmas_m = Eigen::Vector2d(3.1e-4, 1.7e-4),
                                    .rest_sigma_m = 2.3e-5};
    prior.modes(4, 0) = 0.6;
    prior.modes(7, 0) = 0.8;
    prior.modes(5, 1) = prior.modes(8, 1) = std::sqrt(0.5);
    return prior;
}

TEST(PriorFile, reads_back_what_was_written_to_the_bit) {
    const tracker::DeformationPrior prior = a_prior();
    const std::string text = to_json_text(prior);
    const tracker::DeformationPrior again = parse_deformation_prior("prior.json", text);
    EXPECT_EQ(again.modes, prior.modes);
    EXPECT_EQ(to_json_text(again), text);
}

std::string refusal(const std::string& text) {
    try {
        parse_deformation_prior("prior.json", text);
    } catch (const scenes::FileError& error) {
        return error.what();
    }
    return "taken";
}

std::string changed(const std::string& from, const std::string& to) {
    std::string text = to_json_text(a_prior());
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(PriorFile, says_what_is_wrong_and_what_was_expected) {
    EXPECT_THAT(refusal("{"), HasSubstr("prior.json: no JSON object, expected"));
    EXPECT_THAT(refusal("{}"), HasSubstr("format is missing, expected \"atropos deformation prior\""));
    EXPECT_THAT(refusal(changed("\"version\": 1", "\"version\": 2")), HasSubstr("version is something else"));
    EXPECT_THAT(refusal(changed("\"control_points\": 4", "\"control_points\": 4e9")),
                HasSubstr("a whole number from 4 to 64"));
    EXPECT_THAT(refusal(changed("\"control_points\": 4", "\"control_points\": 5")),
                HasSubstr("modes[0]: displacement is something else, expected an array of 5"));
    EXPECT_THAT(refusal(changed("0.6", "0.7")), HasSubstr("not orthonormal"));
    EXPECT_THAT(refusal(changed("0.6", "\"x\"")), HasSubstr("three numbers for each of 4"));
    EXPECT_THAT(refusal(changed("\"sigma_m\": 0.00031", "\"sigma_m\": 0.0")), HasSubstr("falling ones"));
    EXPECT_THAT(refusal(changed("\"sigma_m\": 0.00031", "\"sigma\": 0.00031")),
                HasSubstr("sigma_m is missing"));
    EXPECT_THAT(refusal(changed("\"rest_sigma_m\": ", "\"rest_sigma_m\": 9")), HasSubstr("rest sigma"));
}

RC_GTEST_PROP(PriorFile, is_a_prior_or_one_line_whatever_its_bytes, ()) {
    scenes::RandomStream random(*rc::gen::arbitrary<std::uint64_t>(), "bytes");
    std::string text = to_json_text(a_prior());
    for (int i = 0; i < 4; ++i) {
        const auto at = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(text.size()) - 1.0));
        if (random.uniform() < 0.3)
            text.erase(at, static_cast<std::size_t>(random.uniform(1.0, 30.0)));
        else if (random.uniform() < 0.3)
            text.insert(at, text.substr(at / 2, static_cast<std::size_t>(random.uniform(1.0, 30.0))));
        else
            text[at] = "0e9-{}[],\"x"[static_cast<std::size_t>(random.uniform(0.0, 11.0))];
    }
    const std::string said = refusal(text);
    RC_ASSERT(said == "taken" || (said.starts_with("prior.json: ") && said.find('\n') == std::string::npos));
}

TEST(PriorFile, of_the_fuzzers_corpus_is_a_prior_or_one_line) {
    int taken = 0;
    for (const auto& entry : fs::directory_iterator(ATROPOS_SOURCE_DIR "/tests/fuzz/corpus/prior")) {
        std::ifstream stream(entry.path(), std::ios::binary);
        const std::string said =
            refusal({std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()});
        taken += said == "taken";
        EXPECT_EQ(said.find('\n'), std::string::npos) << entry.path();
    }
    EXPECT_EQ(taken, 1);
}

class LearnPriorCommandTest : public TemporaryFolder {
  protected:
    /// A track of 16 control points that sway, as the track command writes it.
    void track(const std::string& name, int frames, int K = 16) const {
        std::ostringstream points, list;
        points << "frame,k,x_mm,y_mm,z_mm\n";
        list << "frame,time_s,status,length_mm,energy,confidence\n";
        scenes::RandomStream random(7, name);
        for (int i = 0; i < frames; ++i) {
            const double sway = random.normal(), swing = random.normal();
            for (int k = 0; k < K; ++k) {
                const double u = static_cast<double>(k) / (K - 1), bump = 4.0 * u * (1.0 - u);
                points << i << ',' << k << ',' << 60.0 * u << ',' << bump * (15.0 + sway) << ','
                       << 100.0 + bump * 0.3 * swing + 0.01 * random.normal() << '\n';
            }
            list << i << ',' << i / 30.0 << ",tracking,70,0,1\n";
        }
        write(name + "/control_points.csv", points.str());
        write(name + "/frames.csv", list.str());
    }

    int learn(const std::string& words) {
        const std::string command = "cd '" + folder_.string() + "' && '" ATROPOS_PROGRAM "' learn-prior " +
                                    words + " 2> complaint.txt";
        const int status = std::system(command.c_str());
        complaint_ = read(folder_ / "complaint.txt");
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    std::string complaint_;
};

TEST_F(LearnPriorCommandTest, learns_from_a_folder_of_tracks) {
    track("runs/a/track", 100);
    track("runs/b/track", 100);
    ASSERT_EQ(learn("runs -o out/prior.json --modes 2"), 0) << complaint_;
    const tracker::DeformationPrior prior = read_deformation_prior(folder_ / "out/prior.json");
    EXPECT_EQ(prior.control_points, 16);
    EXPECT_EQ(prior.tracks, 2);
    EXPECT_NEAR(prior.frame_rate_hz, 30.0, 1e-6);
    EXPECT_GT(prior.sigmas_m[0], 2.0 * prior.sigmas_m[1]);  // it sways more than it swings
    EXPECT_EQ(learn("runs -o out/prior.json"), 2);
    EXPECT_THAT(complaint_, HasSubstr("is there already"));
    EXPECT_EQ(learn("runs -o out/prior.json --force --quiet"), 0);
    EXPECT_EQ(complaint_, "");
}

TEST_F(LearnPriorCommandTest, refuses_what_holds_no_tracks_with_status_2_and_one_line) {
    const auto refused = [&](const std::string& words, const std::string& what) {
        EXPECT_EQ(learn(words), 2) << words;
        EXPECT_THAT(complaint_, HasSubstr(what));
        EXPECT_EQ(std::count(complaint_.begin(), complaint_.end(), '\n'), 1) << complaint_;
        EXPECT_FALSE(fs::exists(folder_ / "prior.json"));
        EXPECT_FALSE(fs::exists(folder_ / "prior.json.partial"));
    };
    fs::create_directories(folder_ / "empty");
    refused("missing -o prior.json", "no such folder of tracks");
    refused("empty -o prior.json", "no track in it");
    refused("empty -o empty", "is a folder, expected a file");
    track("short", 20);
    refused("short -o prior.json", "17 frames to learn from, expected 48 or more");
    track("long", 100);
    track("small", 100, 8);
    refused("long small -o prior.json", "8 control points, expected 16 as before");
    write("long/control_points.csv", "frame,k,x_mm,y_mm,z_mm\n0,0,1,2,nan\n");
    refused("long -o prior.json", "long/control_points.csv:2");
}

}  // namespace
}  // namespace atropos::experiments
