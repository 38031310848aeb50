#include "experiments/loop_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "experiments/csv_file.hpp"
#include "experiments/picture_file.hpp"
#include "render/calibration_error.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using Eigen::Isometry3d;
namespace {

constexpr const char* kArmsHeader =
    "arm,q1,q2,q3,q4,q5,q6,jaw_rad,r11,r12,r13,x_m,r21,r22,r23,y_m,r31,r32,r33,z_m";
constexpr const char* kFramesHeader = "frame,time_s";
constexpr const char* kReadingsHeader = "time_s,arm,measured_s,q1,q2,q3,q4,q5,q6,jaw_rad";
constexpr const char* kCommandsHeader = "time_s,q1,q2,q3,q4,q5,q6,jaw_rad";

std::string joints_text(const robot::Joints& q, double jaw_rad) {
    return fmt::format("{},{}", fmt::join(q.data(), q.data() + q.size(), ","), jaw_rad);
}

std::string picture_name(long frame) {
    return fmt::format("{:06}.png", frame);
}

robot::Joints joints_of(const CsvFile& csv, size_t row, size_t column) {
    robot::Joints q;
    for (int i = 0; i < q.size(); ++i) q[i] = csv.number(row, column + static_cast<size_t>(i));
    return q;
}

/// The recorded inputs of a run, in the order in which they came.
class InputReader {
  public:
    explicit InputReader(const fs::path& folder)
        : folder_(folder),
          frames_(CsvFile::read(folder / "frames.csv", kFramesHeader)),
          readings_(CsvFile::read(folder / "readings.csv", kReadingsHeader)) {}

    size_t frames() const { return frames_.rows(); }
    double frame_time_s(size_t frame) const { return frames_.number(frame, 1); }
    cv::Mat picture(const char* eye, size_t frame, const scenes::Camera& camera) const {
        return read_picture(folder_ / eye / picture_name(frames_.integer(frame, 0, 0, 100'000'000)),
                            camera.width_px, camera.height_px);
    }

    /// Measurements that had come by `time_s`.
    void advance(double time_s, ArmReadings& arms) {
        for (; row_ < readings_.rows() && readings_.number(row_, 0) <= time_s; ++row_) {
            ArmReading& arm = arms[static_cast<size_t>(readings_.integer(row_, 1, 1, kArms) - 1)];
            robot::ArmState& state = arm.measured;
            state.time_s = readings_.number(row_, 2);
            state.q = joints_of(readings_, row_, 3);
            state.jaw_rad = readings_.number(row_, 9);
            state.X_CT = arm.X_CB * arm.psm->forward(state.q);
        }
    }

  private:
    fs::path folder_;
    CsvFile frames_, readings_;
    size_t row_ = 0;
};

}  // namespace

std::string command_row(double time_s, const robot::PsmArm& scissors) {
    return fmt::format("{},{}\n", time_s, joints_text(scissors.goal(), scissors.jaw_goal_rad()));
}

LoopRecording::LoopRecording(const fs::path& folder, const ClosedLoop& loop) : folder_(folder) {
    fs::create_directories(folder_ / "left");
    fs::create_directories(folder_ / "right");
    AppendFile arms(folder_ / "arms.csv", std::string(kArmsHeader) + "\n");
    for (int i = 0; i < kArms; ++i) {
        const robot::RobotArm& arm = loop.testbed().arm(i);
        const Eigen::Matrix<double, 3, 4, Eigen::RowMajor> X_CB = arm.X_CB().matrix().topRows<3>();
        arms.write(fmt::format("{},{},{}\n", i + 1,
                               joints_text(arm.controller().goal(), arm.controller().jaw_goal_rad()),
                               fmt::join(X_CB.data(), X_CB.data() + X_CB.size(), ",")));
        last_s_[static_cast<size_t>(i)] = -1e9;
    }
    arms.close();
    frames_ = AppendFile(folder_ / "frames.csv", std::string(kFramesHeader) + "\n");
    readings_ = AppendFile(folder_ / "readings.csv", std::string(kReadingsHeader) + "\n");
    commands_ = AppendFile(folder_ / "commands.csv", std::string(kCommandsHeader) + "\n");
}

void LoopRecording::add(const LoopFrame& frame, double time_s) {
    write_png(folder_ / "left" / picture_name(frame.frame), frame.view.left);
    write_png(folder_ / "right" / picture_name(frame.frame), frame.view.right);
    frames_.write(fmt::format("{},{}\n", frame.frame, time_s));
}

void LoopRecording::add(const LoopTick& tick) {
    for (size_t i = 0; i < tick.arms.size(); ++i) {
        const robot::ArmState& state = tick.arms[i].measured;
        if (state.time_s == last_s_[i]) continue;
        last_s_[i] = state.time_s;
        readings_.write(fmt::format("{},{},{},{}\n", tick.time_s, i + 1, state.time_s,
                                    joints_text(state.q, state.jaw_rad)));
    }
    commands_.write(command_row(tick.time_s, tick.scissors));
}

void LoopRecording::close() {
    frames_.close();
    readings_.close();
    commands_.close();
}

std::string replay_inputs(const fs::path& run_folder) {
    const scenes::SceneConfig scene = scenes::load_scene(run_folder / "scene.yaml");
    const fs::path folder = run_folder / "inputs";
    if (scene.tracking.tips == scenes::TipSource::kExact ||
        scene.cut.controller != scenes::CutController::kTracker)
        throw scenes::FileError((run_folder / "scene.yaml").string(),
                                "the run was told the truth, expected tracker.tips and cut.controller that "
                                "are not");
    const CsvFile start = CsvFile::read(folder / "arms.csv", kArmsHeader);
    if (start.rows() != kArms) throw scenes::FileError((folder / "arms.csv").string(), "expected three arms");
    std::vector<robot::Psm> psms;
    for (int i = 0; i < kArms; ++i) psms.emplace_back(robot::tool(arm_config(scene, i).tool));
    ArmReadings arms;
    for (size_t i = 0; i < arms.size(); ++i) {
        Eigen::Matrix<double, 3, 4> X_CB;
        for (int k = 0; k < 12; ++k) X_CB(k / 4, k % 4) = start.number(i, 8 + static_cast<size_t>(k));
        arms[i].psm = &psms[i];
        arms[i].X_CB = Isometry3d::Identity();
        arms[i].X_CB.affine() = X_CB;
    }
    robot::PsmArm scissors(psms[kScissorsArm], joints_of(start, kScissorsArm, 1),
                           start.number(kScissorsArm, 7));
    const scenes::StereoRig rig = told_rig(scene);
    ScissorsPilot pilot(scene, rig, arms, load_instruments(scene), scissors);

    InputReader inputs(folder);
    const CsvFile times = CsvFile::read(folder / "commands.csv", kCommandsHeader);
    std::string commands = std::string(kCommandsHeader) + "\n";
    size_t frame = 0;
    for (size_t tick = 0; tick < times.rows(); ++tick) {
        const double now = times.number(tick, 0);
        inputs.advance(now, arms);
        if (frame < inputs.frames() && inputs.frame_time_s(frame) <= now) {
            pilot.see(static_cast<int>(frame), inputs.frame_time_s(frame),
                      inputs.picture("left", frame, rig.left), inputs.picture("right", frame, rig.right),
                      arms);
            ++frame;
        }
        pilot.step(now, arms);
        commands += command_row(now, scissors);
        scissors.step();
    }
    return commands;
}

}  // namespace atropos::experiments
