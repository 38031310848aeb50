#include "experiments/prior_file.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
using nlohmann::ordered_json;
using scenes::FileError;
namespace {

constexpr const char* kFormat = "atropos deformation prior";
constexpr int kVersion = 1;
constexpr std::size_t kMaxBytes = std::size_t{4} << 20;

/// One object of the file; what is wrong with it is said with its place.
class Section {
  public:
    Section(const std::string& file, const ordered_json& json, std::string place)
        : file_(file), json_(json), place_(std::move(place)) {
        if (!json.is_object()) throw FileError(file_, place_ + "no JSON object, expected one of learn-prior");
    }

    [[noreturn]] void wrong(const std::string& key, const std::string& expected) const {
        throw FileError(file_, place_ + key + (json_.contains(key) ? " is something else" : " is missing") +
                                   ", expected " + expected);
    }

    const ordered_json& array(const std::string& key, std::size_t least, std::size_t most) const {
        const auto found = json_.find(key);
        if (found == json_.end() || !found->is_array() || found->size() < least || found->size() > most)
            wrong(key,
                  "an array of " + (least == most ? std::to_string(least)
                                                  : std::to_string(least) + " to " + std::to_string(most)));
        return *found;
    }

    double number(const std::string& key) const {
        const auto found = json_.find(key);
        if (found == json_.end() || !found->is_number() || !std::isfinite(found->get<double>()))
            wrong(key, "a number");
        return found->get<double>();
    }

    int integer(const std::string& key, int low, int high) const {
        const auto found = json_.find(key);
        const bool whole = found != json_.end() && found->is_number_integer();
        const double value = whole ? found->get<double>() : NAN;
        if (!(value >= low && value <= high))
            wrong(key, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
        return static_cast<int>(value);
    }

  private:
    const std::string& file_;
    const ordered_json& json_;
    std::string place_;
};

Eigen::VectorXd displacement(const Section& mode, int K) {
    Eigen::VectorXd column(3 * K);
    const auto count = static_cast<std::size_t>(K);
    const ordered_json& points = mode.array("displacement", count, count);
    for (int k = 0; k < K; ++k) {
        const ordered_json& p = points[static_cast<std::size_t>(k)];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (!p.is_array() || p.size() != 3 || !p[axis].is_number())
                mode.wrong("displacement",
                           "three numbers for each of " + std::to_string(K) + " control points");
            column[3 * k + static_cast<int>(axis)] = p[axis].get<double>();
        }
    }
    return column;
}

tracker::DeformationPrior from_json(const std::string& file, const ordered_json& json) {
    const Section top(file, json, "");
    if (const auto format = json.find("format"); format == json.end() || *format != kFormat)
        top.wrong("format", std::string("\"") + kFormat + "\", a file of atropos learn-prior");
    if (const auto version = json.find("version"); version == json.end() || *version != kVersion)
        top.wrong("version", std::to_string(kVersion) + ", the only one there is");
    tracker::DeformationPrior prior;
    prior.control_points = top.integer("control_points", 4, 64);
    prior.frame_rate_hz = top.number("frame_rate_hz");
    prior.tracks = top.integer("tracks", 0, 1'000'000'000);
    prior.frames = top.integer("frames", 0, 1'000'000'000);
    prior.rest_sigma_m = top.number("rest_sigma_m");
    const ordered_json& modes = top.array("modes", 1, static_cast<std::size_t>(3 * prior.control_points - 1));
    const int M = static_cast<int>(modes.size());
    prior.modes.resize(3 * prior.control_points, M);
    prior.sigmas_m.resize(M);
    for (int m = 0; m < M; ++m) {
        const Section mode(file, modes[static_cast<std::size_t>(m)], "modes[" + std::to_string(m) + "]: ");
        prior.sigmas_m[m] = mode.number("sigma_m");
        prior.modes.col(m) = displacement(mode, prior.control_points);
    }
    return prior;
}

}  // namespace

std::string to_json_text(const tracker::DeformationPrior& prior) {
    ordered_json json = {{"format", kFormat},
                         {"version", kVersion},
                         {"frame", "x along the chord of the ends, y to the side of the sag, z across"},
                         {"control_points", prior.control_points},
                         {"frame_rate_hz", prior.frame_rate_hz},
                         {"tracks", prior.tracks},
                         {"frames", prior.frames},
                         {"rest_sigma_m", prior.rest_sigma_m},
                         {"modes", ordered_json::array()}};
    for (int m = 0; m < prior.count(); ++m) {
        ordered_json points = ordered_json::array();
        for (int k = 0; k < prior.control_points; ++k) {
            const auto p = prior.modes.col(m).segment<3>(3 * k);
            points.push_back({p.x(), p.y(), p.z()});
        }
        json["modes"].push_back({{"sigma_m", prior.sigmas_m[m]}, {"displacement", points}});
    }
    return json.dump(1) + "\n";
}

tracker::DeformationPrior parse_deformation_prior(const std::string& file, const std::string& text) {
    const tracker::DeformationPrior prior = from_json(file, ordered_json::parse(text, nullptr, false));
    try {
        validate(prior);
    } catch (const std::invalid_argument& error) {
        throw FileError(file, error.what());
    }
    return prior;
}

tracker::DeformationPrior read_deformation_prior(const std::filesystem::path& file) {
    return parse_deformation_prior(file.string(), scenes::read_text_file(file, kMaxBytes));
}

}  // namespace atropos::experiments
