#include "scenes/scene_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::scenes {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

SceneConfig parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
    return parse_scene("scene.yaml", text, ".", overrides);
}

std::string error_of(const std::string& text, const std::vector<std::string>& overrides = {}) {
    try {
        parse(text, overrides);
    } catch (const FileError& error) {
        return error.what();
    }
    return "no error";
}

class SceneFolder : public testing::Test {
  protected:
    SceneFolder() : folder_(fs::temp_directory_path() / ("atropos-scene-" + std::to_string(getpid()))) {
        fs::create_directories(folder_);
    }
    ~SceneFolder() override { fs::remove_all(folder_); }
    fs::path write(const std::string& name, const std::string& text) {
        std::ofstream(folder_ / name) << text;
        return folder_ / name;
    }
    fs::path folder_;
};

TEST(SceneFile, converts_units_by_the_keys_ending) {
    const SceneConfig scene =
        parse("thread: {length_mm: 80, twist_deg: 180, EI_N_m2: 3e-7}\ntracker: {latency_ms: 20}\n");
    EXPECT_DOUBLE_EQ(scene.thread.length_m, 0.08);
    EXPECT_NEAR(scene.thread.twist_rad, 3.14159265358979, 1e-12);
    EXPECT_DOUBLE_EQ(scene.thread.EI_N_m2, 3e-7);
    EXPECT_DOUBLE_EQ(scene.tracking.latency_s, 0.02);
}

TEST(SceneFile, keeps_defaults_of_keys_that_are_not_there) {
    const SceneConfig scene = parse("seed: 5\n");
    EXPECT_EQ(scene.seed, 5u);
    EXPECT_EQ(scene.camera.preset, "paper");
    EXPECT_DOUBLE_EQ(scene.thread.length_m, 0.07);
}

TEST(SceneFile, overrides_win_in_their_order) {
    const SceneConfig scene =
        parse("camera: {fps_hz: 30}\n", {"camera.fps_hz=25", "arms.PSM1.tool=prograsp", "camera.fps_hz=20"});
    EXPECT_DOUBLE_EQ(scene.camera.fps_hz, 20.0);
    EXPECT_EQ(scene.arms.psm1.tool, "prograsp");
}

TEST(SceneFile, resolved_form_reads_back_equal) {
    const SceneConfig scene = parse(
        "name: 'a \"b\" c'\nseed: 9\nthread: {length_mm: 73.3, twist_deg: 33.3, model: bullet_soft}\n"
        "camera: {hand_eye: {position_mm: [0.1, -0.2, 0.3]}}\ntracker: {method: e1, latency_ms: 33.3}\n");
    const std::string text = to_yaml(scene);
    EXPECT_EQ(to_yaml(parse(text)), text);
    EXPECT_EQ(parse(text).thread.twist_rad, scene.thread.twist_rad);
    EXPECT_EQ(parse(text).name, scene.name);
}

TEST_F(SceneFolder, includes_are_read_first_and_paths_belong_to_the_file_that_names_them) {
    fs::create_directories(folder_ / "base");
    write("base/cal.yaml", "x: 1\n");
    write("base/base.yaml", "camera: {fps_hz: 25, calibration: cal.yaml}\nseed: 3\n");
    const SceneConfig scene = load_scene(write("top.yaml", "include: base/base.yaml\nseed: 4\n"));
    EXPECT_DOUBLE_EQ(scene.camera.fps_hz, 25.0);
    EXPECT_EQ(scene.seed, 4u);
    EXPECT_EQ(fs::path(scene.camera.calibration), folder_ / "base/cal.yaml");
    EXPECT_EQ(scene.name, "top");
}

TEST_F(SceneFolder, refuses_include_loops_and_missing_includes) {
    write("a.yaml", "include: b.yaml\n");
    write("b.yaml", "include: a.yaml\n");
    EXPECT_THROW(load_scene(folder_ / "a.yaml"), FileError);
    EXPECT_THROW(load_scene(write("c.yaml", "include: nope.yaml\n")), FileError);
}

TEST_F(SceneFolder, refuses_files_too_large_or_missing_or_no_files) {
    std::ofstream(folder_ / "big.yaml") << "# " << std::string(5 << 20, 'x');
    EXPECT_THROW(load_scene(folder_ / "big.yaml"), FileError);
    EXPECT_THROW(load_scene(folder_ / "missing.yaml"), FileError);
    EXPECT_THROW(load_scene(folder_), FileError);
    EXPECT_THROW(load_scene("/dev/zero"), FileError);
}

struct BadScene {
    const char* name;
    std::string text;
    std::string expected;
};

void PrintTo(const BadScene& scene, std::ostream* out) {
    *out << scene.name;
}

class BadScenes : public testing::TestWithParam<BadScene> {};

TEST_P(BadScenes, give_one_line_that_says_where_and_what) {
    const std::string error = error_of(GetParam().text);
    EXPECT_THAT(error, HasSubstr(GetParam().expected));
    EXPECT_TRUE(error.starts_with("scene.yaml")) << error;
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
}

std::string nested(const std::string& open, int depth) {
    std::string text;
    for (int i = 0; i < depth; ++i) text += open;
    return text;
}

std::string laughs() {
    std::string text = "a0: &a0 [x, x, x, x, x, x, x, x, x]\n";
    for (int i = 1; i < 12; ++i) {
        const std::string last = "*a" + std::to_string(i - 1);
        text += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [" + last;
        for (int k = 0; k < 8; ++k) text += ", " + last;
        text += "]\n";
    }
    return text;
}

INSTANTIATE_TEST_SUITE_P(
    SceneFile, BadScenes,
    testing::Values(
        BadScene{"unknown_key", "seed: 1\ncamera:\n  fsp_hz: 3\n",
                 "scene.yaml:3: unknown key 'fsp_hz', nearest known is 'fps_hz'"},
        BadScene{"unknown_section", "camra: {}\n", "nearest known is 'camera'"},
        BadScene{"unknown_far", "thread:\n  zzzzzzzzzzz: 3\n", "expected one of"},
        BadScene{"text_for_number", "thread: {length_mm: long}\n",
                 "length_mm is 'long', expected a number from 10 to 500"},
        BadScene{"unit_in_number", "thread: {length_mm: 70 mm}\n", "expected a number"},
        BadScene{"out_of_range", "thread:\n  length_mm: -3\n", "scene.yaml:2: length_mm is '-3'"},
        BadScene{"zero_duration", "duration_s: 0\n", "expected a number above 0"},
        BadScene{"nan", "duration_s: .nan\n", "expected a number"},
        BadScene{"nan_word", "duration_s: nan\n", "expected a number"},
        BadScene{"infinity", "duration_s: inf\n", "expected a number"},
        BadScene{"yaml_infinity", "duration_s: -.inf\n", "expected a number"},
        BadScene{"overflow", "duration_s: 1e999\n", "expected a number"},
        BadScene{"fraction_for_integer", "thread: {edges: 10.5}\n", "expected a whole number"},
        BadScene{"integer_overflow", "thread: {edges: 99999999999999999999}\n", "expected a whole number"},
        BadScene{"negative_seed", "seed: -1\n", "seed is '-1'"},
        BadScene{"not_a_flag", "render: {shadows: 1}\n", "expected true or false"},
        BadScene{"wrong_word", "arms: {accuracy: prefect}\n", "expected one of perfect calibrated"},
        BadScene{"list_for_word", "arms: {accuracy: [perfect]}\n", "accuracy is a list"},
        BadScene{"word_for_section", "camera: paper\n", "expected a section"},
        BadScene{"list_for_section", "camera: [1]\n", "expected a section"},
        BadScene{"two_of_three", "camera: {hand_eye: {position_mm: [1, 2]}}\n", "three numbers"},
        BadScene{"vector_of_words", "camera: {hand_eye: {position_mm: [a, b, c]}}\n", "position_mm is 'a'"},
        BadScene{"missing_file", "camera: {calibration: nope.yaml}\n", "no file 'nope.yaml'"},
        BadScene{"endless_include", "include: " + std::string(5000, 'x') + "\n", "include: no file"},
        BadScene{"endless_file", "camera: {calibration: " + std::string(5000, 'x') + "}\n", "no file"},
        BadScene{"top_is_list", "- a\n- b\n", "expected `key: value` lines"},
        BadScene{"top_is_word", "hello\n", "expected `key: value` lines"},
        BadScene{"unknown_preset", "camera: {preset: papre}\n", "'papre', expected one of paper"},
        BadScene{"twice", "seed: 1\nseed: 2\n", "scene.yaml:2: key 'seed' stands twice"},
        BadScene{"two_documents", "seed: 1\n---\nseed: 2\n", "more than one YAML document"},
        BadScene{"bad_indent", "camera:\n  fps_hz: 3\n width_px: 3\n", "not valid YAML"},
        BadScene{"stray_comma", ", \n", "YAML document"},
        BadScene{"stray_comma_below", "seed: 1\n...\n,\n", "YAML document"},
        BadScene{"open_bracket", "camera: [1, 2\n", "not valid YAML"},
        BadScene{"tab", "camera:\n\tfps_hz: 3\n", "not valid YAML"},
        BadScene{"unknown_alias", "seed: *nope\n", "not valid YAML"},
        BadScene{"self_alias", "camera: &a {hand_eye: *a}\n", "scene.yaml"},
        BadScene{"many_laughs", laughs(), "more than"},
        BadScene{"deep_brackets", nested("[", 20000), "nested deeper"},
        BadScene{"deep_dashes", nested("- ", 20000) + "x\n", "scene.yaml"},
        BadScene{"complex_key", "? [a, b]\n: 3\n", "a key that is not a word"},
        BadScene{"null_value", "thread: {length_mm: }\n", "length_mm is nothing"},
        BadScene{"include_list", "include: [a, b]\n", "include is no file name"}),
    [](const auto& scene) { return scene.param.name; });

TEST_F(SceneFolder, refuses_bytes_that_are_no_text) {
    for (const std::string& bytes :
         {std::string("\x89PNG\r\n\x1a\n\0\0", 10), std::string("seed: \xff\xfe\n"),
          std::string("seed: 1\n\0", 9), std::string()}) {
        EXPECT_THROW(load_scene(write("bytes.yaml", bytes)), FileError);
    }
}

TEST(SceneFile, names_the_override_that_is_wrong) {
    EXPECT_THAT(error_of("seed: 1\n", {"camera.fsp_hz=3"}), HasSubstr("--set camera.fsp_hz=3"));
    for (const char* bad :
         {"seed", "=3", "camera.=3", "camera..fps_hz=3", "camera.fps_hz=[", "camera.fps_hz="})
        EXPECT_THAT(error_of("seed: 1\n", {bad}), HasSubstr("--set")) << bad;
}

TEST(SceneReference, in_docs_is_what_the_loader_knows) {
    const std::string committed = read_text_file(fs::path(ATROPOS_SOURCE_DIR) / "docs/scene.md", 1 << 20);
    EXPECT_EQ(committed, scene_reference_markdown())
        << "write it anew: atropos info --scene-keys > docs/scene.md";
}

}  // namespace
}  // namespace atropos::scenes
