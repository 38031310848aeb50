#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "render/mesh_file.hpp"

namespace atropos::render {

/// Drawn parts of an instrument by link, in the link frames of the meshes: z distal, y the jaws' pin with the
/// wrist straight; shaft and wrist from the wrist-pitch axis, jaws from the wrist-yaw axis, each turned by
/// half the jaw angle about y (left +, right -).
struct InstrumentModel {
    std::array<std::vector<MeshPart>, 4> links;  ///< in the order of kInstrumentLinks

    /// Render items of one link at a pose.
    void append(int link, const Eigen::Isometry3d& X_WL, scenes::Label label,
                std::vector<scenes::RenderItem>& items) const;
};

inline constexpr std::array<std::string_view, 4> kInstrumentLinks = {"shaft", "wrist", "jaw_left",
                                                                     "jaw_right"};

/// Folder under scenes/meshes that draws an instrument of dVRK's name: needle_driver, prograsp,
/// curved_scissors or round_tip_scissors, by its kind. Throws std::invalid_argument for names of none.
std::string instrument_folder(std::string_view tool_name);

/// Reads shaft, wrist, jaw_left, jaw_right from `folder`, each as .obj, .stl or .ply. Throws as load_mesh
/// does.
InstrumentModel load_instrument(const std::string& folder, double scale_to_m = 1e-3);

/// Puts the meshes that `folder` has into their links' places; the others stay. Throws std::invalid_argument
/// when it has none or `scale_to_m` isn't positive, and as load_mesh does.
void replace_links(InstrumentModel& model, const std::string& folder, double scale_to_m);

/// Steel, composite and so on: the look of a material the instruments' files name; any other as the file
/// says.
scenes::Material instrument_material(const std::string& name, const scenes::Material& otherwise);

}  // namespace atropos::render
