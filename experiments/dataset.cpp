#include "experiments/dataset.hpp"

#include <fmt/format.h>

#include <set>

#include "experiments/json_file.hpp"
#include "experiments/sha256.hpp"
#include "experiments/version.hpp"
#include "scenes/file_error.hpp"
#include "scenes/random_stream.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using nlohmann::ordered_json;
using scenes::FileError;
namespace {

ordered_json read_manifest(const fs::path& file) {
    const ordered_json json = read_json_object(file);
    if (!json.contains("complete") || json["complete"] != true)
        throw FileError(file.string(), "not marked complete, expected a finished folder");
    return json;
}

std::uintmax_t bytes_below(const fs::path& folder) {
    std::uintmax_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) bytes += entry.file_size();
    return bytes;
}

std::set<std::string> files_below(const fs::path& folder) {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) names.insert(fs::relative(entry.path(), folder).generic_string());
    return names;
}

}  // namespace

std::string split_of_seed(std::uint64_t seed) {
    const double u = scenes::RandomStream(seed, "split").uniform();
    return u < 0.8 ? "train" : u < 0.9 ? "val" : "test";
}

ordered_json describe_dataset(const fs::path& folder, const std::string& name,
                              const std::vector<DatasetSequence>& sequences,
                              const std::vector<std::string>& layers, int accel) {
    ordered_json dataset;
    dataset["name"] = name;
    dataset["version"] = version_number();
    dataset["count"] = sequences.size();
    dataset["accel"] = accel;
    dataset["layers"] = layers;
    long frames = 0;
    std::uintmax_t bytes = 0;
    dataset["splits"] = {
        {"train", ordered_json::array()}, {"val", ordered_json::array()}, {"test", ordered_json::array()}};
    dataset["sequences"] = ordered_json::array();
    for (const DatasetSequence& sequence : sequences) {
        const fs::path meta = folder / sequence.name / "meta.json";
        const long count = read_manifest(meta).at("frames").get<long>();
        frames += count;
        bytes += bytes_below(folder / sequence.name);
        dataset["splits"][split_of_seed(sequence.seed)].push_back(sequence.name);
        ordered_json drawn = ordered_json::object();
        for (const auto& [key, value] : sequence.drawn) drawn[key] = value;
        dataset["sequences"].push_back({{"name", sequence.name},
                                        {"seed", sequence.seed},
                                        {"frames", count},
                                        {"drawn", drawn},
                                        {"sha256_meta", sha256_of_file(meta)}});
    }
    dataset["frames"] = frames;
    dataset["bytes"] = bytes;
    dataset["complete"] = true;
    return dataset;
}

std::string dataset_card(const ordered_json& dataset) {
    std::string layers;
    for (const auto& layer : dataset["layers"])
        layers += (layers.empty() ? "" : ", ") + layer.get<std::string>();
    const auto size = [&](const char* split) { return dataset["splits"][split].size(); };
    return fmt::format(
        "# {}\n\n"
        "Simulated stereo endoscope pictures of a surgical thread held by da Vinci arms, with the true "
        "thread, made by\n"
        "Atropos {}: {} sequences, {} stereo frames, {:.1f} MB. Splits by seed (never by frame): train {}, "
        "val {}, test {}.\n"
        "Layers besides pictures, calibration, kinematics and the thread's curve: {}.\n\n"
        "- `dataset.json`: counts, splits, seeds, values drawn at random, checksums; `atropos info --verify "
        "DIR` recomputes them\n"
        "- `sequence_NNNNNN/`: `left/`, `right/`, `calib/`, `frames.csv`, measured `tips.csv` and "
        "`kinematics.csv`; the truth is\n"
        "  in `truth/` alone. Positions in mm in the left camera (x right, y down, z forward), pixel centres "
        "at integers,\n"
        "  depth in 1/64 mm and disparity in 1/64 px, 0 = nothing; masks: 0 background, 1 thread, 2 tissue, "
        "3-5 PSM1-3\n"
        "- `sequence_NNNNNN/scene.yaml`: the whole scene; the same program makes the same bytes from it\n"
        "- `atropos_numpy.py` reads it with numpy alone, `atropos_torch.py` is a torch `Dataset`\n\n"
        "Known gaps to real pictures: no blood, smoke, fluid or lens soiling; tissue doesn't deform; one "
        "light on the\n"
        "endoscope's axis; instruments without wear; the thread's optics are those of a ribbon with a twist "
        "pattern.\n",
        dataset["name"].get<std::string>(), dataset["version"].get<std::string>(),
        dataset["count"].get<std::size_t>(), dataset["frames"].get<long>(),
        1e-6 * dataset["bytes"].get<double>(), size("train"), size("val"), size("test"),
        layers.empty() ? "none" : layers);
}

void verify_sequence(const fs::path& folder) {
    const fs::path file = folder / "meta.json";
    const ordered_json meta = read_manifest(file);
    if (!meta.contains("sha256") || !meta["sha256"].is_object())
        throw FileError(file.string(), "no sha256, expected a sequence's meta.json");
    std::set<std::string> names = files_below(folder);
    names.erase("meta.json");
    for (const auto& [name, sum] : meta["sha256"].items()) {
        if (names.erase(name) == 0)
            throw FileError((folder / name).string(), "is missing, meta.json lists it");
        if (sum != sha256_of_file(folder / name))
            throw FileError((folder / name).string(),
                            "is not what was written: its checksum differs from meta.json's");
    }
    if (!names.empty())
        throw FileError((folder / *names.begin()).string(), "is new, meta.json doesn't list it");
}

void verify_dataset(const fs::path& folder) {
    const fs::path file = folder / "dataset.json";
    const ordered_json dataset = read_manifest(file);
    try {
        for (const auto& sequence : dataset.at("sequences")) {
            const fs::path place = folder / sequence.at("name").get<std::string>();
            if (!fs::is_directory(place))
                throw FileError(place.string(), "is missing, dataset.json lists it");
            if (sequence.at("sha256_meta").get<std::string>() != sha256_of_file(place / "meta.json"))
                throw FileError((place / "meta.json").string(),
                                "is not what was written: its checksum differs from dataset.json's");
            verify_sequence(place);
        }
        if (dataset.at("sequences").size() != dataset.at("count").get<std::size_t>())
            throw FileError(file.string(), "count and the list of sequences differ");
    } catch (const nlohmann::json::exception&) {
        throw FileError(file.string(),
                        "a key is missing or of another type, expected the file as it was written");
    }
}

}  // namespace atropos::experiments
