#pragma once

#include <cstdint>
#include <vector>

namespace atropos::render {

/// Blood vessels that wander and branch over a rectangle about the origin, kept as a grid of depths.
class VesselMap {
  public:
    VesselMap(float size_x_m, float size_y_m, int vessels, float radius_m, std::uint64_t seed,
              const char* name);

    /// 1 over a vessel's middle, falling to 0 at its edge; interpolated.
    float at(float x_m, float y_m) const;

  private:
    void stamp(float x_m, float y_m, float radius_m);
    float cell(int i, int j) const;

    float size_x_m_, size_y_m_;
    int columns_, rows_;
    std::vector<float> depth_;
};

}  // namespace atropos::render
