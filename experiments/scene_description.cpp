#include "experiments/scene_description.hpp"

#include <fmt/format.h>

#include "experiments/testbed.hpp"
#include "robot/reach_report.hpp"
#include "scenes/scene_file.hpp"
#include "sim/derived_physics.hpp"

namespace atropos::experiments {

std::string describe_arms(const scenes::SceneConfig& scene) {
    const robot::Layout layout = scene_layout(scene);
    robot::LayoutDefaults needs;
    needs.thread_length_m = scene.thread.length_m;
    std::string text = robot::to_text(robot::reach_report(layout, needs));
    const robot::FrameTree tree = robot::frame_tree(layout, scenes::scene_rig(scene.camera));
    const Eigen::Isometry3d X_WC = tree.pose("W", "C");
    const Eigen::Vector3d p = 1e3 * X_WC.translation(), z = X_WC.linear().col(2);
    text += fmt::format("C: left lens ({:.1f}, {:.1f}, {:.1f}) mm, looks along ({:.3f}, {:.3f}, {:.3f})\n",
                        p.x(), p.y(), p.z(), z.x(), z.y(), z.z());
    for (int arm = 0; arm < kArms; ++arm) {
        const scenes::ArmConfig& keys = arm_config(scene, arm);
        text += fmt::format("PSM{} motion: {}", arm + 1, keys.motion);
        if (keys.motion == "replay") {
            const robot::Replay replay = load_replay(scene, arm, tree);
            text += fmt::format(", {:.2f} s of {}, values clamped to limits: {}", replay.duration_s(),
                                keys.recording.file, replay.clamped_values());
        }
        text += '\n';
    }
    return text;
}

std::string describe_thread(const scenes::SceneConfig& scene) {
    const sim::ThreadOptions thread = thread_options(scene.thread);
    const sim::DerivedPhysics p = sim::derived_physics(thread);
    std::string text =
        fmt::format("thread             {:.1f} mm of {} of {:.3f} mm in {} edges, {:.1f} mg/m, {:.2f} mg\n",
                    1e3 * thread.length_m, thread.material.name, 1e3 * thread.diameter_m, thread.edges,
                    1e6 * p.linear_density_kg_m, 1e6 * p.mass_kg);
    text += fmt::format(
        "stiffness          EA {:.4g} N ({:.3f} % a newton), EI {:.3g} N m2, GJ {:.3g} N m2\n",
        thread.material.EA_N, 100.0 * p.strain_at_1_N, thread.material.EI_N_m2, thread.material.GJ_N_m2);
    text += fmt::format("gravity-bending    {:.1f} mm: shorter threads keep the direction of their jaws\n",
                        1e3 * p.gravity_bending_length_m);
    text += fmt::format("edges              {:.3f} mm, {:.2f} diameters\n", 1e3 * p.edge_length_m,
                        p.edge_over_diameter);
    text += fmt::format("buckles at         {:.3g} N, pinned at both ends\n", p.buckling_load_N);
    text += fmt::format(
        "expected cost      {:.2f} CPU s a simulated second, {:.2f} while a knot is drawn tight\n",
        p.expected_cost, p.expected_knot_cost);
    for (const std::string& warning : p.warnings) text += "warning: thread: " + warning + '\n';
    return text;
}

std::string describe_sag(const scenes::SceneConfig& scene, double length_mm, double sag_mm) {
    const sim::ThreadOptions thread = thread_options(scene.thread);
    const double density_kg_m = sim::derived_physics(thread).linear_density_kg_m;
    const double EI = sim::fit_sag_EI(1e-3 * length_mm, 1e-3 * sag_mm, density_kg_m);
    return fmt::format(
        "EI_N_m2: {:.4g}   # {:g} mm sag {:g} mm under {:.2f} mg/m ({}, {:.3f} mm); the material's own: "
        "{:.4g}\n",
        EI, length_mm, sag_mm, 1e6 * density_kg_m, thread.material.name, 1e3 * thread.diameter_m,
        thread.material.EI_N_m2);
}

}  // namespace atropos::experiments
