#include "experiments/recorded_curves.hpp"

#include <algorithm>
#include <map>

#include "experiments/csv_file.hpp"
#include "scenes/file_error.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
namespace {

constexpr long kMaxFrame = 10'000'000;
constexpr long kMostControlPoints = 64;
constexpr const char* kControlPoints = "control_points.csv";

}  // namespace

std::vector<fs::path> track_folders(const fs::path& folder) {
    std::error_code error;
    if (!fs::is_directory(folder, error))
        throw scenes::FileError(folder.string(), "no such folder of tracks");
    std::vector<fs::path> found;
    if (fs::exists(folder / kControlPoints)) found.push_back(folder);
    for (fs::recursive_directory_iterator i(folder, fs::directory_options::skip_permission_denied, error),
         end;
         !error && i != end; i.increment(error))
        if (i->is_directory(error) && fs::exists(i->path() / kControlPoints)) found.push_back(i->path());
    if (found.empty())
        throw scenes::FileError(folder.string(), std::string("no track in it, expected folders with ") +
                                                     kControlPoints +
                                                     " as `atropos track` and `atropos run` write them");
    std::sort(found.begin(), found.end());
    return found;
}

std::vector<RecordedCurve> read_recorded_curves(const fs::path& track) {
    const CsvFile frames =
        CsvFile::read(track / "frames.csv", "frame,time_s,status,length_mm,energy,confidence");
    std::map<long, double> seen_at_s;
    for (std::size_t row = 0; row < frames.rows(); ++row)
        if (frames.text(row, 2) == "tracking")
            seen_at_s[frames.integer(row, 0, 0, kMaxFrame)] = frames.number(row, 1);
    const CsvFile points = CsvFile::read(track / kControlPoints, "frame,k,x_mm,y_mm,z_mm");
    std::vector<RecordedCurve> curves;
    long K = 0;
    for (std::size_t row = 0; row < points.rows();) {
        const long frame = points.integer(row, 0, 0, kMaxFrame);
        std::vector<Eigen::Vector3d> Q;
        const std::size_t first = row;
        for (; row < points.rows() && points.integer(row, 0, 0, kMaxFrame) == frame; ++row) {
            if (points.integer(row, 1, 0, kMostControlPoints - 1) != static_cast<long>(Q.size()))
                points.fail(row, "k is '" + points.text(row, 1) + "', expected " + std::to_string(Q.size()));
            Q.emplace_back(
                1e-3 * Eigen::Vector3d(points.number(row, 2), points.number(row, 3), points.number(row, 4)));
        }
        const long count = static_cast<long>(Q.size());
        if (K == 0) K = count;
        if (count != K || count < 4)
            points.fail(first, std::to_string(count) + " control points in frame " + std::to_string(frame) +
                                   ", expected " + std::to_string(std::max(K, 4L)));
        if (!curves.empty() && frame <= curves.back().frame) points.fail(first, "frame does not rise");
        if (const auto at = seen_at_s.find(frame); at != seen_at_s.end())
            curves.push_back(
                {static_cast<int>(frame), at->second, Eigen::Matrix3Xd::Map(Q[0].data(), 3, count)});
    }
    return curves;
}

}  // namespace atropos::experiments
