#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"

// Replays what the fuzzers found and were seeded with, without libFuzzer.
namespace atropos::scenes {
namespace {
namespace fs = std::filesystem;

template <class Reader>
int replay(const char* corpus, const Reader& read) {
    int files = 0;
    for (const auto& entry :
         fs::directory_iterator(fs::path(ATROPOS_SOURCE_DIR) / "tests/fuzz/corpus" / corpus)) {
        std::ifstream stream(entry.path(), std::ios::binary);
        const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
        try {
            read(bytes);
        } catch (const FileError& error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << entry.path();
        }
        ++files;
    }
    return files;
}

TEST(FuzzCorpus, of_scenes_gives_scenes_or_one_line) {
    EXPECT_GT(replay("scene", [](const std::string& text) { parse_scene("fuzz", text, "/nonexistent"); }), 0);
}

TEST(FuzzCorpus, of_calibrations_gives_rigs_or_one_line) {
    EXPECT_GT(replay("calibration", [](const std::string& text) { parse_opencv_calibration("fuzz", text); }),
              0);
    EXPECT_GT(replay("calibration", [](const std::string& text) { parse_ini_calibration("fuzz", text); }), 0);
}

}  // namespace
}  // namespace atropos::scenes
