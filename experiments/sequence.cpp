#include "experiments/sequence.hpp"

#include <algorithm>

#include "experiments/csv_file.hpp"
#include "experiments/picture_file.hpp"
#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

constexpr double kDefaultFps = 30.0;
constexpr int kSmallest_px = 16;  // less shows no thread
constexpr long kMaxFrames = 10'000'000;

/// Pictures of one eye, numbered 000000 onwards without a gap.
std::vector<fs::path> pictures(const fs::path& folder) {
    if (!fs::is_directory(folder))
        throw FileError(folder.string(), "no such folder, expected the pictures of one eye");
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        const std::string extension = entry.path().extension().string();
        if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    if (files.empty()) throw FileError(folder.string(), "no pictures, expected 000000.png onwards");
    for (size_t i = 0; i < files.size(); ++i) {
        std::string number = std::to_string(i);
        number.insert(0, number.size() < 6 ? 6 - number.size() : 0, '0');
        if (files[i].stem() != number)
            throw FileError(files[i].string(), "expected picture number " + number + " here");
    }
    return files;
}

}  // namespace

Sequence Sequence::open(const fs::path& folder) {
    if (!fs::is_directory(folder)) throw FileError(folder.string(), "no such folder, expected a sequence");
    Sequence sequence;
    sequence.folder_ = folder;
    sequence.rig_ = scenes::load_calibration(folder / "calib" / "stereo.yaml");
    for (const scenes::Camera& camera : {sequence.rig_.left, sequence.rig_.right})
        if (std::min(camera.width_px, camera.height_px) < kSmallest_px)
            throw FileError((folder / "calib" / "stereo.yaml").string(),
                            "images of " + std::to_string(camera.width_px) + "x" +
                                std::to_string(camera.height_px) + " pixels, expected " +
                                std::to_string(kSmallest_px) + " or more each way");
    sequence.left_ = pictures(folder / "left");
    sequence.right_ = pictures(folder / "right");
    if (sequence.left_.size() != sequence.right_.size())
        throw FileError(folder.string(), std::to_string(sequence.left_.size()) + " left and " +
                                             std::to_string(sequence.right_.size()) +
                                             " right pictures, expected as many");
    sequence.read_times();
    sequence.read_tips();
    return sequence;
}

void Sequence::read_times() {
    time_s_.resize(left_.size());
    for (size_t i = 0; i < time_s_.size(); ++i) time_s_[i] = static_cast<double>(i) / kDefaultFps;
    const fs::path file = folder_ / "frames.csv";
    if (!fs::exists(file)) return;
    const CsvFile csv = CsvFile::read(file, "frame,time_s");
    if (csv.rows() != left_.size())
        throw FileError(file.string(), std::to_string(csv.rows()) + " rows, expected one for each of " +
                                           std::to_string(left_.size()) + " frames");
    for (size_t row = 0; row < csv.rows(); ++row) {
        const auto expected = static_cast<long>(row);
        csv.integer(row, 0, expected, expected);
        time_s_[row] = csv.number(row, 1);
        if (row > 0 && time_s_[row] <= time_s_[row - 1]) csv.fail(row, "time does not rise");
    }
}

void Sequence::read_tips() {
    tips_.resize(left_.size());
    const fs::path file = folder_ / "tips.csv";
    if (!fs::exists(file)) return;
    const CsvFile csv = CsvFile::read(file, "frame,end,kind,x_mm,y_mm,z_mm");
    for (size_t row = 0; row < csv.rows(); ++row) {
        const long frame = csv.integer(row, 0, 0, static_cast<long>(left_.size()) - 1);
        const long end = csv.integer(row, 1, 0, 1);
        const std::string& kind = csv.text(row, 2);
        if (kind != "held" && kind != "fixed")
            csv.fail(row, "kind is '" + kind + "', expected held or fixed");
        tracker::MeasuredTip tip;
        tip.p_C = 1e-3 * Eigen::Vector3d(csv.number(row, 3), csv.number(row, 4), csv.number(row, 5));
        tip.kind = kind == "fixed" ? tracker::MeasuredTip::Kind::kFixed : tracker::MeasuredTip::Kind::kHeld;
        if (!(tip.p_C.z() > 1e-3)) csv.fail(row, "the end lies behind the camera, expected z_mm above 1");
        tips_[static_cast<size_t>(frame)][static_cast<size_t>(end)] = tip;
    }
}

tracker::StereoFrame Sequence::frame(int index) const {
    const auto i = static_cast<size_t>(index);
    tracker::StereoFrame frame;
    frame.index = index;
    frame.capture_time_s = time_s_[i];
    frame.left = read_picture(left_[i], rig_.left.width_px, rig_.left.height_px);
    frame.right = read_picture(right_[i], rig_.right.width_px, rig_.right.height_px);
    if (frame.left.type() != frame.right.type())
        throw FileError(right_[i].string(), "gray and colour differ between the eyes");
    frame.tips = tips_[i];
    return frame;
}

std::vector<TruthFrame> read_truth(const fs::path& sequence, int frames) {
    const fs::path file = sequence / "truth" / "thread.csv";
    const CsvFile csv =
        CsvFile::read(file,
                      "frame,strand,i,s_mm,in_span,x_mm,y_mm,z_mm,u_left_px,v_left_px,u_right_px,"
                      "v_right_px,visible_left,visible_right");
    std::vector<TruthFrame> truth(static_cast<size_t>(frames));
    for (size_t row = 0; row < csv.rows(); ++row) {
        const long frame = csv.integer(row, 0, 0, kMaxFrames);
        if (frame >= frames) continue;
        if (csv.integer(row, 4, 0, 1) == 0) continue;
        TruthFrame& t = truth[static_cast<size_t>(frame)];
        t.span_C.points.push_back(
            1e-3 * Eigen::Vector3d(csv.number(row, 5), csv.number(row, 6), csv.number(row, 7)));
        t.visible.push_back({csv.integer(row, 12, 0, 1) == 1, csv.integer(row, 13, 0, 1) == 1});
    }
    return truth;
}

}  // namespace atropos::experiments
