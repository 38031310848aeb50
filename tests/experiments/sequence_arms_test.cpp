#include "experiments/sequence_arms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "experiments/sequence_generator.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"
#include "temporary_folder.hpp"

namespace atropos::experiments {
namespace {
namespace fs = std::filesystem;
using Eigen::Vector3d;

/// Two arms hold a thread; calibrated arms read their grips one to two millimetres off.
class SequenceArmsTest : public TemporaryFolder {
  protected:
    Sequence sequence(std::vector<std::string> overrides = {}) {
        overrides.insert(overrides.end(), {"duration_s=0.4", "seed=11"});
        const scenes::SceneConfig scene = scenes::load_scene(ATROPOS_SCENES "/auto_scissors.yaml", overrides);
        generate_sequence(scene, 1, folder_, {false, false, false, false}, [](int) {});
        return Sequence::open(folder_);
    }
    /// RMS distance of the told ends from the true ones in the last frame (mm), by way of the arms or not.
    static double end_error_mm(const Sequence& sequence, bool with_arms) {
        const auto arms = SequenceArms::open(sequence, sequence.rig(), 2);
        const std::vector<TruthFrame> truth = read_truth(sequence.folder(), sequence.frames());
        tracker::StereoFrame frame;
        for (int i = 0; i < sequence.frames(); ++i) {
            frame = sequence.frame(i);
            if (with_arms) arms->add_to(frame, i);
        }
        const std::vector<Vector3d>& span = truth.back().span_C.points;
        return 1e3 * std::sqrt(0.5 * ((frame.tips[0]->p_C - span.front()).squaredNorm() +
                                      (frame.tips[1]->p_C - span.back()).squaredNorm()));
    }
};

TEST_F(SequenceArmsTest, bring_the_measured_ends_to_where_the_pictures_show_the_grips) {
    const Sequence recorded = sequence();
    EXPECT_GT(end_error_mm(recorded, false), 1.0);
    EXPECT_LT(end_error_mm(recorded, true), 0.5);
}

TEST_F(SequenceArmsTest, leave_ends_alone_that_are_exact) {
    const Sequence recorded = sequence({"tracker.tips=exact"});
    EXPECT_LT(end_error_mm(recorded, false), 0.01);
    EXPECT_LT(end_error_mm(recorded, true), 0.01);
}

TEST_F(SequenceArmsTest, are_where_kinematics_say_when_the_arms_are_perfect) {
    const Sequence recorded = sequence({"arms.accuracy=perfect"});
    tracker::StereoFrame frame = recorded.frame(0);
    SequenceArms::open(recorded, recorded.rig(), 1)->add_to(frame, 0);
    for (const auto& tip : frame.tips) {  // each grip lies within its own instrument
        double clearance_m = 1.0;
        for (const scenes::Capsule& capsule : frame.instruments)
            clearance_m = std::min(clearance_m, scenes::clearance_m(capsule, tip->p_C));
        EXPECT_LT(clearance_m, 0.0);
    }
}

TEST_F(SequenceArmsTest, are_not_there_without_kinematics_or_a_scene) {
    const Sequence recorded = sequence();
    for (const char* file : {"kinematics.csv", "scene.yaml"}) {
        fs::rename(folder_ / file, folder_ / "aside");
        EXPECT_EQ(SequenceArms::open(recorded, recorded.rig(), 1), nullptr) << file;
        fs::rename(folder_ / "aside", folder_ / file);
    }
}

TEST_F(SequenceArmsTest, name_file_and_line_of_a_bad_row) {
    const Sequence recorded = sequence();
    const std::string whole = read(folder_ / "kinematics.csv");
    for (const auto& [pattern, by, said] :
         {std::tuple{"0,0.000000,PSM2", "0,0.000000,PSM9", "kinematics.csv:3: "},
          std::tuple{"0,0.000000,PSM1,C,[^,]*", "0,0.000000,PSM1,C,nan", "kinematics.csv:2: "},
          std::tuple{"[^,]*\n0,0.000000,PSM2", "2.0\n0,0.000000,PSM2", "kinematics.csv:2: "}}) {
        write("kinematics.csv",
              std::regex_replace(whole, std::regex(pattern), by, std::regex_constants::format_first_only));
        try {
            SequenceArms::open(recorded, recorded.rig(), 1);
            ADD_FAILURE() << pattern;
        } catch (const scenes::FileError& error) {
            EXPECT_NE(std::string(error.what()).find(said), std::string::npos) << error.what();
        }
    }
}

}  // namespace
}  // namespace atropos::experiments
