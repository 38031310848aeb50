#include <algorithm>
#include <cmath>

#include "render/noise_field.hpp"
#include "render/surface_painter.hpp"

namespace atropos::render {
namespace {

constexpr float kHalfX_m = 0.055f, kHalfY_m = 0.040f, kThickness_m = 0.008f, kRound_m = 0.004f;

float smoothstep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

// A suture trainer: a slab of skin-coloured silicone on a gray tray, three cuts in it and printed marks
// beside them.
class TrainingPad final : public SurfacePainter {
  public:
    TrainingPad(const TissueOptions& o, std::uint64_t seed)
        : relief_m_(static_cast<float>(o.relief_m)), waves_(seed, "pad waves"), grain_(seed, "pad grain") {}

    scenes::Material material() const override {
        scenes::Material m;
        m.base_colour.setOnes();
        m.roughness = 0.55f;
        return m;
    }

    float height_m(float x, float y) const override {
        const float on = on_pad(x, y);
        return -kThickness_m * (1.0f - on) +
               on * (0.25f * relief_m_ * waves_.fractal(15.0f * x, 15.0f * y, 2) - 0.0016f * cut(x, y));
    }

    SurfacePoint at(float x, float y) const override {
        const float on = on_pad(x, y), open = cut(x, y), fine = grain_.fractal(900.0f * x, 900.0f * y, 3);
        const Eigen::Vector3f tray(0.33f, 0.36f, 0.38f), skin(0.66f, 0.36f, 0.24f),
            flesh(0.42f, 0.06f, 0.05f), ink(0.05f, 0.05f, 0.12f);
        Eigen::Vector3f colour = tray + on * (skin - tray);
        colour *= 1.0f + 0.07f * fine + 0.10f * waves_.fractal(60.0f * x, 60.0f * y, 3);
        colour += open * (flesh - colour);
        colour += on * mark(x, y) * (ink - colour);
        return {colour, 2.2e-5f * fine, std::clamp(0.85f + 0.25f * fine, 0.4f, 1.0f)};
    }

  private:
    static float on_pad(float x, float y) {
        const float dx = std::max(std::abs(x) - kHalfX_m + kRound_m, 0.0f),
                    dy = std::max(std::abs(y) - kHalfY_m + kRound_m, 0.0f);
        return 1.0f - smoothstep(0.0f, kRound_m, std::hypot(dx, dy));
    }

    static constexpr float kCuts_m[] = {-0.022f, 0.0f, 0.022f};

    static float cut(float x, float y) {
        float depth = 0.0f;
        for (const float at_y : kCuts_m) {
            const float along = 1.0f - smoothstep(0.024f, 0.030f, std::abs(x));
            depth = std::max(depth, along * (1.0f - smoothstep(0.0003f, 0.0011f, std::abs(y - at_y))));
        }
        return depth;
    }

    static float mark(float x, float y) {
        float ink = 0.0f;
        for (const float at_y : kCuts_m) {
            for (const float side : {-0.005f, 0.005f}) {
                const float nearest_x = std::clamp(std::round(x / 0.008f), -3.0f, 3.0f) * 0.008f;
                const float d = std::hypot(x - nearest_x, y - at_y - side);
                ink = std::max(ink, 1.0f - smoothstep(0.0006f, 0.0009f, d));
            }
        }
        return ink;
    }

    float relief_m_;
    NoiseField waves_, grain_;
};

// Woven cloth in soft folds.
class Drape final : public SurfacePainter {
  public:
    Drape(const TissueOptions& o, std::uint64_t seed)
        : relief_m_(static_cast<float>(o.relief_m)),
          folds_(seed, "drape folds"),
          grain_(seed, "drape grain") {}

    scenes::Material material() const override {
        scenes::Material m;
        m.base_colour.setOnes();
        m.roughness = 0.9f;
        return m;
    }

    float height_m(float x, float y) const override {
        const float bend = 0.6f * folds_.smooth(14.0f * x, 14.0f * y);
        const float ridge = 1.0f - std::abs(folds_.smooth(22.0f * x + bend, 9.0f * y - bend));
        return relief_m_ *
               (1.1f * ridge * ridge + 0.9f * folds_.fractal(18.0f * x + 7.0f, 18.0f * y, 2) - 0.8f);
    }

    SurfacePoint at(float x, float y) const override {
        constexpr float kThreads_per_m = 2.0f * 3.14159265f / 0.0009f;
        const float warp = std::sin(kThreads_per_m * x), weft = std::sin(kThreads_per_m * y);
        const float fine = grain_.fractal(500.0f * x, 500.0f * y, 3), weave = warp * weft;
        const Eigen::Vector3f blue(0.030f, 0.175f, 0.225f);
        return {blue * (1.0f + 0.14f * weave + 0.22f * fine), 1.6e-5f * weave + 2e-5f * fine, 1.0f};
    }

  private:
    float relief_m_;
    NoiseField folds_, grain_;
};

}  // namespace

std::unique_ptr<SurfacePainter> make_training_pad(const TissueOptions& options, std::uint64_t seed) {
    return std::make_unique<TrainingPad>(options, seed);
}

std::unique_ptr<SurfacePainter> make_drape(const TissueOptions& options, std::uint64_t seed) {
    return std::make_unique<Drape>(options, seed);
}

}  // namespace atropos::render
