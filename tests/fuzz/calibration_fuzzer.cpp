#include <cstddef>
#include <cstdint>
#include <string>

#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"

// Any bytes are a calibration in one of its forms, or one clear error.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace atropos::scenes;
    const std::string text(reinterpret_cast<const char*>(data), size);
    try {
        parse_opencv_calibration(to_opencv_yaml(parse_opencv_calibration("fuzz", text)), text);
    } catch (const FileError&) {
    }
    try {
        parse_ini_calibration("fuzz", text);
    } catch (const FileError&) {
    }
    try {
        parse_ros_calibration("left", text, "right", text);
    } catch (const FileError&) {
    }
    return 0;
}
