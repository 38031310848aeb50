#include "experiments/dataset.hpp"

#include <gmock/gmock.h>

#include <map>
#include <opencv2/imgproc.hpp>

#include "experiments/coco_export.hpp"
#include "experiments/rectifier.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_ranges.hpp"
#include "tests/experiments/temporary_folder.hpp"

namespace atropos::experiments {
namespace {
using Eigen::Vector2d;
using Eigen::Vector3d;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(CocoRunLengths, go_down_the_columns_and_begin_with_zeros) {
    // The example of COCO's mask API: M = [0 1 1 0 1 ...], here [[0, 1], [1, 1], [1, 0]] column by column: 0
    // 1 1 1 1 0.
    EXPECT_THAT(coco_run_lengths((cv::Mat1b(3, 2) << 0, 1, 1, 1, 1, 0)), ElementsAre(1, 4, 1));
    EXPECT_THAT(coco_run_lengths((cv::Mat1b(2, 2) << 1, 1, 1, 0)), ElementsAre(0, 3, 1));
    EXPECT_THAT(coco_run_lengths(cv::Mat1b(2, 2, uchar{0})), ElementsAre(4));
}

TEST(Splits, are_80_10_10_and_belong_to_the_seed) {
    std::map<std::string, int> counts;
    for (std::uint64_t seed = 0; seed < 10000; ++seed) ++counts[split_of_seed(seed)];
    EXPECT_NEAR(counts["train"], 8000, 160);  // four sigma
    EXPECT_NEAR(counts["val"], 1000, 120);
    EXPECT_NEAR(counts["test"], 1000, 120);
    EXPECT_EQ(split_of_seed(7), split_of_seed(7));
}

/// A converging, distorted rig and the depth of a slanted plane in it, by ray casting.
struct PlaneScene {
    scenes::StereoRig rig = scenes::parallel_rig(160, 90, 144.0, 0.005);
    Vector3d normal{0.1, 0.15, -1.0};
    double distance = -0.1;  ///< normal . p = distance

    PlaneScene() {
        rig.X_RC.linear() = Eigen::AngleAxisd(0.03, Vector3d(0.2, 1.0, 0.1).normalized()).toRotationMatrix();
        rig.left.distortion = {-0.1, 0.05, 0.001, -0.002, 0, 0, 0, 0};
        rig.right.distortion = {-0.08, 0.02, -0.001, 0.001, 0, 0, 0, 0};
    }
    Vector3d hit(const Vector3d& origin, const Vector3d& direction) const {
        return origin + direction * ((distance - normal.dot(origin)) / normal.dot(direction));
    }
    cv::Mat1f depth(bool right) const {
        cv::Mat1f z(90, 160);
        const Eigen::Isometry3d X_CR = rig.X_RC.inverse();
        for (int v = 0; v < 90; ++v)
            for (int u = 0; u < 160; ++u) {
                const Vector3d ray = (right ? rig.right : rig.left).ray(Vector2d(u, v));
                const Vector3d p_C =
                    right ? hit(X_CR.translation(), X_CR.linear() * ray) : hit(Vector3d::Zero(), ray);
                z(v, u) = static_cast<float>(right ? (rig.X_RC * p_C).z() : p_C.z());
            }
        return z;
    }
};

TEST(Rectifier, gives_the_disparity_of_the_geometry_it_rectifies_to) {
    const PlaneScene scene;
    const Rectifier rectifier(scene.rig);
    const cv::Mat black(90, 160, CV_8UC3, cv::Scalar());
    const RectifiedPair pair = rectifier.rectify(black, black, scene.depth(false), scene.depth(true));
    const scenes::Rectification r = scene.rig.rectification();
    double worst = 0.0;
    int seen = 0;
    for (int v = 5; v < 85; v += 4)
        for (int u = 10; u < 150; u += 4) {
            const Vector3d ray = r.R1.transpose() * r.P1.leftCols<3>().inverse() * Vector3d(u, v, 1.0);
            const Vector3d p_C = scene.hit(Vector3d::Zero(), ray), p = r.R1 * p_C;
            const Vector3d left = r.P1 * p.homogeneous(), right = r.P2 * p.homogeneous();
            if (pair.disparity_left(v, u) == 0.0f) continue;
            ++seen;
            EXPECT_NEAR(left.y() / left.z(), right.y() / right.z(), 1e-9);
            worst = std::max(
                worst, std::abs(pair.disparity_left(v, u) - (left.x() / left.z() - right.x() / right.z())));
        }
    EXPECT_GT(seen, 500);
    EXPECT_LT(worst, 0.02) << "px; the nearest pixel's depth is up to half a pixel away";
    // A plane hides nothing from the other eye but what lies outside of its picture.
    for (int v = 5; v < 85; ++v)
        for (int u = 30; u < 130; ++u) EXPECT_EQ(pair.occlusion_left(v, u), 0) << u << " " << v;
}

TEST(Rectifier, hides_behind_an_edge_what_one_eye_alone_sees) {
    const scenes::StereoRig rig = scenes::parallel_rig(100, 20, 100.0, 0.01);  // disparity 1 / z[m]
    cv::Mat1f left(20, 100, 0.1f), right(20, 100, 0.1f);                       // 10 px
    left.colRange(50, 60) = 0.05f;                                             // a bar at 20 px
    right.colRange(30, 40) = 0.05f;
    const cv::Mat black(20, 100, CV_8UC3, cv::Scalar());
    const RectifiedPair pair = Rectifier(rig).rectify(black, black, left, right);
    EXPECT_NEAR(pair.disparity_left(10, 55), 20.0, 1e-4);
    for (int u = 10; u < 100; ++u) EXPECT_EQ(pair.occlusion_left(10, u) > 0, u >= 40 && u < 50) << u;
    for (int u = 0; u < 90; ++u) EXPECT_EQ(pair.occlusion_right(10, u) > 0, u >= 40 && u < 50) << u;
}

class SceneRangesTest : public TemporaryFolder {
  protected:
    std::string error(const std::string& text) {
        try {
            scenes::draw_randomised(write("s.yaml", text), 1);
        } catch (const scenes::FileError& e) {
            return e.what();
        }
        return "no error";
    }
};

TEST_F(SceneRangesTest, draw_each_kind_within_its_bounds) {
    const auto file =
        write("s.yaml",
              "randomise:\n  thread.length_mm: [60, 80]\n  thread.EI_N_m2: {log: [1.0e-10, 1.0e-6]}\n"
              "  thread.edges: {whole: [90, 92]}\n  thread.colour: {choice: [black, blue]}\n");
    std::map<std::string, int> edges, colours;
    int small = 0;
    for (std::uint64_t seed = 1; seed <= 400; ++seed) {
        const scenes::DrawnValues values = scenes::draw_randomised(file, seed);
        ASSERT_EQ(values.size(), 4u);
        const double length = std::stod(values[0].second), stiffness = std::stod(values[1].second);
        EXPECT_TRUE(length >= 60 && length <= 80);
        EXPECT_TRUE(stiffness >= 1e-10 && stiffness <= 1e-6);
        small += stiffness < 1e-8 ? 1 : 0;
        ++edges[values[2].second];
        ++colours[values[3].second];
    }
    EXPECT_NEAR(small, 200, 40) << "uniform in the logarithm";
    EXPECT_THAT(edges, ElementsAre(testing::Key("90"), testing::Key("91"), testing::Key("92")));
    EXPECT_NEAR(colours["blue"], 200, 40);
}

TEST_F(SceneRangesTest, draw_a_key_alike_whatever_else_is_drawn) {
    const auto one = scenes::draw_randomised(write("a.yaml", "randomise: {thread.length_mm: [60, 80]}\n"), 5);
    const auto two = scenes::draw_randomised(
        write("b.yaml", "randomise: {tissue.depth_mm: [20, 30], thread.length_mm: [60, 80]}\n"), 5);
    EXPECT_EQ(one[0], two[1]);
    EXPECT_TRUE(scenes::draw_randomised(write("c.yaml", "duration_s: 1\n"), 5).empty());
    const auto included = scenes::draw_randomised(write("d.yaml", "include: a.yaml\n"), 5);
    EXPECT_EQ(included, one);
}

TEST_F(SceneRangesTest, name_the_line_of_what_is_wrong) {
    EXPECT_THAT(error("randomise:\n  thread.lenght_mm: [1, 2]\n"), HasSubstr("s.yaml:2: "));
    EXPECT_THAT(error("randomise:\n  thread.lenght_mm: [1, 2]\n"), HasSubstr("nearest known is 'length_mm'"));
    EXPECT_THAT(error("randomise: {thread.length_mm: [80, 60]}\n"), HasSubstr("low lies above high"));
    EXPECT_THAT(error("randomise: {thread.length_mm: 80}\n"), HasSubstr("expected [low, high]"));
    EXPECT_THAT(error("randomise: {thread.length_mm: {normal: [60, 70]}}\n"),
                HasSubstr("unknown kind 'normal'"));
    EXPECT_THAT(error("randomise: {thread.EI_N_m2: {log: [0, 1]}}\n"), HasSubstr("above 0"));
    EXPECT_THAT(error("randomise: {thread.length_mm: [6000, 8000]}\n"), HasSubstr("a number from 10 to 500"));
}

}  // namespace
}  // namespace atropos::experiments
