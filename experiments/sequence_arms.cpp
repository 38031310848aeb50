#include "experiments/sequence_arms.hpp"

#include "experiments/arm_motion.hpp"
#include "experiments/csv_file.hpp"
#include "experiments/endoscope_view.hpp"
#include "robot/tool.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using Eigen::Isometry3d;
using Eigen::Vector3d;
namespace {

constexpr std::string_view kColumns =
    "frame,time_s,arm,frame_id,q1,q2,q3,q4,q5,q6,jaw_rad,x_m,y_m,z_m,qx,qy,qz,qw";
constexpr std::size_t kArmColumn = 2, kFrameIdColumn = 3, kJointColumn = 4, kJawColumn = 10, kPoseColumn = 11;
constexpr double kUnit = 1e-3;  // by which a quaternion's length may be off

robot::ArmState measured(const CsvFile& csv, std::size_t row) {
    const auto number = [&](std::size_t column) { return csv.number(row, column); };
    robot::ArmState state;
    state.time_s = number(1);
    for (int i = 0; i < 6; ++i) state.q[i] = number(kJointColumn + static_cast<std::size_t>(i));
    state.jaw_rad = number(kJawColumn);
    const std::size_t p = kPoseColumn;
    const Eigen::Quaterniond turn(number(p + 6), number(p + 3), number(p + 4), number(p + 5));
    if (std::abs(turn.norm() - 1.0) > kUnit) csv.fail(row, "qx, qy, qz, qw are no unit quaternion");
    state.X_CT = Eigen::Translation3d(number(p), number(p + 1), number(p + 2)) * turn.normalized();
    return state;
}

}  // namespace

SequenceArms::SequenceArms(const scenes::SceneConfig& scene, const scenes::StereoRig& rig, int threads)
    : sights_(make_instrument_sights(scene.arms.accuracy, rig, load_instruments(scene), threads)),
      tips_are_measured_(scene.tracking.tips == scenes::TipSource::kMeasured) {
    for (int arm = 0; arm < kArms; ++arm)
        psms_[static_cast<std::size_t>(arm)] =
            std::make_unique<robot::Psm>(robot::tool(arm_config(scene, arm).tool));
}

std::unique_ptr<SequenceArms> SequenceArms::open(const Sequence& sequence, const scenes::StereoRig& rig,
                                                 int threads) {
    const fs::path file = sequence.folder() / "kinematics.csv", scene = sequence.folder() / "scene.yaml";
    if (!fs::exists(file) || !fs::exists(scene)) return nullptr;
    const CsvFile csv = CsvFile::read(file, kColumns);
    const auto frames = static_cast<std::size_t>(sequence.frames());
    if (csv.rows() != frames * kArms)
        throw scenes::FileError(
            file.string(), std::to_string(csv.rows()) + " rows, expected one for each of " +
                               std::to_string(kArms) + " arms and " + std::to_string(frames) + " frames");
    std::unique_ptr<SequenceArms> arms(new SequenceArms(scenes::load_scene(scene), rig, threads));
    arms->readings_.resize(frames);
    for (std::size_t row = 0; row < csv.rows(); ++row) {
        const std::size_t frame = row / kArms, arm = row % kArms;
        csv.integer(row, 0, static_cast<long>(frame), static_cast<long>(frame));
        if (csv.text(row, kFrameIdColumn) != "C") return nullptr;
        const std::string name = "PSM" + std::to_string(arm + 1);
        if (csv.text(row, kArmColumn) != name)
            csv.fail(row, "arm is '" + csv.text(row, kArmColumn) + "', expected " + name + " here");
        const robot::Psm& psm = *arms->psms_[arm];
        ArmReading& reading = arms->readings_[frame][arm];
        reading.psm = &psm;
        reading.measured = measured(csv, row);
        reading.X_CB = reading.measured.X_CT * psm.forward(reading.measured.q).inverse();
    }
    return arms;
}

void SequenceArms::add_to(tracker::StereoFrame& frame, int index) {
    const ArmReadings& readings = readings_[static_cast<std::size_t>(index)];
    const bool colour = frame.left.channels() == 3;  // instruments are told by their colours
    const std::array<Vector3d, kArms> grips_C =
        add_instruments(colour ? sights_.get() : nullptr, readings, frame);
    for (std::size_t end : {0, 1})
        if (tips_are_measured_ && frame.tips[end] &&
            frame.tips[end]->kind == tracker::MeasuredTip::Kind::kHeld)
            frame.tips[end]->p_C += grips_C[end] - readings[end].grip_C();
}

}  // namespace atropos::experiments
