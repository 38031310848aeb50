#include "tests/bench/trial_store.hpp"

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <stdexcept>

namespace atropos::bench {
namespace {

constexpr int kDigits = 17;       // a double survives
constexpr int kOffsetDigits = 4;  // enough for a quantile

void read(std::istream& in, std::vector<double>& values) {
    std::size_t count = 0;
    in >> count;
    values.resize(in ? count : 0);
    for (double& value : values) in >> value;
}

void write(std::ostream& out, const std::vector<double>& values) {
    out << ' ' << values.size();
    for (const double value : values) out << ' ' << value;
}

bool read(const std::filesystem::path& path, Trial& trial) {
    std::ifstream in(path);
    if (!in) return false;
    in >> trial.motion.mean_3d_m >> trial.motion.max_3d_m >> trial.motion.mean_2d_px >>
        trial.motion.max_2d_px;
    std::size_t method = 0;
    int lost = 0;
    support::FrameScore s{};
    while (in >> method >> lost >> s.accuracy_3d_m >> s.accuracy_2d_px >> s.symmetric_2d_px) {
        read(in, s.lateral_px);
        read(in, s.disparity_px);
        s.status = lost ? scenes::TrackStatus::kLost : scenes::TrackStatus::kTracking;
        trial.scores.at(method).push_back(s);
    }
    return true;
}

void write(const std::filesystem::path& path, const Trial& trial) {
    const std::filesystem::path beside = path.string() + ".part";
    std::ofstream out(beside);
    out.precision(kDigits);
    out << trial.motion.mean_3d_m << ' ' << trial.motion.max_3d_m << ' ' << trial.motion.mean_2d_px << ' '
        << trial.motion.max_2d_px << '\n';
    for (std::size_t method = 0; method < 2; ++method)
        for (const support::FrameScore& s : trial.scores[method]) {
            out << std::setprecision(kDigits) << method << ' ' << (s.status == scenes::TrackStatus::kLost)
                << ' ' << s.accuracy_3d_m << ' ' << s.accuracy_2d_px << ' ' << s.symmetric_2d_px
                << std::setprecision(kOffsetDigits);
            write(out, s.lateral_px);
            write(out, s.disparity_px);
            out << '\n';
        }
    out.close();
    if (!out) throw std::runtime_error(beside.string() + ": cannot be written");
    std::filesystem::rename(beside, path);
}

}  // namespace

Trial stored_trial(const std::string& folder, const std::string& camera, int acceleration, int seed,
                   int frames) {
    std::filesystem::create_directories(folder);
    const std::filesystem::path path = std::filesystem::path(folder) /
                                       (camera + "-accel" + std::to_string(acceleration) + "-seed" +
                                        std::to_string(seed) + "-frames" + std::to_string(frames) + ".trial");
    Trial trial;
    if (read(path, trial)) return trial;
    support::TableCase c = support::table_case(camera);
    c.options.acceleration = acceleration;
    c.options.seed = static_cast<std::uint64_t>(seed);
    const auto scores = support::run_trials({c.e1, c.e2}, c.options, frames);
    trial = {{scores[0], scores[1]}, support::knot_motion(c.options, frames)};
    write(path, trial);
    return trial;
}

}  // namespace atropos::bench
