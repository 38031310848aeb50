#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>

#include "scenes/triangle_mesh.hpp"

namespace atropos::scenes {

/// What a pixel shows; the values of the mask pictures.
enum class Label : std::uint8_t {
    kBackground = 0,
    kThread = 1,
    kTissue = 2,
    kPSM1 = 3,
    kPSM2 = 4,
    kPSM3 = 5,
    kNeedle = 6,
    kOther = 7,
};

/// Surface of a mesh: metallic-roughness, colours linear in [0, 1].
struct Material {
    Eigen::Vector3f base_colour = Eigen::Vector3f::Constant(0.5f);
    float metallic = 0.0f;
    float roughness = 0.5f;
    float specular_f0 = 0.04f;  ///< reflectance at normal incidence of the dielectric part
    float wetness = 0.0f;  ///< strength in [0, 1] of a thin film of fluid, and of light scattered below it
    std::string
        colour_texture;  ///< file or a renderer's registered name, or empty; multiplied with `base_colour`
    std::string
        normal_texture;  ///< tangent-space normal map likewise, alpha multiplies `roughness`; or empty
};

/// One thing to draw. Meshes are shared between the renderer and the physics, and never change.
struct RenderItem {
    std::shared_ptr<const TriangleMesh> mesh;
    Eigen::Isometry3d X_WM = Eigen::Isometry3d::Identity();  ///< pose of the mesh in the world
    Material material;
    Label label = Label::kOther;
    bool at_rest = false;  ///< true: never moves relative to the world, so that its layer may be cached
};

}  // namespace atropos::scenes
