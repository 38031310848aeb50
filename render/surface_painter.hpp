#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/tissue.hpp"

namespace atropos::render {

/// A point of a surface: linear colour, height of detail too fine for the mesh, and roughness against the
/// material's.
struct SurfacePoint {
    Eigen::Vector3f colour = Eigen::Vector3f::Zero();
    float detail_m = 0.0f;
    float roughness = 1.0f;
};

/// One preset's rules, asked by place (m).
class SurfacePainter {
  public:
    virtual ~SurfacePainter() = default;
    virtual scenes::Material material() const = 0;
    virtual float height_m(float x_m, float y_m) const = 0;
    virtual SurfacePoint at(float x_m, float y_m) const = 0;
    /// The same for a row of points.
    virtual std::vector<SurfacePoint> row(std::span<const float> x_m, float y_m) const {
        std::vector<SurfacePoint> points;
        for (const float x : x_m) points.push_back(at(x, y_m));
        return points;
    }
};

std::unique_ptr<SurfacePainter> make_mesentery(const TissueOptions& options, std::uint64_t seed);
std::unique_ptr<SurfacePainter> make_training_pad(const TissueOptions& options, std::uint64_t seed);
std::unique_ptr<SurfacePainter> make_drape(const TissueOptions& options, std::uint64_t seed);

}  // namespace atropos::render
