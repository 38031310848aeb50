#include "experiments/json_file.hpp"

#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {

nlohmann::ordered_json read_json_object(const std::filesystem::path& file) {
    constexpr std::size_t kMaxBytes = std::size_t{1} << 30;
    auto json = nlohmann::ordered_json::parse(scenes::read_text_file(file, kMaxBytes), nullptr, false);
    if (!json.is_object())
        throw scenes::FileError(file.string(), "no JSON object, expected the file as it was written");
    return json;
}

}  // namespace atropos::experiments
