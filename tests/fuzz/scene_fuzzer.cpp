#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

// Any bytes are a scene or one clear error; what is a scene reads back equal.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace atropos::scenes;
    try {
        const SceneConfig scene =
            parse_scene("fuzz", std::string(reinterpret_cast<const char*>(data), size), "/nonexistent");
        const std::string text = to_yaml(scene);
        if (to_yaml(parse_scene("again", text, "/nonexistent")) != text)
            throw std::logic_error("not equal when read back");
    } catch (const FileError&) {
    }
    return 0;
}
