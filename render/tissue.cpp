#include "render/tissue.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "render/mesh_detail.hpp"
#include "render/stereo_endoscope.hpp"
#include "render/surface_painter.hpp"

namespace atropos::render {
namespace {

std::unique_ptr<SurfacePainter> painter_for(const TissueOptions& options, std::uint64_t seed) {
    if (options.preset == "tissue") return make_mesentery(options, seed);
    if (options.preset == "pad") return make_training_pad(options, seed);
    if (options.preset == "drape") return make_drape(options, seed);
    throw std::invalid_argument("no tissue preset '" + options.preset + "', expected tissue, pad or drape");
}

void validate(const TissueOptions& o) {
    const bool good = o.size_x_m > 0.0 && o.size_y_m > 0.0 && o.size_x_m <= 1.0 && o.size_y_m <= 1.0 &&
                      o.cell_m >= 1e-4 && o.cell_m <= 0.1 && o.texture_px >= 16 && o.texture_px <= 8192 &&
                      std::abs(o.relief_m) <= 0.1;
    if (!good) {
        throw std::invalid_argument(
            "tissue options out of range, expected sizes in (0, 1] m, cells of 0.1 to 100 mm, relief up to "
            "0.1 m, "
            "textures of 16 to 8192 pixels");
    }
}

scenes::TriangleMesh height_field(const TissueOptions& o, const SurfacePainter& painter) {
    const int nx = std::max(1, static_cast<int>(std::lround(o.size_x_m / o.cell_m)));
    const int ny = std::max(1, static_cast<int>(std::lround(o.size_y_m / o.cell_m)));
    scenes::TriangleMesh mesh;
    for (int j = 0; j <= ny; ++j) {
        for (int i = 0; i <= nx; ++i) {
            const float u = static_cast<float>(i) / static_cast<float>(nx),
                        v = static_cast<float>(j) / static_cast<float>(ny);
            const float x = (u - 0.5f) * static_cast<float>(o.size_x_m),
                        y = (v - 0.5f) * static_cast<float>(o.size_y_m);
            mesh.vertices.emplace_back(x, y, painter.height_m(x, y));
            mesh.texture_coordinates.emplace_back(u, v);
        }
    }
    const auto row = static_cast<std::uint32_t>(nx + 1);
    for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(ny); ++j) {
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t a = j * row + i;
            mesh.triangles.push_back({a, a + 1, a + row + 1});
            mesh.triangles.push_back({a, a + row + 1, a + row});
        }
    }
    mesh.normals = smooth_normals(mesh);
    return mesh;
}

std::uint8_t byte(float value) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

float srgb(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

std::pair<Texture, Texture> paint(const TissueOptions& o, const SurfacePainter& painter) {
    const int n = o.texture_px;
    Texture colour{n, n, true, {}}, normal{n, n, false, {}};
    std::vector<float> detail_m, roughness;
    const float step_x = static_cast<float>(o.size_x_m) / static_cast<float>(n);
    const float step_y = static_cast<float>(o.size_y_m) / static_cast<float>(n);
    std::vector<float> x_m;
    for (int i = 0; i < n; ++i)
        x_m.push_back((static_cast<float>(i) + 0.5f - 0.5f * static_cast<float>(n)) * step_x);
    for (int j = 0; j < n; ++j) {
        const auto row =
            painter.row(x_m, (static_cast<float>(j) + 0.5f - 0.5f * static_cast<float>(n)) * step_y);
        for (const SurfacePoint& p : row) {
            for (int c = 0; c < 3; ++c) colour.rgba.push_back(byte(srgb(p.colour[c])));
            colour.rgba.push_back(255);
            detail_m.push_back(p.detail_m);
            roughness.push_back(p.roughness);
        }
    }
    const auto at = [&](int i, int j) {
        return detail_m[static_cast<std::size_t>(std::clamp(j, 0, n - 1) * n + std::clamp(i, 0, n - 1))];
    };
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
            const Eigen::Vector3f up = Eigen::Vector3f((at(i - 1, j) - at(i + 1, j)) / (2.0f * step_x),
                                                       (at(i, j - 1) - at(i, j + 1)) / (2.0f * step_y), 1.0f)
                                           .normalized();
            for (int c = 0; c < 3; ++c) normal.rgba.push_back(byte(0.5f * up[c] + 0.5f));
            normal.rgba.push_back(byte(roughness[static_cast<std::size_t>(j * n + i)]));
        }
    }
    return {std::move(colour), std::move(normal)};
}

}  // namespace

Tissue make_tissue(const TissueOptions& options, std::uint64_t seed) {
    validate(options);
    const std::unique_ptr<SurfacePainter> painter = painter_for(options, seed);
    Tissue tissue;
    tissue.mesh = std::make_shared<const scenes::TriangleMesh>(height_field(options, *painter));
    tissue.material = painter->material();
    const std::string name = "*" + options.preset + "-" + std::to_string(seed) + "-" +
                             std::to_string(options.texture_px) + "-" + std::to_string(options.size_x_m) +
                             "x" + std::to_string(options.size_y_m);
    tissue.material.colour_texture = name + "-colour";
    tissue.material.normal_texture = name + "-normal";
    auto [colour, normal] = paint(options, *painter);
    tissue.textures.emplace_back(tissue.material.colour_texture, std::move(colour));
    tissue.textures.emplace_back(tissue.material.normal_texture, std::move(normal));
    return tissue;
}

scenes::RenderItem Tissue::item(const Eigen::Isometry3d& X_WM) const {
    return {mesh, X_WM, material, scenes::Label::kTissue, true};
}

void Tissue::add_textures(StereoEndoscope& endoscope) const {
    for (const auto& [name, texture] : textures) endoscope.add_texture(name, texture);
}

}  // namespace atropos::render
