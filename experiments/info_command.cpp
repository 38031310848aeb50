#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <memory>

#include "experiments/commands.hpp"
#include "experiments/dataset.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/result_tables.hpp"
#include "experiments/scene_description.hpp"
#include "experiments/sequence.hpp"
#include "experiments/track_reader.hpp"
#include "render/mesh_file.hpp"
#include "render/texture.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

struct InfoOptions {
    std::string path;
    bool cameras = false;
    bool scene_keys = false;
    bool verify = false;
    double scale_to_m = 0.0;
    std::vector<double> sag_mm;  ///< length, sag
    std::vector<std::string> overrides;
};

void print_rig(const scenes::StereoRig& rig, double distance_m) {
    fmt::print("image              {} x {} px\n", rig.left.width_px, rig.left.height_px);
    fmt::print("focal length       {:.2f} px left, {:.2f} px right\n", rig.left.fx_px, rig.right.fx_px);
    fmt::print("baseline           {:.3f} mm\n", 1e3 * rig.baseline_m());
    fmt::print("distortion         {}\n",
               rig.left.is_distorted() || rig.right.is_distorted() ? "yes" : "none");
    fmt::print("at {:5.1f} mm        {:.3f} mm per px across, {:.2f} mm per px of disparity\n",
               1e3 * distance_m, 1e3 * rig.m_per_px(distance_m), 1e3 * rig.m_per_disparity_px(distance_m));
}

int list_cameras() {
    for (const scenes::RigPreset& preset : scenes::rig_presets()) {
        fmt::print("{}: {}\n", preset.name, preset.source);
        print_rig(preset.rig, preset.working_distance_m);
        fmt::print("\n");
    }
    return kDone;
}

int describe_scene(const fs::path& path, const std::vector<std::string>& overrides) {
    const scenes::SceneConfig scene = scenes::load_scene(path, overrides);
    const scenes::StereoRig rig = scenes::scene_rig(scene.camera);
    const double distance_m = scene.camera.working_distance_m > 0.0 ? scene.camera.working_distance_m
                              : scene.camera.calibration.empty()
                                  ? scenes::rig_preset(scene.camera.preset).working_distance_m
                                  : 0.1;
    fmt::print("scene              {} (seed {}, {} s at {} frames a second)\n", scene.name, scene.seed,
               scene.duration_s, scene.camera.fps_hz);
    print_rig(rig, distance_m);
    fmt::print("\n{}\n{}", describe_arms(scene), describe_thread(scene));
    fmt::print("\nresolved:\n{}", scenes::to_yaml(scene));
    return kDone;
}

bool has_extension(const fs::path& path, std::initializer_list<const char*> extensions) {
    std::string extension = path.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

int describe_mesh(const fs::path& path, double scale_to_m) {
    const bool in_metres = has_extension(path, {".dae", ".gltf", ".glb"});  // by their formats' own words
    if (scale_to_m <= 0.0 && !in_metres)
        throw scenes::FileError(path.string(),
                                "no unit in this format, expected --scale-to-m, 0.001 for millimetres");
    const render::MeshInfo mesh =
        render::mesh_info(render::load_mesh(path.string(), scale_to_m > 0.0 ? scale_to_m : 1.0));
    const Eigen::Vector3d low = 1e3 * mesh.low_m, high = 1e3 * mesh.high_m;
    fmt::print("mesh               {} vertices, {} triangles\n", mesh.vertices, mesh.triangles);
    fmt::print("box                {:.3f} x {:.3f} x {:.3f} mm\n", high.x() - low.x(), high.y() - low.y(),
               high.z() - low.z());
    fmt::print("from, to           [{:.3f}, {:.3f}, {:.3f}], [{:.3f}, {:.3f}, {:.3f}] mm\n", low.x(), low.y(),
               low.z(), high.x(), high.y(), high.z());
    if (!mesh.warning.empty()) fmt::print("warning: {}\n", mesh.warning);
    return kDone;
}

int describe_picture(const fs::path& path) {
    const render::Texture texture = render::load_texture(path.string(), true);
    fmt::print("picture            {} x {} px\n", texture.width_px, texture.height_px);
    return kDone;
}

bool looks_like_calibration(const fs::path& path) {
    if (fs::is_directory(path)) return fs::exists(path / "stereo.yaml") || fs::exists(path / "left.yaml");
    if (path.extension() == ".ini") return true;
    return scenes::read_text_file(path, 4 << 20).starts_with("%YAML:1.0");
}

int describe_dataset_folder(const fs::path& path, bool verify) {
    const auto dataset =
        nlohmann::ordered_json::parse(scenes::read_text_file(path / "dataset.json", 1 << 30), nullptr, false);
    if (verify) verify_dataset(path);
    try {
        fmt::print("dataset            {}: {} sequences, {} stereo frames, {:.1f} MB\n",
                   dataset.at("name").get<std::string>(), dataset.at("count").get<long>(),
                   dataset.at("frames").get<long>(), 1e-6 * dataset.at("bytes").get<double>());
        for (const auto& [split, names] : dataset.at("splits").items())
            fmt::print("{:<19}{} sequences\n", split, names.size());
    } catch (const nlohmann::json::exception&) {
        throw scenes::FileError((path / "dataset.json").string(),
                                "a key is missing or of another type, expected the file as it was written");
    }
    return kDone;
}

int describe_folder(const fs::path& path, bool verify) {
    if (fs::exists(path / "dataset.json")) {
        describe_dataset_folder(path, verify);
    } else if (fs::exists(path / "calib") && fs::is_directory(path / "left")) {
        const Sequence sequence = Sequence::open(path);
        fmt::print("sequence           {} frames, {:.3f} to {:.3f} s\n", sequence.frames(),
                   sequence.time_s(0), sequence.time_s(sequence.frames() - 1));
        print_rig(sequence.rig(), 0.1);
        if (verify) verify_sequence(path);
    } else if (fs::exists(path / "track.csv")) {
        const auto frames = read_track(path);
        long lost = 0;
        for (const TrackedFrame& frame : frames) lost += frame.estimate.samples.empty() ? 1 : 0;
        fmt::print("track              {} frames, {} without a curve\n", frames.size(), lost);
    } else if (fs::exists(path / "experiment.json")) {
        fmt::print("{}", markdown_tables(read_results(path)));
    } else {
        throw scenes::FileError(
            path.string(),
            "nothing known in this folder, expected a calibration, sequence, dataset, track or experiment");
    }
    if (verify) fmt::print("verified\n");
    return kDone;
}

int info(const InfoOptions& options) {
    if (options.cameras) return list_cameras();
    if (options.scene_keys) {
        fmt::print("{}", scenes::scene_reference_markdown());
        return kDone;
    }
    const fs::path path = options.path;
    if (!options.sag_mm.empty()) {
        const scenes::SceneConfig scene = path.empty()
                                              ? scenes::parse_scene("--set", "{}", ".", options.overrides)
                                              : scenes::load_scene(path, options.overrides);
        fmt::print("{}", describe_sag(scene, options.sag_mm[0], options.sag_mm[1]));
        return kDone;
    }
    if (path.empty()) throw scenes::FileError("info", "no PATH, expected a file or folder to describe");
    if (!fs::exists(path)) throw scenes::FileError(options.path, "no such file or folder");
    if (has_extension(path, {".obj", ".stl", ".ply", ".dae", ".gltf", ".glb"}))
        return describe_mesh(path, options.scale_to_m);
    if (has_extension(path, {".png", ".jpg", ".jpeg"})) return describe_picture(path);
    if (looks_like_calibration(path)) {
        print_rig(scenes::load_calibration(path), 0.1);
        return kDone;
    }
    if (fs::is_directory(path)) return describe_folder(path, options.verify);
    return describe_scene(path, options.overrides);
}

}  // namespace

void add_info_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand(
        "info",
        "checks and describes a scene, calibration, mesh, picture, sequence, dataset, track or "
        "experiment");
    const auto options = std::make_shared<InfoOptions>();
    app->add_option("PATH", options->path, "scene, calibration, mesh or picture file, or a folder");
    app->add_flag("--cameras", options->cameras, "list the camera presets with their sources");
    app->add_flag("--scene-keys", options->scene_keys, "print the reference of scene files (docs/scene.md)");
    app->add_flag("--verify", options->verify, "recompute the checksums of a sequence or dataset");
    app->add_option("--scale-to-m", options->scale_to_m, "metres a unit of a mesh: 0.001 for millimetres")
        ->check(CLI::Range(1e-9, 1e6));
    app->add_option("--fit-sag", options->sag_mm,
                    "EI of the scene's (or the default) thread: L_mm of it, clamped horizontally, hangs down "
                    "by SAG_mm")
        ->expected(2);
    app->add_option("--set", options->overrides, "override a scene key: key.path=value")
        ->expected(1)
        ->take_all();
    app->footer("Example: atropos info scenes/auto_scissors.yaml --set camera.preset=hd");
    app->callback([&chosen, options] { chosen = [options] { return info(*options); }; });
}

}  // namespace atropos::experiments
