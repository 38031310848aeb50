#include <gtest/gtest.h>

#include "render/instrument.hpp"
#include "render/mesh_detail.hpp"
#include "render/tissue.hpp"
#include "render_scenes.hpp"
#include "robot/tool.hpp"

namespace atropos::render {
namespace {

class InstrumentMesh : public testing::TestWithParam<std::string> {};

TEST_P(InstrumentMesh, stays_inside_its_collision_capsules_by_half_a_millimetre) {
    const robot::Tool& tool = robot::tool(GetParam());
    const InstrumentModel model =
        load_instrument(std::string(ATROPOS_MESHES "/") + instrument_folder(tool.name));
    for (std::size_t link = 0; link < 4; ++link) {
        double worst_m = -1.0;
        Eigen::Vector3d where = Eigen::Vector3d::Zero();
        for (const MeshPart& part : model.links[link]) {
            for (const Eigen::Vector3f& v : part.mesh->vertices) {
                double outside_m = 1.0;
                for (const scenes::Capsule& c : tool.capsules[link]) {
                    outside_m = std::min(outside_m, scenes::clearance_m(c, v.cast<double>()));
                }
                if (outside_m > worst_m) {
                    worst_m = outside_m;
                    where = v.cast<double>();
                }
            }
        }
        EXPECT_LE(worst_m, 0.0005) << kInstrumentLinks[link] << " at mm " << 1e3 * where.transpose();
    }
}

INSTANTIATE_TEST_SUITE_P(Tools, InstrumentMesh,
                         testing::Values(std::string("LARGE_NEEDLE_DRIVER"), std::string("PROGRASP_FORCEPS"),
                                         std::string("CURVED_SCISSORS"), std::string("ROUND_TIP_SCISSORS")));

TEST(Tissue, is_the_same_for_the_same_seed_and_another_for_another) {
    TissueOptions options;
    options.texture_px = 64;
    options.cell_m = 0.004;
    for (const char* preset : {"tissue", "pad", "drape"}) {
        options.preset = preset;
        const Tissue a = make_tissue(options, 1), b = make_tissue(options, 1),
                     other = make_tissue(options, 2);
        EXPECT_EQ(a.mesh->vertices, b.mesh->vertices);
        EXPECT_NE(a.mesh->vertices, other.mesh->vertices);
        EXPECT_EQ(a.textures[0].second.rgba, b.textures[0].second.rgba);
        EXPECT_EQ(a.textures[0].second.rgba.size(), 4u * 64 * 64);
    }
    options.preset = "sponge";
    EXPECT_THROW(make_tissue(options, 1), std::invalid_argument);
}

TEST(MeshDetail, splits_edges_without_changing_the_surface) {
    const scenes::TriangleMesh coarse = *sphere(0.01, 6), fine = refined(coarse, 0.001);
    const auto area = [](const scenes::TriangleMesh& mesh) {
        double sum = 0.0;
        for (const auto& [a, b, c] : mesh.triangles) {
            const Eigen::Vector3d p = mesh.vertices[a].cast<double>();
            sum +=
                0.5 * (mesh.vertices[b].cast<double>() - p).cross(mesh.vertices[c].cast<double>() - p).norm();
        }
        return sum;
    };
    EXPECT_NEAR(area(fine), area(coarse), 1e-7 * area(coarse));
    for (const auto& [a, b, c] : fine.triangles) {
        EXPECT_LE((fine.vertices[a] - fine.vertices[b]).norm(), 0.001001f);
        EXPECT_LE((fine.vertices[b] - fine.vertices[c]).norm(), 0.001001f);
        EXPECT_LE((fine.vertices[c] - fine.vertices[a]).norm(), 0.001001f);
    }
}

}  // namespace
}  // namespace atropos::render
