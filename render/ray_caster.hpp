#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "scenes/triangle_mesh.hpp"

namespace atropos::render {

/// Rays against one mesh through a tree of boxes. Only front faces count, as in the pictures.
class RayCaster {
  public:
    explicit RayCaster(const scenes::TriangleMesh& mesh);

    /// Smallest t in (0, t_max) at which origin + t * direction enters a triangle from its front; mesh's
    /// frame.
    std::optional<double> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                               double t_max) const;

  private:
    struct Node {
        Eigen::Array3f low, high;
        std::uint32_t first;  ///< leaf: first triangle; else: the second child (the first follows its parent)
        std::uint32_t count;  ///< triangles of a leaf; 0: inner node
    };
    struct Triangle {
        Eigen::Vector3f a, ab, ac;
    };

    void build(std::vector<Triangle>& triangles, std::size_t first, std::size_t end);

    std::vector<Node> nodes_;
    std::vector<Triangle> triangles_;
};

}  // namespace atropos::render
