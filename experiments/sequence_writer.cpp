#include "experiments/sequence_writer.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "experiments/output_folder.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/sha256.hpp"
#include "experiments/version.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/scene_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using Eigen::Vector3d;
using nlohmann::ordered_json;
namespace {

constexpr double kDepthScale = 64.0;      ///< steps of a mm
constexpr double kDisparityScale = 64.0;  ///< steps of a px

cv::Mat depth_picture(const cv::Mat& depth_m) {
    cv::Mat picture;
    depth_m.convertTo(picture, CV_16U, 1e3 * kDepthScale);
    return picture;
}

cv::Mat coverage_picture(const cv::Mat& coverage) {
    cv::Mat picture;
    coverage.convertTo(picture, CV_8U, 255.0);
    return picture;
}

std::string kinematics_row(int frame, const robot::RobotArm& arm, const robot::ArmState& state) {
    const Eigen::Quaterniond q(state.X_CT.linear());
    const Vector3d p = state.X_CT.translation();
    std::string row = fmt::format("{},{:.6f},{},C", frame, state.time_s, arm.name());
    for (int i = 0; i < 6; ++i) row += fmt::format(",{:.8f}", state.q[i]);
    return row + fmt::format(",{:.8f},{:.8f},{:.8f},{:.8f},{:.9f},{:.9f},{:.9f},{:.9f}\n", state.jaw_rad,
                             p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

constexpr std::string_view kKinematicsColumns =
    "frame,time_s,arm,frame_id,q1,q2,q3,q4,q5,q6,jaw_rad,x_m,y_m,z_m,qx,qy,qz,qw\n";

}  // namespace

std::string truth_rows(int frame, const std::vector<TruthSample>& samples) {
    std::string rows;
    for (const TruthSample& s : samples) {
        const Vector3d p = 1e3 * s.p_C;
        rows += fmt::format("{},{},{},{:.5f},{},{:.5f},{:.5f},{:.5f},{:.4f},{:.4f},{:.4f},{:.4f},{},{}\n",
                            frame, s.strand, s.i, 1e3 * s.s_m, s.in_span ? 1 : 0, p.x(), p.y(), p.z(),
                            s.pixel[0].x(), s.pixel[0].y(), s.pixel[1].x(), s.pixel[1].y(),
                            s.visible[0] ? 1 : 0, s.visible[1] ? 1 : 0);
    }
    return rows;
}

SequenceWriter::SequenceWriter(fs::path folder, const Testbed& testbed, const SequenceLayers& layers)
    : folder_(std::move(folder)), layers_(layers) {
    for (const char* name : {"calib", "left", "right", "truth"}) fs::create_directories(folder_ / name);
    for (const std::string eye : {"left", "right"}) {
        if (layers_.depth) fs::create_directories(folder_ / "truth" / ("depth_" + eye));
        if (layers_.mask) fs::create_directories(folder_ / "truth" / ("mask_" + eye));
        if (layers_.coverage) fs::create_directories(folder_ / "truth" / ("coverage_" + eye));
    }
    if (layers_.rectified) {
        for (const char* name : {"rectified/left", "rectified/right", "truth/disparity_left",
                                 "truth/disparity_right", "truth/occlusion_left", "truth/occlusion_right"})
            fs::create_directories(folder_ / name);
        rectifier_ = std::make_unique<Rectifier>(testbed.rig());
    }
    write_file(folder_ / "scene.yaml", scenes::to_yaml(testbed.scene()));
    write_file(folder_ / "calib" / "stereo.yaml", scenes::to_opencv_yaml(testbed.told_rig()));
    write_file(folder_ / "calib" / "left.yaml", scenes::to_ros_yaml(testbed.told_rig(), false));
    write_file(folder_ / "calib" / "right.yaml", scenes::to_ros_yaml(testbed.told_rig(), true));
    if (testbed.scene().sensor.calibration_error > 0.0)
        write_file(folder_ / "truth" / "stereo.yaml", scenes::to_opencv_yaml(testbed.rig()));
    frames_ = AppendFile(folder_ / "frames.csv", "frame,time_s\n");
    tips_ = AppendFile(folder_ / "tips.csv", "frame,end,kind,x_mm,y_mm,z_mm\n");
    kinematics_ = AppendFile(folder_ / "kinematics.csv", kKinematicsColumns);
    true_kinematics_ = AppendFile(folder_ / "truth" / "kinematics.csv", kKinematicsColumns);
    thread_ = AppendFile(folder_ / "truth" / "thread.csv", std::string(kTruthThreadColumns) + "\n");
}

void SequenceWriter::add(const Testbed& testbed, const View& view) {
    frame_times_s_.push_back(testbed.time_s());
    frames_.write(fmt::format("{},{:.6f}\n", frame_, testbed.time_s()));
    write_pictures(view);
    thread_.write(truth_rows(frame_, view.samples));
    write_tips(testbed);
    write_kinematics(testbed);
    ++frame_;
}

void SequenceWriter::write_pictures(const View& view) {
    const std::string name = fmt::format("{:06d}.png", frame_);
    write_png(folder_ / "left" / name, view.left);
    write_png(folder_ / "right" / name, view.right);
    for (const auto& [eye, frame] :
         {std::pair<std::string, const render::EyeFrame*>{"left", &view.truth.left},
          {"right", &view.truth.right}}) {
        const fs::path truth = folder_ / "truth";
        if (layers_.depth) write_png(truth / ("depth_" + eye) / name, depth_picture(frame->depth_m));
        if (layers_.mask) write_png(truth / ("mask_" + eye) / name, frame->labels);
        if (layers_.coverage)
            write_png(truth / ("coverage_" + eye) / name, coverage_picture(frame->coverage));
    }
    if (rectifier_) write_rectified(view);
}

void SequenceWriter::write_rectified(const View& view) {
    const std::string name = fmt::format("{:06d}.png", frame_);
    const RectifiedPair pair =
        rectifier_->rectify(view.left, view.right, view.truth.left.depth_m, view.truth.right.depth_m);
    const auto disparity_picture = [](const cv::Mat1f& disparity_px) {
        cv::Mat picture;
        disparity_px.convertTo(picture, CV_16U, kDisparityScale);
        return picture;
    };
    write_png(folder_ / "rectified" / "left" / name, pair.left);
    write_png(folder_ / "rectified" / "right" / name, pair.right);
    write_png(folder_ / "truth" / "disparity_left" / name, disparity_picture(pair.disparity_left));
    write_png(folder_ / "truth" / "disparity_right" / name, disparity_picture(pair.disparity_right));
    write_png(folder_ / "truth" / "occlusion_left" / name, pair.occlusion_left);
    write_png(folder_ / "truth" / "occlusion_right" / name, pair.occlusion_right);
}

void SequenceWriter::write_tips(const Testbed& testbed) {
    if (testbed.scene().tracking.tips == scenes::TipSource::kNone) return;
    const bool exact = testbed.scene().tracking.tips == scenes::TipSource::kExact;
    for (const int end : {0, 1}) {
        const bool knot = end == 0 && testbed.is_knotted();
        if (!knot && !testbed.world().holds(end)) continue;
        const bool fixed = knot && knot_C_;  // measured where PSM1 lets go of it, and by nobody later
        const Vector3d p_C = fixed   ? *knot_C_
                             : exact ? testbed.true_grip_C(end)
                                     : testbed.measured_grip_C(end);
        if (knot) knot_C_ = p_C;
        const Vector3d p = 1e3 * p_C;
        tips_.write(fmt::format("{},{},{},{:.5f},{:.5f},{:.5f}\n", frame_, end, fixed ? "fixed" : "held",
                                p.x(), p.y(), p.z()));
    }
}

void SequenceWriter::write_kinematics(const Testbed& testbed) {
    for (int i = 0; i < kArms; ++i) {
        kinematics_.write(kinematics_row(frame_, testbed.arm(i), testbed.arm(i).measured().value));
        true_kinematics_.write(kinematics_row(frame_, testbed.arm(i), testbed.arm(i).truth().value));
    }
}

std::string events_csv(const std::vector<sim::Event>& events, const std::vector<double>& frame_times_s,
                       const Eigen::Isometry3d& X_CW) {
    std::string text = "time_s,frame,event,arm,s_mm,x_mm,y_mm,z_mm\n";
    for (const sim::Event& event : events) {
        if (event.kind == sim::EventKind::kContactForce) continue;
        const auto next = std::upper_bound(frame_times_s.begin(), frame_times_s.end(), event.time_s);
        const auto frame = std::max<std::ptrdiff_t>(0, next - frame_times_s.begin() - 1);
        const Vector3d p = 1e3 * (X_CW * event.p_W);
        text += fmt::format(
            "{:.6f},{},{},{},{},{:.5f},{:.5f},{:.5f}\n", event.time_s, frame, sim::to_string(event.kind),
            event.name, event.s_m < 0.0 ? "" : fmt::format("{:.5f}", 1e3 * event.s_m), p.x(), p.y(), p.z());
    }
    return text;
}

namespace {

/// Every file below the folder by its relative name, in order.
ordered_json checksums(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) names.push_back(fs::relative(entry.path(), folder).generic_string());
    std::sort(names.begin(), names.end());
    ordered_json sums;
    for (const std::string& name : names)
        if (name != "meta.json") sums[name] = sha256_of_file(folder / name);
    return sums;
}

}  // namespace

void SequenceWriter::finish(const Testbed& testbed, const ordered_json& extra) {
    for (AppendFile* file : {&frames_, &tips_, &kinematics_, &thread_, &true_kinematics_}) file->close();
    write_file(folder_ / "truth" / "events.csv",
               events_csv(testbed.world().events(), frame_times_s_, testbed.X_WC().inverse()));
    const scenes::SceneConfig& scene = testbed.scene();
    ordered_json meta;
    meta["name"] = scene.name;
    meta["frames"] = frame_;
    meta["fps_hz"] = scene.camera.fps_hz;
    meta["accel"] = 1;
    meta["seed"] = scene.seed;
    meta["versions"] = {{"atropos", version_number()}};
    for (int i = 0; i < kArms; ++i) meta["tools"][testbed.arm(i).name()] = testbed.arm(i).psm().tool().name;
    meta["depth_scale"] = kDepthScale;
    if (rectifier_) meta["disparity_scale"] = kDisparityScale;
    meta["labels"] = {{"background", 0}, {"thread", 1}, {"tissue", 2}, {"PSM1", 3},
                      {"PSM2", 4},       {"PSM3", 5},   {"needle", 6}, {"other", 7}};
    meta.update(extra);
    meta["sha256"] = checksums(folder_);
    meta["complete"] = true;
    write_file(folder_ / "meta.json", meta.dump(2) + "\n");
}

}  // namespace atropos::experiments
