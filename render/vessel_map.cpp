#include "render/vessel_map.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/random_stream.hpp"

namespace atropos::render {
namespace {

constexpr float kCell_m = 1.2e-4f;

struct Walk {
    double x_m, y_m, heading_rad, radius_m, length_m;
};

}  // namespace

VesselMap::VesselMap(float size_x_m, float size_y_m, int vessels, float radius_m, std::uint64_t seed,
                     const char* name)
    : size_x_m_(size_x_m),
      size_y_m_(size_y_m),
      columns_(static_cast<int>(size_x_m / kCell_m) + 2),
      rows_(static_cast<int>(size_y_m / kCell_m) + 2),
      depth_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), 0.0f) {
    scenes::RandomStream random(seed, name);
    std::vector<Walk> walks;
    for (int i = 0; i < vessels; ++i) {
        walks.push_back({random.uniform(-0.5, 0.5) * size_x_m, random.uniform(-0.5, 0.5) * size_y_m,
                         random.uniform(0.0, 2.0 * std::numbers::pi), radius_m * random.uniform(0.6, 1.0),
                         random.uniform(0.03, 0.10)});
    }
    constexpr std::size_t kMostWalks = 4000;
    for (std::size_t i = 0; i < walks.size(); ++i) {
        Walk w = walks[i];
        const double step_m = 1.5e-4, start_m = w.radius_m;
        double turn = 0.0;
        for (double done_m = 0.0; done_m < w.length_m; done_m += step_m) {
            turn = 0.96 * turn + random.normal(0.0, 0.012);
            w.heading_rad += turn;
            w.x_m += step_m * std::cos(w.heading_rad);
            w.y_m += step_m * std::sin(w.heading_rad);
            w.radius_m = start_m * (1.0 - 0.75 * done_m / w.length_m);
            stamp(static_cast<float>(w.x_m), static_cast<float>(w.y_m), static_cast<float>(w.radius_m));
            const bool can_branch = w.radius_m > 0.00009 && walks.size() < kMostWalks;
            if (random.uniform() < 0.018 && can_branch) {
                const double side = random.uniform() < 0.5 ? -1.0 : 1.0;
                walks.push_back({w.x_m, w.y_m, w.heading_rad + side * random.uniform(0.4, 1.1),
                                 w.radius_m * random.uniform(0.45, 0.75),
                                 0.55 * (w.length_m - done_m) + 0.004});
            }
        }
    }
}

void VesselMap::stamp(float x_m, float y_m, float radius_m) {
    const float ci = (x_m + 0.5f * size_x_m_) / kCell_m, cj = (y_m + 0.5f * size_y_m_) / kCell_m;
    const float r = radius_m / kCell_m, strength = std::min(1.0f, 0.35f + 0.5f * r);
    const float reach = std::max(r, 1.0f);
    for (int j = static_cast<int>(std::floor(cj - reach)); j <= static_cast<int>(std::ceil(cj + reach));
         ++j) {
        for (int i = static_cast<int>(std::floor(ci - reach)); i <= static_cast<int>(std::ceil(ci + reach));
             ++i) {
            if (i < 0 || j < 0 || i >= columns_ || j >= rows_) continue;
            const float d = std::hypot(static_cast<float>(i) - ci, static_cast<float>(j) - cj) / reach;
            float& depth = depth_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                                  static_cast<std::size_t>(i)];
            depth = std::max(depth, strength * std::sqrt(std::max(0.0f, 1.0f - d * d)));
        }
    }
}

float VesselMap::cell(int i, int j) const {
    i = std::clamp(i, 0, columns_ - 1);
    j = std::clamp(j, 0, rows_ - 1);
    return depth_[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns_) +
                  static_cast<std::size_t>(i)];
}

float VesselMap::at(float x_m, float y_m) const {
    const float ci = (x_m + 0.5f * size_x_m_) / kCell_m, cj = (y_m + 0.5f * size_y_m_) / kCell_m;
    const int i = static_cast<int>(std::floor(ci)), j = static_cast<int>(std::floor(cj));
    const float u = ci - static_cast<float>(i), v = cj - static_cast<float>(j);
    return std::lerp(std::lerp(cell(i, j), cell(i + 1, j), u),
                     std::lerp(cell(i, j + 1), cell(i + 1, j + 1), u), v);
}

}  // namespace atropos::render
