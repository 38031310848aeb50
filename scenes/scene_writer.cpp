#include <fmt/format.h>

#include "scenes/calibration_file.hpp"
#include "scenes/field_table.hpp"
#include "scenes/scene_file.hpp"
#include "scenes/text_file.hpp"

namespace atropos::scenes {
namespace {

std::string in_file_unit(std::string_view key, double value_si) {
    return decimal(value_si, unit_of_key(key));
}

std::string plain_or_quoted(const std::string& text) {
    const bool plain =
        !text.empty() &&
        text.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./") ==
            std::string::npos &&
        text != "true" && text != "false";
    if (plain) return text;
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') out += '\\';
        if (c == '\n') {
            out += "\\n";
            continue;
        }
        out += c;
    }
    return out + "\"";
}

std::string row_in_file_unit(std::string_view key, const Eigen::Vector3d& v) {
    return fmt::format("[{}, {}, {}]", in_file_unit(key, v.x()), in_file_unit(key, v.y()),
                       in_file_unit(key, v.z()));
}

class Writer final : public FieldVisitor {
  public:
    std::string text_;

    void number(const Field& f, double& value, const Range&) override { line(f, in_file_unit(f.key, value)); }
    void integer(const Field& f, int& value, int, int) override { line(f, std::to_string(value)); }
    void seed(const Field& f, std::uint64_t& value) override { line(f, std::to_string(value)); }
    void flag(const Field& f, bool& value) override { line(f, value ? "true" : "false"); }
    void text(const Field& f, std::string& value, const Words&) override { line(f, plain_or_quoted(value)); }
    void path(const Field& f, std::string& value) override { line(f, plain_or_quoted(value)); }
    void vector(const Field& f, Eigen::Vector3d& v, const Range&) override {
        line(f, row_in_file_unit(f.key, v));
    }
    void vectors(const Field& f, std::vector<Eigen::Vector3d>& values, const Range&) override {
        std::string rows;
        for (const Eigen::Vector3d& v : values)
            rows += (rows.empty() ? "" : ", ") + row_in_file_unit(f.key, v);
        line(f, "[" + rows + "]");
    }
    void section(const Field& f, const std::function<void()>& fields) override {
        text_ += fmt::format("{:{}}{}:\n", "", indent_, f.key);
        indent_ += 2;
        fields();
        indent_ -= 2;
    }

  private:
    void line(const Field& f, const std::string& value) {
        text_ += fmt::format("{:{}}{}: {}\n", "", indent_, f.key, value);
    }
    int indent_ = 0;
};

/// One table a section: key, default, allowed values, meaning.
class Documenter final : public FieldVisitor {
  public:
    std::string text_;
    std::string sections_;

    void number(const Field& f, double& value, const Range& r) override {
        row(f, in_file_unit(f.key, value), range(r));
    }
    void integer(const Field& f, int& value, int low, int high) override {
        row(f, std::to_string(value), fmt::format("{} to {}", low, high));
    }
    void seed(const Field& f, std::uint64_t& value) override { row(f, std::to_string(value), "0 or more"); }
    void flag(const Field& f, bool& value) override { row(f, value ? "true" : "false", "true, false"); }
    void text(const Field& f, std::string& value, const Words& words) override {
        row(f, value, fmt::format("{}", fmt::join(words, ", ")));
    }
    void path(const Field& f, std::string& value) override { row(f, value, "a file"); }
    void vector(const Field& f, Eigen::Vector3d& v, const Range& r) override {
        row(f, row_in_file_unit(f.key, v), "three, each " + range(r));
    }
    void vectors(const Field& f, std::vector<Eigen::Vector3d>&, const Range& r) override {
        row(f, "[]", "rows of three, each " + range(r));
    }
    void section(const Field& f, const std::function<void()>& fields) override {
        const std::string outer_path = path_;
        std::string outer_text;
        outer_text.swap(text_);
        path_ += (path_.empty() ? "" : ".") + std::string(f.key);
        const std::size_t place = sections_.size();
        fields();
        sections_.insert(place, fmt::format("\n## {}\n{}\n\n{}", path_, f.doc, text_));
        path_ = outer_path;
        text_.swap(outer_text);
    }

  private:
    static std::string range(const Range& r) {
        if (std::isinf(r.high))
            return std::isinf(r.low) ? "any"
                                     : fmt::format("{}{}", r.without_low ? "above " : "at least ", r.low);
        return fmt::format("{}{} to {}", r.without_low ? "above " : "", r.low, r.high);
    }
    void row(const Field& f, const std::string& value, const std::string& allowed) {
        if (text_.empty()) text_ = "| key | default | allowed | meaning |\n|---|---|---|---|\n";
        text_ += fmt::format("| `{}` | {} | {} | {} |\n", f.key, value.empty() ? "" : "`" + value + "`",
                             allowed, f.doc);
    }
    std::string path_;
};

}  // namespace

std::string to_yaml(const SceneConfig& scene) {
    SceneConfig copy = scene;
    Writer writer;
    visit_fields(writer, copy);
    return writer.text_;
}

std::string scene_reference_markdown() {
    SceneConfig defaults;
    Documenter documenter;
    visit_fields(documenter, defaults);
    return "# Scene files\n\n"
           "Written by `atropos info --scene-keys` from the table that the loader reads; a test compares the "
           "two.\n\n"
           "A scene is a YAML file. Every key has a default, an unknown key is an error. `include: FILE` "
           "reads another\n"
           "scene first; `--set key.path=value` overrides on the command line. Units stand in the keys. "
           "Paths are relative to the\n"
           "file that names them, then to the share folder.\n\n"
           "`randomise:` leaves keys to chance: `key.path: [low, high]` (uniform), `{log: [low, high]}`, "
           "`{whole: "
           "[low, high]}`,\n"
           "`{choice: [a, b]}`. `atropos generate` draws them anew for each sequence and records the values; "
           "all other commands\nuse the keys as they stand.\n\n" +
           documenter.text_ + documenter.sections_;
}

StereoRig scene_rig(const CameraConfig& camera) {
    StereoRig rig =
        camera.calibration.empty() ? rig_preset(camera.preset).rig : load_calibration(camera.calibration);
    const double factor_x =
        camera.width_px > 0 ? static_cast<double>(camera.width_px) / rig.left.width_px : 1.0;
    const double factor_y =
        camera.height_px > 0 ? static_cast<double>(camera.height_px) / rig.left.height_px : factor_x;
    if (camera.width_px > 0 || camera.height_px > 0) {
        const double factor = camera.width_px > 0 ? factor_x : factor_y;
        rig = rig.scaled(factor);
        if (camera.height_px > 0 && rig.left.height_px != camera.height_px)
            throw std::invalid_argument(fmt::format("camera.height_px is {}, expected {} for a width of {}",
                                                    camera.height_px, rig.left.height_px, rig.left.width_px));
    }
    for (Camera* eye : {&rig.left, &rig.right}) {
        eye->distortion[0] += camera.k1;
        eye->distortion[1] += camera.k2;
    }
    return rig;
}

}  // namespace atropos::scenes
