#include "experiments/track_reader.hpp"

#include <map>

#include "experiments/csv_file.hpp"
#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::ThreadEstimate;
using scenes::TrackStatus;
namespace {

constexpr long kMaxFrame = 10'000'000;
constexpr std::string_view kWithSigmas = "frame,i,s_mm,x_mm,y_mm,z_mm,sigma_lateral_mm,sigma_depth_mm";
constexpr std::string_view kWithoutSigmas = "frame,i,s_mm,x_mm,y_mm,z_mm";

bool first_line_is(const fs::path& file, std::string_view header) {
    const std::string text = scenes::read_text_file(file, std::size_t{4} << 30);
    return text.starts_with(header) &&
           (text.size() == header.size() || text[header.size()] == '\n' || text[header.size()] == '\r');
}

std::map<int, ThreadEstimate> read_curves(const fs::path& file) {
    const bool bare = first_line_is(file, kWithoutSigmas);
    const CsvFile csv = CsvFile::read(file, bare ? kWithoutSigmas : kWithSigmas);
    std::map<int, ThreadEstimate> curves;
    for (size_t row = 0; row < csv.rows(); ++row) {
        ThreadEstimate& estimate = curves[static_cast<int>(csv.integer(row, 0, 0, kMaxFrame))];
        estimate.status = TrackStatus::kTracking;
        scenes::ThreadSample sample;
        sample.s_m = 1e-3 * csv.number(row, 2);
        sample.p_C = 1e-3 * Eigen::Vector3d(csv.number(row, 3), csv.number(row, 4), csv.number(row, 5));
        if (!(sample.p_C.z() > 0.0)) csv.fail(row, "the point lies behind the camera, expected z_mm above 0");
        if (!estimate.samples.empty() && sample.s_m <= estimate.samples.back().s_m)
            csv.fail(row, "s_mm does not rise");
        if (!bare) {
            sample.sigma_lateral_m = 1e-3 * csv.number(row, 6);
            sample.sigma_depth_m = 1e-3 * csv.number(row, 7);
        }
        estimate.samples.push_back(sample);
    }
    return curves;
}

TrackStatus status_of(const CsvFile& csv, size_t row) {
    for (const TrackStatus status : {TrackStatus::kTracking, TrackStatus::kCoasting, TrackStatus::kLost})
        if (csv.text(row, 2) == scenes::to_string(status)) return status;
    csv.fail(row, "status is '" + csv.text(row, 2) + "', expected tracking, coasting or lost");
}

}  // namespace

std::vector<TrackedFrame> read_track(const fs::path& track) {
    if (!fs::exists(track)) throw scenes::FileError(track.string(), "no such track");
    std::vector<TrackedFrame> frames;
    if (!fs::is_directory(track)) {
        const std::map<int, ThreadEstimate> curves = read_curves(track);
        if (curves.empty())
            throw scenes::FileError(track.string(), "no rows, expected a curve in at least one frame");
        for (int i = curves.begin()->first; i <= curves.rbegin()->first; ++i)
            frames.push_back({i, curves.contains(i) ? curves.at(i) : ThreadEstimate{}});
        return frames;
    }
    std::map<int, ThreadEstimate> curves = read_curves(track / "track.csv");
    const CsvFile csv =
        CsvFile::read(track / "frames.csv", "frame,time_s,status,length_mm,energy,confidence");
    for (size_t row = 0; row < csv.rows(); ++row) {
        TrackedFrame f{static_cast<int>(csv.integer(row, 0, 0, kMaxFrame)), {}};
        f.estimate = curves[f.frame];
        f.estimate.status = status_of(csv, row);
        f.estimate.capture_time_s = csv.number(row, 1);
        f.estimate.confidence = csv.number(row, 5);
        if (f.estimate.status == TrackStatus::kLost) f.estimate.samples.clear();
        frames.push_back(f);
    }
    return frames;
}

}  // namespace atropos::experiments
