#include <algorithm>
#include <cmath>

#include "render/noise_field.hpp"
#include "render/surface_painter.hpp"
#include "render/vessel_map.hpp"

namespace atropos::render {
namespace {

float smoothstep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

// Peritoneum over muscle and mesentery: pink to red, with lobules of yellow fat, vessels below the surface
// and a wet film over all. Colours: own choice after photographs of laparoscopic abdomens.
class Mesentery final : public SurfacePainter {
  public:
    Mesentery(const TissueOptions& o, std::uint64_t seed)
        : relief_m_(static_cast<float>(o.relief_m)),
          hills_(seed, "hills"),
          fat_(seed, "fat"),
          lobules_(seed, "lobules"),
          blood_(seed, "blood"),
          grain_(seed, "grain"),
          fluid_(seed, "fluid"),
          vessels_(static_cast<float>(o.size_x_m), static_cast<float>(o.size_y_m), 7, 0.00075f, seed,
                   "vessels"),
          capillaries_(static_cast<float>(o.size_x_m), static_cast<float>(o.size_y_m), 70, 0.00020f, seed,
                       "capillaries") {}

    scenes::Material material() const override {
        scenes::Material m;
        m.base_colour.setOnes();
        m.roughness = 0.62f;
        m.specular_f0 = 0.04f;
        m.wetness = 1.0f;
        return m;
    }

    float height_m(float x, float y) const override {
        const float bulge = fat_share(x, y), lobe = bulge > 0.0f ? lobule(x, y) : 0.0f;
        return relief_m_ * (1.7f * hills_.fractal(28.0f * x, 28.0f * y, 3) + 0.30f * bulge * lobe);
    }

    SurfacePoint at(float x, float y) const override { return row(std::span(&x, 1), y)[0]; }

    std::vector<SurfacePoint> row(std::span<const float> x_m, float y) const override {
        const auto fractal = [&](const NoiseField& field, float scale_x, float shift, float scale_y,
                                 int octaves) {
            std::vector<float> x(x_m.size());
            for (std::size_t i = 0; i < x.size(); ++i) x[i] = scale_x * x_m[i] + shift;
            return field.fractal(x, scale_y * y, octaves);
        };
        const auto blotch = fractal(blood_, 55.0f, 0.0f, 55.0f, 4),
                   fine = fractal(grain_, 420.0f, 0.0f, 420.0f, 4),
                   folds = fractal(grain_, 130.0f, 3.0f, 95.0f, 3),
                   wrinkles = fractal(fluid_, 330.0f, 0.0f, 420.0f, 2),
                   puddles = fractal(fluid_, 70.0f, 0.0f, 70.0f, 3),
                   fat = fractal(fat_, 24.0f, 5.0f, 24.0f, 4);
        std::vector<SurfacePoint> points;
        points.reserve(x_m.size());
        for (std::size_t i = 0; i < x_m.size(); ++i)
            points.push_back(
                point(x_m[i], y, {blotch[i], fine[i], folds[i], wrinkles[i], puddles[i], fat[i]}));
        return points;
    }

  private:
    struct Noise {
        float blotch, fine, folds, wrinkles, puddles, fat;
    };

    SurfacePoint point(float x, float y, const Noise& n) const {
        const float fat = fat_share(x, y, n.fat), lobe = fat > 0.0f ? lobule(x, y) : 0.0f;
        const Eigen::Vector3f pale(0.60f, 0.26f, 0.215f), red(0.37f, 0.085f, 0.068f),
            yellow(0.74f, 0.50f, 0.17f);
        Eigen::Vector3f colour = pale + smoothstep(-0.35f, 0.45f, n.blotch) * (red - pale);
        colour *= 1.0f + 0.30f * n.fine;
        const Eigen::Vector3f lobe_colour = yellow * (0.62f + 0.42f * lobe) * (1.0f + 0.12f * n.fine);
        colour += fat * (lobe_colour - colour);

        const float deep = (1.0f - 0.55f * fat) * vessels_.at(x, y),
                    shallow = (1.0f - 0.4f * fat) * capillaries_.at(x, y);
        const Eigen::Vector3f vein(0.20f, 0.030f, 0.045f), artery(0.36f, 0.035f, 0.030f);
        colour += 0.80f * deep * (vein - colour);
        colour += 0.55f * shallow * (artery - colour);

        const float folds = 1.0f - std::abs(n.folds) * 2.0f;
        SurfacePoint p;
        p.colour = colour;
        const float wet = smoothstep(-0.15f, 0.25f, n.puddles);
        p.detail_m = 2.4e-4f * (1.0f - fat) * folds + 5e-5f * n.fine + 4e-4f * deep + 1e-4f * shallow +
                     7e-4f * fat * lobe + (4e-4f + 19e-4f * wet) * (1.0f - 0.6f * fat) * n.wrinkles;
        p.roughness = std::clamp(0.9f - 0.55f * wet, 0.25f, 1.0f);
        return p;
    }

    float fat_share(float x, float y, float noise) const {
        constexpr float kLow = 0.10f, kHigh = 0.26f, kEdge = 0.10f;
        if (noise < kLow - 1.5f * kEdge) return 0.0f;  // most of the surface: the edge's noise is within 1.5
        return smoothstep(kLow, kHigh, noise + kEdge * fat_.smooth(260.0f * x, 260.0f * y));
    }
    float fat_share(float x, float y) const {
        return fat_share(x, y, fat_.fractal(24.0f * x + 5.0f, 24.0f * y, 4));
    }

    // 1 in the middle of a lobule of fat, 0 in the seams between.
    float lobule(float x, float y) const {
        const float bend = 0.35f * fat_.smooth(180.0f * x, 180.0f * y);
        const NoiseField::Cells c = lobules_.cells(330.0f * x + bend, 330.0f * y - bend);
        return smoothstep(0.0f, 0.45f, c.second - c.nearest);
    }

    float relief_m_;
    NoiseField hills_, fat_, lobules_, blood_, grain_, fluid_;
    VesselMap vessels_, capillaries_;
};

}  // namespace

std::unique_ptr<SurfacePainter> make_mesentery(const TissueOptions& options, std::uint64_t seed) {
    return std::make_unique<Mesentery>(options, seed);
}

}  // namespace atropos::render
