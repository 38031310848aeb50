#include "render/ribbon_shading.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace atropos::render {
namespace {

// How the surface stands at an angle about the axis: a tilt along and about the axis, and how deep it lies.
struct Braid {
    double tilt_along = 0.0, tilt_about = 0.0, exposed = 1.0;
};

// Strands wind both ways about the axis; the one on top at each place is the higher of two waves. The pattern
// fades out where a turn gets as short as the pixels.
Braid braid(const ThreadRibbon& ribbon, double s_m, double angle, double px_per_m) {
    constexpr double kStrands = 4.0, kTilt = 0.55, kGroove = 0.45;
    const double pitch_m = ribbon.look.pitch_in_diameters * 2.0 * ribbon.radius_m;
    const double fade = std::clamp(pitch_m * px_per_m / 2.0 - 0.6, 0.0, 1.0);
    const double phase = 2.0 * std::numbers::pi * s_m / pitch_m;
    const double right = phase + 0.5 * kStrands * angle, left = phase - 0.5 * kStrands * angle;
    const bool right_on_top = std::cos(right) > std::cos(left);
    const double wave = right_on_top ? right : left;
    return {fade * kTilt * std::sin(wave), (right_on_top ? fade : -fade) * 0.5 * kTilt * std::sin(wave),
            1.0 - fade * kGroove * (0.5 - 0.5 * std::cos(wave))};
}

double ggx(double nh, double nl, double nv, double roughness) {
    const double alpha = roughness * roughness, a2 = alpha * alpha, k = 0.5 * alpha;
    const double q = nh * nh * (a2 - 1.0) + 1.0;
    return a2 / (q * q * 4.0 * (nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
}

}  // namespace

std::array<Eigen::Vector3f, kStrips> shade_cross_section(const ThreadRibbon& ribbon, const EyeLight& lamp,
                                                         const Eigen::Vector3d& p_E,
                                                         const Eigen::Vector3d& along_E, double s_m,
                                                         double px_per_m) {
    std::array<Eigen::Vector3f, kStrips> radiance;
    const ThreadLook& look = ribbon.look;
    if (!look.lit) {
        radiance.fill(look.colour);
        return radiance;
    }
    const bool is_braided = look.surface == ThreadLook::Surface::kBraided;
    const Eigen::Vector3d view = -p_E.normalized();
    const Eigen::Vector3d across =
        along_E.cross(-view).normalized();              // on the image: along turned by +90 degrees
    const Eigen::Vector3d out = across.cross(along_E);  // towards or away from the eye
    const Eigen::Vector3d up = out.dot(view) < 0.0 ? Eigen::Vector3d(-out) : out;
    const Eigen::Vector3d to_light = (lamp.p_EL - p_E).normalized();
    const double incoming = lamp.light.irradiance(p_E - lamp.p_EL, lamp.axis_E);
    const Eigen::Vector3d half = (to_light + view).normalized();
    for (int i = 0; i < kStrips; ++i) {
        const double x = (2.0 * i + 1.0) / kStrips - 1.0;
        const Braid b = is_braided ? braid(ribbon, s_m, std::asin(x), px_per_m) : Braid{};
        const Eigen::Vector3d n =
            (x * across + std::sqrt(1.0 - x * x) * up + b.tilt_along * along_E + b.tilt_about * across)
                .normalized();
        const double nl = std::max(n.dot(to_light), 0.0), nv = std::max(n.dot(view), 1e-3);
        const double grazing = std::pow(1.0 - std::max(half.dot(view), 0.0), 5.0);
        const double mirror = (look.specular_f0 + (1.0 - look.specular_f0) * grazing) *
                              ggx(std::max(n.dot(half), 0.0), nl, nv, look.roughness) * nl;
        const double matt = (is_braided ? nl : 0.75 * nl + 0.25) * b.exposed;  // a smooth thread glows within
        const double rim = look.specular_f0 + 0.35 * std::pow(1.0 - nv, 3.0);
        const double around = lamp.light.ambient * incoming;
        const Eigen::Vector3d cavity(0.40, 0.23, 0.20);
        radiance[static_cast<std::size_t>(i)] = (look.colour.cast<double>() * (matt * incoming + around) +
                                                 Eigen::Vector3d::Constant(mirror * b.exposed * incoming) +
                                                 6.0 * around * rim * b.exposed * cavity)
                                                    .cast<float>();
    }
    return radiance;
}

}  // namespace atropos::render
