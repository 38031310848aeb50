#include "render/instrument.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <stdexcept>

#include "scenes/file_error.hpp"

namespace atropos::render {
namespace {

struct Look {
    std::string_view name;
    Eigen::Vector3f colour;
    float metallic, roughness;
};

// Own choice: brushed stainless steel, tungsten carbide, a matt black composite tube.
const std::array<Look, 7> kLooks = {{{"steel", {0.62f, 0.60f, 0.58f}, 1.0f, 0.34f},
                                     {"steel_dark", {0.20f, 0.20f, 0.21f}, 1.0f, 0.45f},
                                     {"pin", {0.75f, 0.73f, 0.70f}, 1.0f, 0.22f},
                                     {"blade", {0.70f, 0.69f, 0.68f}, 1.0f, 0.24f},
                                     {"carbide", {0.33f, 0.32f, 0.32f}, 1.0f, 0.42f},
                                     {"cable", {0.50f, 0.49f, 0.48f}, 1.0f, 0.40f},
                                     {"composite", {0.016f, 0.016f, 0.018f}, 0.0f, 0.42f}}};

/// Empty when the folder has none.
std::string link_file(const std::string& folder, std::string_view link) {
    for (const char* extension : {".obj", ".stl", ".ply"}) {
        const std::string file = (std::filesystem::path(folder) / link).string() + extension;
        if (std::filesystem::exists(file)) return file;
    }
    return {};
}

std::vector<MeshPart> link_parts(const std::string& file, double scale_to_m) {
    std::vector<MeshPart> parts = load_mesh_parts(file, scale_to_m);
    for (MeshPart& part : parts) part.material = instrument_material(part.material_name, part.material);
    return parts;
}

}  // namespace

std::string instrument_folder(std::string_view tool_name) {
    std::string name(tool_name);
    std::transform(name.begin(), name.end(), name.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
    if (has("needle_driver")) return "needle_driver";
    if (has("round_tip_scissors") || has("potts")) return "round_tip_scissors";
    if (has("scissors")) return "curved_scissors";
    if (has("forceps") || has("prograsp") || has("grasper")) return "prograsp";
    throw std::invalid_argument("no model for instrument '" + std::string(tool_name) +
                                "', expected a needle driver, forceps or scissors");
}

scenes::Material instrument_material(const std::string& name, const scenes::Material& otherwise) {
    scenes::Material material = otherwise;
    for (const Look& look : kLooks) {
        if (look.name != name) continue;
        material.base_colour = look.colour;
        material.metallic = look.metallic;
        material.roughness = look.roughness;
    }
    return material;
}

InstrumentModel load_instrument(const std::string& folder, double scale_to_m) {
    InstrumentModel model;
    for (std::size_t i = 0; i < kInstrumentLinks.size(); ++i) {
        const std::string file = link_file(folder, kInstrumentLinks[i]), link(kInstrumentLinks[i]);
        if (file.empty())
            throw scenes::FileError(
                folder, "no mesh of link '" + link + "', expected " + link + ".obj, .stl or .ply");
        model.links[i] = link_parts(file, scale_to_m);
    }
    return model;
}

void replace_links(InstrumentModel& model, const std::string& folder, double scale_to_m) {
    if (!(scale_to_m > 0.0))
        throw std::invalid_argument(folder +
                                    ": no mesh_scale_m given, expected metres a unit of these meshes");
    bool any = false;
    for (std::size_t i = 0; i < kInstrumentLinks.size(); ++i) {
        const std::string file = link_file(folder, kInstrumentLinks[i]);
        if (file.empty()) continue;
        model.links[i] = link_parts(file, scale_to_m);
        any = true;
    }
    if (!any)
        throw std::invalid_argument(
            folder +
            ": no mesh in it, expected shaft, wrist, jaw_left or jaw_right as .obj, .stl "
            "or .ply");
}

void InstrumentModel::append(int link, const Eigen::Isometry3d& X_WL, scenes::Label label,
                             std::vector<scenes::RenderItem>& items) const {
    for (const MeshPart& part : links.at(static_cast<std::size_t>(link))) {
        items.push_back({part.mesh, X_WL, part.material, label, false});
    }
}

}  // namespace atropos::render
