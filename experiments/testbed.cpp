#include "experiments/testbed.hpp"

#include <cmath>
#include <stdexcept>

#include "render/calibration_error.hpp"
#include "robot/layout_defaults.hpp"
#include "robot/tool.hpp"
#include "scenes/scene_file.hpp"
#include "sim/knotted_curve.hpp"

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
    options.natural_curvature_per_m = config.natural_curvature_per_m;
    replace(options.material.GJ_N_m2, config.GJ_N_m2);
    replace(options.material.self_friction, config.friction);
    options.diameter_m = config.diameter_m;
    options.length_m = config.length_m + 2.0 * kTail_m;
    options.edges = config.edges;
    return options;
}

robot::Layout scene_layout(const scenes::SceneConfig& scene) {
    robot::Layout layout = scene.arms.layout == "lab_rig"
                               ? robot::lab_rig()
                               : robot::default_layout(working_distance_m(scene.camera));
    for (int i = 0; i < kArms; ++i) {
        const scenes::ArmConfig& keys = arm_config(scene, i);
        const auto index = static_cast<size_t>(i);
        const std::string name = "PSM" + std::to_string(i + 1);
        const bool placed = !keys.base_m.isZero(0.0);
        if (index >= layout.arms.size()) {
            if (!placed)
                throw std::invalid_argument("arms.layout " + scene.arms.layout + " has no " + name +
                                            ", expected arms." + name + ".base_mm");
            layout.arms.push_back({name, Isometry3d::Identity(), {}});
        }
        if (placed)
            layout.arms[index].X_WB = robot::aimed_base(keys.base_m, Vector3d::Zero(), Vector3d::UnitY());
        layout.arms[index].tool = keys.tool;
    }
    return layout;
}

scenes::StereoRig told_rig(const scenes::SceneConfig& scene) {
    const scenes::StereoRig rig = scenes::scene_rig(scene.camera);
    if (!(scene.sensor.calibration_error > 0.0)) return rig;
    return render::told_rig(rig, render::CalibrationError{} * scene.sensor.calibration_error, scene.seed);
}

Testbed::~Testbed() = default;

Testbed::Testbed(const scenes::SceneConfig& scene)
    : scene_(scene), rig_(scenes::scene_rig(scene.camera)), told_rig_(experiments::told_rig(scene)) {
    const robot::Layout layout = scene_layout(scene);
    tree_ = robot::frame_tree(layout, rig_);
    X_WC_ = tree_.pose("W", "C");
    build_arms(layout);
    build_world();
    remember();
}

robot::Joints Testbed::starting_joints(int arm, const Isometry3d& X_WF) const {
    const robot::Psm psm(robot::tool(arm_config(scene_, arm).tool));
    const bool cuts = arm == kScissorsArm && psm.tool().X_TS;
    const robot::IkResult<robot::Joints> ik = robot::joints_for(psm, X_WB_[static_cast<size_t>(arm)], X_WF,
                                                                cuts ? *psm.tool().X_TS : psm.tool().X_TG);
    if (!ik)
        throw std::invalid_argument("PSM" + std::to_string(arm + 1) +
                                    " can't reach its starting pose: " + robot::reason(ik));
    return ik.q;
}

void Testbed::build_arms(const robot::Layout& layout) {
    const robot::LayoutDefaults defaults;
    const robot::Imperfection imperfection = robot::Imperfection::of(scene_.arms.accuracy);
    const scenes::ArmsConfig& keys = scene_.arms;
    if ((keys.psm1.holds != "start" && !is_knotted()) || keys.psm2.holds != "end" ||
        keys.psm3.holds != "nothing")
        throw std::invalid_argument(
            "arms: expected PSM1 to hold the start or nothing, PSM2 the end, PSM3 nothing");
    MotionStart start;
    start.X_WG = defaults.X_WG();
    start.X_WC = X_WC_;
    std::array<std::optional<robot::Replay>, kArms> replays;
    for (int i = 0; i < kArms; ++i) {
        const auto index = static_cast<size_t>(i);
        const robot::ArmPlacement& placement = layout.arm("PSM" + std::to_string(i + 1));
        X_WB_[index] = placement.X_WB;
        const bool holds = i != kScissorsArm;
        robot::Joints q;
        double jaw = holds && !(i == 0 && is_knotted()) ? defaults.holder_jaw_rad : defaults.parked_jaw_rad;
        if (arm_config(scene_, i).motion == "replay") {
            replays[index] = load_replay(scene_, i, tree_);
            q = replays[index]->joints(0.0);
            jaw = replays[index]->jaw_rad(0.0);
            const robot::Psm psm(robot::tool(placement.tool));
            if (holds) start.X_WG[index] = placement.X_WB * psm.forward(q) * psm.tool().X_TG;
        } else {
            const Vector3d p_WB = placement.X_WB.translation(), park = arm_config(scene_, i).park_m;
            q = starting_joints(i, holds              ? start.X_WG[index]
                                   : park.isZero(0.0) ? defaults.X_WS_parked(p_WB)
                                                      : robot::LayoutDefaults::X_WS_parked_at(park, p_WB));
        }
        arms_[index] = std::make_unique<robot::RobotArm>(placement, tree_, q, jaw, imperfection, scene_.seed);
    }
    for (int i = 0; i < kArms; ++i) {
        const auto index = static_cast<size_t>(i);
        start.X_WB = X_WB_[index];
        start.replay = replays[index] ? &*replays[index] : nullptr;
        motions_[index] = make_arm_motion(scene_, i, start);
    }
}

/// Where the thread begins and ends, as the true grips say, not the commanded ones.
std::array<sim::CurveEnd, 2> Testbed::starting_ends_W() const {
    std::array<sim::CurveEnd, 2> ends;
    for (size_t i = 0; i < 2; ++i) {
        const Isometry3d X_WG = X_WC_ * arms_[i]->truth().value.X_CT * arms_[i]->psm().tool().X_TG;
        ends[i] = {X_WG.translation(), X_WG.linear().col(1)};
    }
    return ends;
}

scenes::Polyline Testbed::starting_curve(const std::array<sim::CurveEnd, 2>& ends) const {
    scenes::Polyline curve = scene_.thread.knot == scenes::ThreadKnot::kOverhand
                                 ? sim::knotted_curve(ends[0], ends[1], scene_.thread.length_m)
                                 : sim::hanging_curve(ends[0], ends[1], scene_.thread.length_m);
    curve.points.insert(curve.points.begin(), ends[0].p_W - kTail_m * ends[0].tangent_W);
    curve.points.push_back(ends[1].p_W + kTail_m * ends[1].tangent_W);
    return curve;
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

    const sim::ThreadOptions options = thread_options(scene_.thread);
    const std::array<sim::CurveEnd, 2> ends_W = starting_ends_W();
    world_->add_thread(starting_curve(ends_W), options);
    if (is_knotted())
        world_->anchor(kTail_m, ends_W[0].p_W, ends_W[0].tangent_W);  // like a stitch
    else
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
    for (size_t i = 0; i < kArms; ++i) motions_[i]->step({next_s, *arms_[i], *world_});
    for (const auto& arm : arms_) arm->step();
    place_instruments();
    world_->step();
    remember();
}

Moment Testbed::now() const {
    Moment moment{time_s(), {}, thread()};
    for (size_t i = 0; i < kArms; ++i) moment.X_WL[i] = arms_[i]->true_links_W().value;
    return moment;
}

void Testbed::remember() {
    const double reach_s = scene_.sensor.exposure_time_s + scene_.sensor.right_eye_delay_s;
    if (reach_s <= 0.0) return;
    past_.push_back(now());
    while (past_.front().time_s < time_s() - reach_s - robot::PsmArm::kPeriod_s) past_.pop_front();
}

Moment Testbed::moment(double time_s) const {
    if (past_.empty()) return now();
    const Moment* nearest = &past_.front();
    for (const Moment& m : past_)
        if (std::abs(m.time_s - time_s) < std::abs(nearest->time_s - time_s)) nearest = &m;
    return *nearest;
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
