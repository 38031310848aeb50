#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string_view>

#include "robot/recording.hpp"

namespace atropos::robot {
namespace {

[[noreturn]] void fail(const std::string& name, int line, const std::string& what) {
    throw std::runtime_error(name + ":" + std::to_string(line) + ": " + what);
}

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> fields;
    while (true) {
        const auto end = text.find(separator);
        fields.push_back(trimmed(text.substr(0, end)));
        if (end == std::string_view::npos) return fields;
        text.remove_prefix(end + 1);
    }
}

double number(std::string_view text, const std::string& name, int line) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        fail(name, line, "'" + std::string(text.substr(0, 40)) + "', expected a finite number");
    return value;
}

// Columns of a header by name, -1 when absent.
struct Header {
    std::vector<std::string_view> names;

    int find(std::string_view name) const {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? -1 : static_cast<int>(found - names.begin());
    }
    // Six columns q1..q6, any common prefix ending in '_', or CRTK's joint names.
    std::array<int, 6> joints() const {
        std::array<int, 6> columns;
        columns.fill(-1);
        for (int i = 0; i < 6; ++i)
            columns[static_cast<size_t>(i)] = find(kJointNames[static_cast<size_t>(i)]);
        if (columns[0] >= 0) return columns;
        for (size_t c = 0; c < names.size(); ++c) {
            if (names[c] != "q1" && !names[c].ends_with("_q1")) continue;
            const std::string prefix(names[c].substr(0, names[c].size() - 1));
            for (int i = 0; i < 6; ++i)
                columns[static_cast<size_t>(i)] = find(prefix + std::to_string(i + 1));
            return columns;
        }
        return columns;
    }
};

constexpr std::array<std::string_view, 7> kPoseColumns = {"x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"};

}  // namespace

std::vector<Recording> read_recording_csv(std::istream& in, const std::string& name, double rate_hz) {
    if (!(rate_hz > 0.0)) throw std::runtime_error(name + ": rate must be above 0 Hz");
    std::string head, text;
    if (!std::getline(in, head)) fail(name, 1, "empty file, expected a header");
    const Header header{split(head, ',')};
    const auto joint_columns = header.joints();
    const bool has_joints =
        std::none_of(joint_columns.begin(), joint_columns.end(), [](int c) { return c < 0; });
    std::array<int, 7> pose_columns;
    for (size_t i = 0; i < 7; ++i) pose_columns[i] = header.find(kPoseColumns[i]);
    const int time_column = header.find("time_s"), arm_column = header.find("arm");
    const int frame_column = header.find("frame_id"), jaw_column = header.find("jaw_rad");
    const bool has_poses = frame_column >= 0 && std::none_of(pose_columns.begin(), pose_columns.end(),
                                                             [](int c) { return c < 0; });
    if (!has_joints && !has_poses)
        fail(name, 1, "no arm's motion, expected columns q1..q6, or frame_id,x_m,y_m,z_m,qx,qy,qz,qw");

    std::vector<Recording> recordings;
    for (int line = 2; std::getline(in, text); ++line) {
        if (trimmed(text).empty()) continue;
        const auto fields = split(text, ',');
        if (fields.size() != header.names.size())
            fail(name, line,
                 std::to_string(fields.size()) + " columns, expected " + std::to_string(header.names.size()));
        const auto field = [&](int column) { return fields[static_cast<size_t>(column)]; };
        const std::string arm(arm_column >= 0 ? field(arm_column) : "");
        if (arm == "ECM") continue;
        auto found = std::find_if(recordings.begin(), recordings.end(),
                                  [&](const Recording& r) { return r.arm == arm; });
        if (found == recordings.end()) {
            recordings.emplace_back();
            found = recordings.end() - 1;
            found->arm = arm;
            found->frame_id = has_poses ? std::string(field(frame_column)) : "joints";
        }
        Recording& r = *found;
        if (has_poses && field(frame_column) != r.frame_id)
            fail(name, line,
                 "frame_id changes to '" + std::string(field(frame_column)) + "', expected '" + r.frame_id +
                     "' throughout");
        r.time_s.push_back(time_column >= 0 ? number(field(time_column), name, line)
                                            : static_cast<double>(r.size()) / rate_hz);
        r.line.push_back(line);
        if (jaw_column >= 0) r.jaw_rad.push_back(number(field(jaw_column), name, line));
        if (has_joints) {
            Joints q;
            for (int i = 0; i < 6; ++i)
                q[i] = number(field(joint_columns[static_cast<size_t>(i)]), name, line);
            r.q.push_back(q);
        }
        if (has_poses) {
            std::array<double, 7> v;
            for (size_t i = 0; i < 7; ++i) v[i] = number(field(pose_columns[i]), name, line);
            const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
            if (std::abs(rotation.norm() - 1.0) > 1e-3) fail(name, line, "quaternion not of length 1");
            r.X_FT.push_back(Eigen::Translation3d(v[0], v[1], v[2]) * rotation.normalized());
        }
    }
    if (recordings.empty()) fail(name, 2, "no rows, expected at least one");
    return recordings;
}

std::vector<Recording> read_jigsaws(std::istream& in, const std::string& name) {
    std::vector<Recording> arms(2);
    arms[0].arm = "PSM1";
    arms[1].arm = "PSM2";
    arms[0].frame_id = arms[1].frame_id = "ECM";
    std::string text;
    for (int line = 1; std::getline(in, text); ++line) {
        std::replace(text.begin(), text.end(), '\t', ' ');
        std::vector<double> v;
        for (const std::string_view field : split(text, ' '))
            if (!field.empty()) v.push_back(number(field, name, line));
        if (v.empty()) continue;
        if (v.size() != 76)
            fail(name, line, std::to_string(v.size()) + " columns, expected the 76 of JIGSAWS");
        for (size_t arm = 0; arm < 2; ++arm) {
            const double* p = v.data() + 38 + 19 * arm;  // two masters of 19 columns stand before
            Eigen::Matrix3d R;
            R << p[3], p[4], p[5], p[6], p[7], p[8], p[9], p[10], p[11];
            if ((R * R.transpose() - Eigen::Matrix3d::Identity()).norm() > 1e-2 || R.determinant() < 0.0)
                fail(name, line,
                     "no rotation matrix in columns " + std::to_string(42 + 19 * arm) + " on, expected one");
            Recording& r = arms[arm];
            r.time_s.push_back(static_cast<double>(r.size()) / 30.0);
            r.line.push_back(line);
            r.jaw_rad.push_back(p[18]);
            r.X_FT.push_back(Eigen::Translation3d(p[0], p[1], p[2]) * Eigen::Quaterniond(R).normalized());
        }
    }
    if (arms[0].size() == 0) fail(name, 1, "no rows, expected at least one");
    return arms;
}

}  // namespace atropos::robot
