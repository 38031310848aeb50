#include "experiments/testbed.hpp"

#include <stdexcept>

#include "robot/layout_defaults.hpp"
#include "robot/tool.hpp"
#include "scenes/scene_file.hpp"
#include "sim/hanging_curve.hpp"

namespace atropos::experiments {
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace {

// Fills the view of the camera, which looks down at 45 degrees from +y, up to its upper edge.
constexpr double kTissueX_m = 0.25, kTissueY_m = 0.16, kTissueShift_m = -0.045;
constexpr double kTail_m = 0.004;  ///< of thread beyond each grip, drawn and not judged

double working_distance_m(const scenes::CameraConfig& camera) {
    if (camera.working_distance_m > 0.0) return camera.working_distance_m;
    return camera.calibration.empty() ? scenes::rig_preset(camera.preset).working_distance_m : 0.1;
}

sim::InstrumentOptions instrument_options(const robot::RobotArm& arm) {
    const robot::Tool& tool = arm.psm().tool();
    sim::InstrumentOptions options;
    options.name = arm.name();
    options.links.assign(tool.capsules.begin(), tool.capsules.end());
    if (tool.kind == robot::ToolKind::kGrasper) {
        options.jaws.emplace();
        options.jaws->pin_to_grip_m = tool.X_TG.translation().norm();
    } else {
        options.blades.emplace();
        options.blades->pin_to_meeting_m = tool.X_TS->translation().norm();
    }
    return options;
}

}  // namespace

sim::ThreadOptions thread_options(const scenes::ThreadConfig& config) {
    sim::ThreadOptions options;
    options.model =
        config.model == scenes::ThreadModel::kRod ? sim::ThreadModel::kRod : sim::ThreadModel::kBulletSoft;
    options.material = sim::thread_material(config.material, config.diameter_m);
    const auto replace = [](double& figure, double value) {
        if (value >= 0.0) figure = value;
    };
    replace(options.material.density_kg_m3, config.density_kg_m3);
    replace(options.material.EA_N, config.EA_N);
    replace(options.material.EI_N_m2, config.EI_N_m2);
    replace(options.material.GJ_N_m2, config.GJ_N_m2);
    replace(options.material.self_friction, config.friction);
    options.diameter_m = config.diameter_m;
    options.length_m = config.length_m + 2.0 * kTail_m;
    options.edges = config.edges;
    return options;
}

Testbed::~Testbed() = default;

Testbed::Testbed(const scenes::SceneConfig& scene) : scene_(scene), rig_(scenes::scene_rig(scene.camera)) {
    robot::Layout layout = scene.arms.layout == "lab_rig"
                               ? robot::lab_rig()
                               : robot::default_layout(working_distance_m(scene.camera));
    tree_ = robot::frame_tree(layout, rig_);
    X_WC_ = tree_.pose("W", "C");
    motion_ = make_grip_motion(scene_, X_WC_);
    build_arms(layout);
    build_world();
}

void Testbed::build_arms(const robot::Layout& layout) {
    const robot::LayoutDefaults defaults;
    const robot::Imperfection imperfection = robot::Imperfection::of(scene_.arms.accuracy);
    const std::array<const scenes::ArmConfig*, kArms> configs = {&scene_.arms.psm1, &scene_.arms.psm2,
                                                                 &scene_.arms.psm3};
    const std::array<Isometry3d, 2> X_WG = motion_->X_WG(0.0);
    if (configs[0]->holds != "start" || configs[1]->holds != "end" || configs[2]->holds != "nothing")
        throw std::invalid_argument("arms: expected PSM1 to hold the start, PSM2 the end, PSM3 nothing");
    for (size_t i = 0; i < kArms; ++i) {
        robot::ArmPlacement placement = layout.arm("PSM" + std::to_string(i + 1));
        placement.tool = configs[i]->tool;
        X_WB_[i] = placement.X_WB;
        const robot::Psm psm(robot::tool(placement.tool));
        const bool holds = i != kScissorsArm;
        const Isometry3d X_WF = holds ? X_WG[i] : defaults.X_WS_parked(placement.X_WB.translation());
        const auto& X_TS = psm.tool().X_TS;
        if (!holds && !X_TS)
            throw std::invalid_argument("arms.PSM3.tool " + placement.tool +
                                        " has no blades, expected scissors");
        const robot::IkResult<robot::Joints> ik =
            robot::joints_for(psm, placement.X_WB, X_WF, holds ? psm.tool().X_TG : *X_TS);
        if (!ik)
            throw std::invalid_argument(placement.name +
                                        " can't reach its starting pose: " + robot::reason(ik));
        arms_[i] = std::make_unique<robot::RobotArm>(
            placement, tree_, ik.q, holds ? defaults.holder_jaw_rad : defaults.parked_jaw_rad, imperfection,
            scene_.seed);
    }
}

void Testbed::build_world() {
    world_ = std::make_unique<sim::World>();
    if (scene_.tissue.preset != "none") {
        render::TissueOptions options;
        options.preset = scene_.tissue.preset == "organ" ? "tissue" : scene_.tissue.preset;
        options.size_x_m = kTissueX_m;
        options.size_y_m = kTissueY_m;
        tissue_ = render::make_tissue(options, scene_.seed);
        world_->add_tissue(*tissue_->mesh, X_WTissue());
    }
    for (const auto& arm : arms_) world_->add_instrument(instrument_options(*arm));
    place_instruments();

    // The true grips, not the commanded ones, say where the thread begins.
    std::array<Isometry3d, 2> X_WG;
    for (size_t i = 0; i < 2; ++i) {
        const auto truth = arms_[i]->truth().value;
        X_WG[i] = X_WC_ * truth.X_CT * arms_[i]->psm().tool().X_TG;
    }
    const Vector3d t0 = X_WG[0].linear().col(1), t1 = X_WG[1].linear().col(1);
    scenes::Polyline curve =
        sim::hanging_curve({X_WG[0].translation(), t0}, {X_WG[1].translation(), t1}, scene_.thread.length_m);
    curve.points.insert(curve.points.begin(), X_WG[0].translation() - kTail_m * t0);
    curve.points.push_back(X_WG[1].translation() + kTail_m * t1);
    const sim::ThreadOptions options = thread_options(scene_.thread);
    world_->add_thread(curve, options);
    world_->hold(0, kTail_m, Vector3d::UnitY());
    world_->hold(1, options.length_m - kTail_m, Vector3d::UnitY());
    world_->settle();
}

void Testbed::place_instruments() {
    for (int i = 0; i < kArms; ++i) {
        const robot::RobotArm& arm = *arms_[static_cast<size_t>(i)];
        const auto links = arm.true_links_W();
        world_->set_link_poses(i, links.value);
        const robot::ArmState state = arm.truth().value;
        const robot::Tool& tool = arm.psm().tool();
        const Isometry3d X_WT = X_WC_ * state.X_CT;
        if (tool.kind == robot::ToolKind::kGrasper)
            world_->set_jaws(i, X_WT * tool.X_TG, state.jaw_rad);
        else
            world_->set_blades(i, X_WT * *tool.X_TS, state.jaw_rad);
    }
}

void Testbed::tick() {
    const double next_s = time_s() + robot::PsmArm::kPeriod_s;
    const std::array<Isometry3d, 2> X_WG = motion_->X_WG(next_s);
    for (size_t i = 0; i < 2; ++i) {
        robot::RobotArm& holder = *arms_[i];
        holder.controller().servo_cp(X_WB_[i].inverse() * X_WG[i] * holder.psm().tool().X_TG.inverse());
    }
    for (const auto& arm : arms_) arm->step();
    place_instruments();
    world_->step();
}

Isometry3d Testbed::X_WTissue() const {
    Isometry3d X_WM = Isometry3d::Identity();
    X_WM.translation() = Vector3d(0.0, kTissueShift_m, -scene_.tissue.depth_m);
    return X_WM;
}

Vector3d Testbed::measured_grip_C(int arm) const {
    const robot::RobotArm& a = *arms_[static_cast<size_t>(arm)];
    return a.measured().value.X_CT * a.psm().tool().X_TG.translation();
}

Vector3d Testbed::true_grip_C(int arm) const {
    const robot::RobotArm& a = *arms_[static_cast<size_t>(arm)];
    return a.truth().value.X_CT * a.psm().tool().X_TG.translation();
}

}  // namespace atropos::experiments
