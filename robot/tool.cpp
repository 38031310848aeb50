#include "robot/tool.hpp"

#include <algorithm>
#include <cctype>
#include <numbers>
#include <stdexcept>
#include <string>

namespace atropos::robot {
namespace {

using scenes::Capsule;
constexpr double kDegree = std::numbers::pi / 180.0;

// Own choices (m). The grip lies 8 mm beyond the wrist-yaw axis, in the last third of 11 mm jaws.
constexpr double kShaftRadius = 0.0042, kWristRadius = 0.0040, kHubRadius = 0.0028;
constexpr double kJawReach = 0.011, kGrip = 0.008, kBlade = 0.0075;

Eigen::Isometry3d beyond_tip(double y_m, double z_m) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    X.linear() = R_TG();
    X.translation() = R_TG() * Eigen::Vector3d(0.0, y_m, z_m);
    return X;
}

// Right halves mirror left ones in the plane x = 0.
Capsule mirrored(const Capsule& c) {
    const Eigen::Vector3d flip(-1.0, 1.0, 1.0);
    return {c.a.cwiseProduct(flip), c.b.cwiseProduct(flip), c.radius_m};
}

Capsule hub() {
    return {{0.0, -0.001, 0.0}, {0.0, 0.001, 0.0}, kHubRadius};
}

// Two rods, thick then thin, whose inner faces touch the plane x = 0 when the jaws are shut.
std::vector<Capsule> grasper_jaw(double base_radius_m, double tip_radius_m) {
    const double middle = 0.006;
    return {hub(),
            {{base_radius_m, 0.0, 0.002}, {base_radius_m, 0.0, middle}, base_radius_m},
            {{tip_radius_m, 0.0, middle}, {tip_radius_m, 0.0, kJawReach - tip_radius_m}, tip_radius_m}};
}

// A blade lies beside its partner (offset along the pin) so that they pass each other; `bow_m` is how far
// curved blades have left the plane y = 0 at their point. Its back is towards +x, its edge on x = 0.
std::vector<Capsule> blade(double bow_m) {
    const double radius = 0.0008, beside = 0.0006, middle = 0.006;
    const auto at = [&](double z) {
        return Eigen::Vector3d(radius, beside + bow_m * (z / kJawReach) * (z / kJawReach), z);
    };
    return {hub(), {at(0.0015), at(middle), radius}, {at(middle), at(kJawReach - radius), radius}};
}

Tool make(std::string_view name, int part_number, ToolKind kind, double pitch_to_yaw_m, double pitch_deg,
          double yaw_deg, double jaw_min_deg, double jaw_max_deg) {
    Tool t;
    t.name = name;
    t.part_number = part_number;
    t.kind = kind;
    t.pitch_to_yaw_m = pitch_to_yaw_m;
    t.wrist_pitch_max_rad = pitch_deg * kDegree;
    t.wrist_yaw_max_rad = yaw_deg * kDegree;
    t.jaw_min_rad = jaw_min_deg * kDegree;
    t.jaw_max_rad = jaw_max_deg * kDegree;
    t.X_TG = beyond_tip(0.0, kGrip);
    // What lies outside the patient (carriage, arm) is not modelled: the shaft ends where DH frame 3 sits.
    t.capsules[kShaft] = {{{0.0, 0.0, -t.shaft_m}, {0.0, 0.0, 0.0}, kShaftRadius}};
    t.capsules[kWrist] = {{{0.0, 0.0, 0.0}, {0.0, 0.0, pitch_to_yaw_m}, kWristRadius}};
    return t;
}

Tool with_jaws(Tool t, double base_radius_m, double tip_radius_m) {
    t.capsules[kJawLeft] = grasper_jaw(base_radius_m, tip_radius_m);
    for (const Capsule& c : t.capsules[kJawLeft]) t.capsules[kJawRight].push_back(mirrored(c));
    return t;
}

Tool with_blades(Tool t, double bow_m) {
    t.capsules[kJawLeft] = blade(bow_m);
    const Eigen::Vector3d beside(0.0, 0.0012, 0.0);
    for (const Capsule& c : t.capsules[kJawLeft]) t.capsules[kJawRight].push_back(mirrored(c));
    for (size_t i = 1; i < t.capsules[kJawRight].size(); ++i) {
        t.capsules[kJawRight][i].a -= beside;
        t.capsules[kJawRight][i].b -= beside;
    }
    t.X_TS = beyond_tip(bow_m * (kBlade / kJawReach) * (kBlade / kJawReach), kBlade);
    return t;
}

std::vector<Tool> make_tools() {
    constexpr auto kG = ToolKind::kGrasper, kS = ToolKind::kScissors;
    Tool suture_cut =
        with_jaws(make("LRG_SUTURECUT_NEEDLE_DRIVER", 400296, kG, 0.0091, 80, 80, -20, 45), 0.0016, 0.0012);
    suture_cut.X_TS = beyond_tip(0.0, 0.0045);  // its blades sit between the pin and the inserts
    return {
        with_blades(make("POTTS_SCISSORS", 400001, kS, 0.0091, 80, 80, -40, 30), 0.0),
        with_jaws(make("LARGE_NEEDLE_DRIVER", 400006, kG, 0.0091, 80, 80, -40, 80), 0.0017, 0.0012),
        with_blades(make("ROUND_TIP_SCISSORS", 400007, kS, 0.0091, 80, 80, -40, 40), 0.0),
        with_jaws(make("DEBAKEY_FORCEPS", 400036, kG, 0.0091, 80, 80, -20, 80), 0.0015, 0.0009),
        with_jaws(make("CADIERE_FORCEPS", 400049, kG, 0.0091, 80, 80, -20, 80), 0.0017, 0.0014),
        with_jaws(make("PROGRASP_FORCEPS", 400093, kG, 0.0107, 80, 80, -20, 80), 0.0018, 0.0015),
        with_jaws(make("MARYLAND_BIPOLAR_FORCEPS", 400172, kG, 0.0107, 70, 90, -20, 80), 0.0015, 0.0009),
        with_blades(make("CURVED_SCISSORS", 400178, kS, 0.0091, 80, 80, -20, 80), 0.0015),
        with_blades(make("MONOPOLAR_CURVED_SCISSORS", 400179, kS, 0.0091, 80, 80, -20, 80), 0.0015),
        with_jaws(make("MEGA_NEEDLE_DRIVER", 400194, kG, 0.0112, 70, 80, -20, 80), 0.0019, 0.0014),
        suture_cut,
    };
}

std::string upper(std::string_view text) {
    std::string s(text);
    std::transform(s.begin(), s.end(), s.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return s;
}

}  // namespace

Eigen::Matrix3d R_TG() {
    return (Eigen::Matrix3d() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished();
}

const std::vector<Tool>& tools() {
    static const std::vector<Tool> kTools = make_tools();
    return kTools;
}

const Tool& tool(std::string_view name) {
    const std::string wanted = upper(name);
    std::string known;
    for (const Tool& t : tools()) {
        if (wanted == t.name || wanted + "_FORCEPS" == t.name ||
            wanted == std::string(t.name) + ":" + std::to_string(t.part_number))
            return t;
        known += (known.empty() ? "" : ", ") + std::string(t.name);
    }
    throw std::invalid_argument("no instrument '" + std::string(name) + "', expected one of " + known);
}

}  // namespace atropos::robot
