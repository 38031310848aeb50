#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace atropos::render {

/// Smooth random functions of the plane, by hash of the lattice: the same seed and name give the same
/// surface.
class NoiseField {
  public:
    NoiseField(std::uint64_t seed, std::string_view name);

    /// Gradient noise (Perlin 2002) in about [-1, 1]; features of size 1.
    float smooth(float x, float y) const;

    /// Sum of `octaves` of it, each twice as fine and half as strong.
    float fractal(float x, float y, int octaves) const;

    /// The same at (x, y) of each x: several at once in the processor's vectors, to the same bytes.
    std::vector<float> fractal(std::span<const float> x, float y, int octaves) const;

    /// Worley 1996: distance to the nearest and second nearest of one random point a unit cell.
    struct Cells {
        float nearest, second;
    };
    Cells cells(float x, float y) const;

  private:
    std::uint32_t hash(int x, int y) const;
    float gradient(int x, int y, float dx, float dy) const;
    float smooth_at(float x, float y) const;

    std::uint32_t seed_;
};

}  // namespace atropos::render
