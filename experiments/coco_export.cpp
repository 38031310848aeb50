#include "experiments/coco_export.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>

#include "experiments/csv_file.hpp"
#include "experiments/picture_file.hpp"
#include "experiments/sequence_writer.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using nlohmann::ordered_json;
namespace {

constexpr int kThreadLabel = 1;
constexpr std::array<const char*, 5> kKeyPoints = {"end_0", "quarter", "middle", "three_quarters", "end_1"};

struct SpanPoint {
    double s_mm, u_px, v_px;
    bool visible;
};

/// The judged span of each frame in the left picture.
std::map<long, std::vector<SpanPoint>> read_span(const fs::path& sequence) {
    const CsvFile csv = CsvFile::read(sequence / "truth" / "thread.csv", kTruthThreadColumns);
    std::map<long, std::vector<SpanPoint>> frames;
    for (std::size_t row = 0; row < csv.rows(); ++row)
        if (csv.integer(row, 4, 0, 1) == 1)
            frames[csv.integer(row, 0, 0, 100'000'000)].push_back({csv.number(row, 3), csv.number(row, 8),
                                                                   csv.number(row, 9),
                                                                   csv.integer(row, 12, 0, 1) == 1});
    return frames;
}

double hundredths(double value) {
    return std::round(100.0 * value) / 100.0;
}

/// [x, y, v] of each key point; x, y, v are 0 outside the picture.
ordered_json key_points(const std::vector<SpanPoint>& span, const cv::Mat& mask, int& labelled) {
    ordered_json points = ordered_json::array();
    labelled = 0;
    for (std::size_t k = 0; k < kKeyPoints.size(); ++k) {
        const SpanPoint* best = nullptr;
        if (!span.empty()) {
            const double s = span.front().s_mm + (span.back().s_mm - span.front().s_mm) *
                                                     static_cast<double>(k) / (kKeyPoints.size() - 1.0);
            best = &*std::min_element(span.begin(), span.end(), [s](const SpanPoint& a, const SpanPoint& b) {
                return std::abs(a.s_mm - s) < std::abs(b.s_mm - s);
            });
        }
        const bool inside = best && best->u_px >= 0.0 && best->v_px >= 0.0 && best->u_px <= mask.cols - 1 &&
                            best->v_px <= mask.rows - 1;
        if (inside) ++labelled;
        points.push_back(inside ? hundredths(best->u_px) : 0.0);
        points.push_back(inside ? hundredths(best->v_px) : 0.0);
        points.push_back(!inside ? 0 : best->visible ? 2 : 1);
    }
    return points;
}

}  // namespace

std::vector<int> coco_run_lengths(const cv::Mat1b& mask) {
    std::vector<int> runs;
    bool inside = false;
    int length = 0;
    for (int u = 0; u < mask.cols; ++u)
        for (int v = 0; v < mask.rows; ++v) {
            if ((mask(v, u) != 0) != inside) {
                runs.push_back(length);
                length = 0;
                inside = !inside;
            }
            ++length;
        }
    runs.push_back(length);
    return runs;
}

ordered_json coco_annotations(const fs::path& dataset, const std::vector<std::string>& sequences) {
    ordered_json coco;
    coco["info"] = {{"description", "Atropos: simulated suture thread, left pictures"}, {"version", "1.0"}};
    coco["categories"] = {{{"id", 1},
                           {"name", "thread"},
                           {"supercategory", "suture"},
                           {"keypoints", kKeyPoints},
                           {"skeleton", {{1, 2}, {2, 3}, {3, 4}, {4, 5}}}}};
    coco["images"] = ordered_json::array();
    coco["annotations"] = ordered_json::array();
    for (const std::string& sequence : sequences) {
        const fs::path masks = dataset / sequence / "truth" / "mask_left";
        if (!fs::is_directory(masks))
            throw scenes::FileError(masks.string(), "no such folder, --coco needs the layer mask");
        const auto spans = read_span(dataset / sequence);
        for (long frame = 0; fs::exists(masks / fmt::format("{:06d}.png", frame)); ++frame) {
            const std::string name = fmt::format("{:06d}.png", frame);
            const cv::Size size = picture_size(masks / name);
            const cv::Mat labels = read_picture(masks / name, size.width, size.height);
            cv::Mat1b mask;
            cv::compare(labels, kThreadLabel, mask, cv::CMP_EQ);
            const int id = static_cast<int>(coco["images"].size()) + 1;
            coco["images"].push_back({{"id", id},
                                      {"file_name", sequence + "/left/" + name},
                                      {"width", size.width},
                                      {"height", size.height}});
            const cv::Rect box = cv::boundingRect(mask);
            if (box.area() == 0) continue;
            int labelled = 0;
            const auto span = spans.find(frame);
            const ordered_json points =
                key_points(span == spans.end() ? std::vector<SpanPoint>{} : span->second, mask, labelled);
            coco["annotations"].push_back(
                {{"id", static_cast<int>(coco["annotations"].size()) + 1},
                 {"image_id", id},
                 {"category_id", 1},
                 {"iscrowd", 0},
                 {"segmentation", {{"size", {size.height, size.width}}, {"counts", coco_run_lengths(mask)}}},
                 {"area", cv::countNonZero(mask)},
                 {"bbox", {box.x, box.y, box.width, box.height}},
                 {"num_keypoints", labelled},
                 {"keypoints", points}});
        }
    }
    return coco;
}

}  // namespace atropos::experiments
