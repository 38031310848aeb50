#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/texture.hpp"
#include "scenes/render_item.hpp"

namespace atropos::render {

class StereoEndoscope;

/// What the instruments work over: a height field about the origin, z up.
struct TissueOptions {
    std::string preset =
        "tissue";  ///< tissue (mesentery with fat and vessels), pad (suture trainer), drape (cloth)
    double size_x_m = 0.18;
    double size_y_m = 0.14;
    double cell_m = 0.0015;    ///< edge of the grid's squares: 7 px at 120 mm on a 640 wide image, for speed
    double relief_m = 0.0035;  ///< height of hills over valleys, about
    int texture_px = 1024;     ///< a side
};

/// Surface with its material and textures as data. The mesh is drawn and collided with as it is.
struct Tissue {
    std::shared_ptr<const scenes::TriangleMesh> mesh;
    scenes::Material material;  ///< names the textures below
    std::vector<std::pair<std::string, Texture>> textures;

    /// At rest, labelled tissue.
    scenes::RenderItem item(const Eigen::Isometry3d& X_WM = Eigen::Isometry3d::Identity()) const;

    void add_textures(StereoEndoscope& endoscope) const;
};

/// Deterministic from options and seed. Throws std::invalid_argument for unknown presets and sizes out of
/// range.
Tissue make_tissue(const TissueOptions& options, std::uint64_t seed);

}  // namespace atropos::render
