#include <yaml-cpp/yaml.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <map>
#include <sstream>

#include "scenes/calibration_file.hpp"
#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"
#include "scenes/yaml_document.hpp"

namespace atropos::scenes {
namespace {

constexpr std::size_t kMaxBytes = 1 << 20;

std::vector<double> numbers(const YamlDocument& document, const YAML::Node& list, const std::string& key) {
    if (!list || !list.IsSequence())
        document.fail(list ? list : document.root, key + " has no list of numbers");
    std::vector<double> values;
    for (const auto& item : list) {
        const auto value = item.IsScalar() ? parse_number(item.Scalar()) : std::nullopt;
        if (!value) document.fail(item, key + " holds something that is no finite number");
        values.push_back(*value);
    }
    return values;
}

/// A matrix of OpenCV's FileStorage (rows, cols, data) or of ROS camera_info (the same keys). `rows` or
/// `cols` 0: any.
Eigen::MatrixXd matrix(const YamlDocument& document, const std::string& key, int rows, int cols) {
    const YAML::Node& root = document.root;
    const YAML::Node node = root.IsMap() ? root[key] : YAML::Node(YAML::NodeType::Undefined);
    if (!node) throw FileError(document.name, "no key '" + key + "', expected a matrix");
    if (!node.IsMap()) document.fail(node, key + " is no matrix, expected rows, cols, data");
    const auto size = [&](const char* name) {
        const YAML::Node value = node[name];
        const auto parsed = value && value.IsScalar() ? parse_integer(value.Scalar()) : std::nullopt;
        if (!parsed || *parsed < 1 || *parsed > 64)
            document.fail(node, key + " has no usable '" + name + "'");
        return static_cast<int>(*parsed);
    };
    const int r = size("rows"), c = size("cols");
    if ((rows && r != rows) || (cols && c != cols))
        document.fail(node, key + " is " + std::to_string(r) + "x" + std::to_string(c) + ", expected " +
                                std::to_string(rows) + "x" + std::to_string(cols));
    const std::vector<double> data = numbers(document, node["data"], key);
    if (data.size() != static_cast<std::size_t>(r * c))
        document.fail(node, key + " has " + std::to_string(data.size()) + " numbers, expected " +
                                std::to_string(r * c));
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        data.data(), r, c);
}

int whole(const YamlDocument& document, const std::string& key) {
    const YAML::Node& root = document.root;
    const YAML::Node node = root.IsMap() ? root[key] : YAML::Node(YAML::NodeType::Undefined);
    const auto value = node && node.IsScalar() ? parse_integer(node.Scalar()) : std::nullopt;
    if (!value || *value < 1 || *value > 65536)
        throw FileError(document.name, "'" + key + "' is no image size, expected 1 to 65536");
    return static_cast<int>(*value);
}

void set_intrinsics(const std::string& name, const std::string& key, const Eigen::Matrix3d& K,
                    Camera& camera) {
    if (!(K(0, 0) > 0.0 && K(1, 1) > 0.0)) throw FileError(name, key + ": focal length is not above 0");
    if (K(0, 1) != 0.0 || K(1, 0) != 0.0 || K(2, 0) != 0.0 || K(2, 1) != 0.0 || K(2, 2) != 1.0)
        throw FileError(name, key + " is no camera matrix, expected [fx 0 cx; 0 fy cy; 0 0 1]");
    camera.fx_px = K(0, 0);
    camera.fy_px = K(1, 1);
    camera.cx_px = K(0, 2);
    camera.cy_px = K(1, 2);
}

void set_distortion(const std::string& name, const std::string& key, const Eigen::MatrixXd& D,
                    Camera& camera) {
    const auto count = D.size();
    if (std::min(D.rows(), D.cols()) != 1 || (count != 4 && count != 5 && count != 8))
        throw FileError(name, key + " has " + std::to_string(count) + " coefficients, expected 4, 5 or 8");
    for (Eigen::Index i = 0; i < count; ++i) camera.distortion[static_cast<std::size_t>(i)] = D(i);
}

Eigen::Matrix3d rotation(const std::string& name, const std::string& key, const Eigen::Matrix3d& R) {
    const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
    if (!(error < 1e-3) || R.determinant() < 0.0) throw FileError(name, key + " is not a rotation");
    if (error < 1e-9) return R;
    // Rounded to a few digits: the nearest rotation.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return svd.matrixU() * svd.matrixV().transpose();
}

void check_rig(const std::string& name, const StereoRig& rig) {
    const double baseline = rig.baseline_m();
    if (!(baseline > 1e-6)) throw FileError(name, "baseline is 0, expected the distance between the lenses");
    if (baseline > 1.0)
        throw FileError(name,
                        "baseline is " + decimal(1e3 * baseline) + " mm, expected under 1000 (is T in mm?)");
    if (rig.left.width_px != rig.right.width_px || rig.left.height_px != rig.right.height_px)
        throw FileError(name, "the eyes' image sizes differ");
}

}  // namespace

StereoRig parse_opencv_calibration(const std::string& name, const std::string& text) {
    const YamlDocument document = YamlDocument::parse(name, text);
    if (!document.root.IsMap()) throw FileError(name, "no calibration, expected image_size M1 D1 M2 D2 R T");
    StereoRig rig;
    const Eigen::MatrixXd size = matrix(document, "image_size", 1, 2);
    for (Camera* camera : {&rig.left, &rig.right}) {
        if (!(size.minCoeff() >= 1.0 && size.maxCoeff() <= 65536.0))
            throw FileError(name, "image_size is not from 1 to 65536");
        camera->width_px = static_cast<int>(size(0));
        camera->height_px = static_cast<int>(size(1));
    }
    set_intrinsics(name, "M1", matrix(document, "M1", 3, 3), rig.left);
    set_intrinsics(name, "M2", matrix(document, "M2", 3, 3), rig.right);
    set_distortion(name, "D1", matrix(document, "D1", 0, 0), rig.left);
    set_distortion(name, "D2", matrix(document, "D2", 0, 0), rig.right);
    rig.X_RC.linear() = rotation(name, "R", matrix(document, "R", 3, 3));
    const Eigen::MatrixXd T = matrix(document, "T", 0, 0);
    if (T.size() != 3) throw FileError(name, "T has " + std::to_string(T.size()) + " numbers, expected 3");
    rig.X_RC.translation() = Eigen::Vector3d(T(0), T(1), T(2)) / 1e3;
    check_rig(name, rig);
    return rig;
}

StereoRig parse_ros_calibration(const std::string& left_name, const std::string& left_text,
                                const std::string& right_name, const std::string& right_text) {
    StereoRig rig;
    Eigen::Matrix3d rectify[2];
    Eigen::MatrixXd projection;
    const std::string* names[] = {&left_name, &right_name};
    const std::string* texts[] = {&left_text, &right_text};
    Camera* cameras[] = {&rig.left, &rig.right};
    for (int eye = 0; eye < 2; ++eye) {
        const std::string& name = *names[eye];
        const YamlDocument document = YamlDocument::parse(name, *texts[eye]);
        cameras[eye]->width_px = whole(document, "image_width");
        cameras[eye]->height_px = whole(document, "image_height");
        set_intrinsics(name, "camera_matrix", matrix(document, "camera_matrix", 3, 3), *cameras[eye]);
        set_distortion(name, "distortion_coefficients", matrix(document, "distortion_coefficients", 0, 0),
                       *cameras[eye]);
        rectify[eye] = rotation(name, "rectification_matrix", matrix(document, "rectification_matrix", 3, 3));
        projection = matrix(document, "projection_matrix", 3, 4);
        if (!(projection(0, 0) > 0.0))
            throw FileError(name, "projection_matrix: focal length is not above 0");
    }
    // In the rectified frames the right eye stands at t: p_R = R2^T (R1 p_C + t), P2(0,3) = f * t_x.
    const Eigen::Vector3d t(projection(0, 3) / projection(0, 0), projection(1, 3) / projection(1, 1), 0.0);
    rig.X_RC.linear() = rectify[1].transpose() * rectify[0];
    rig.X_RC.translation() = rectify[1].transpose() * t;
    check_rig(right_name, rig);
    return rig;
}

StereoRig parse_ini_calibration(const std::string& name, const std::string& text) {
    std::map<std::string, double> values;  // "section.key"
    std::string section, line;
    std::istringstream lines(text);
    for (int number = 1; std::getline(lines, line); ++number) {
        line.erase(0, line.find_first_not_of(" \t"));
        line.erase(line.find_last_not_of(" \t\r") + 1);
        if (line.empty() || line[0] == ';' || line[0] == '#') continue;
        if (line.front() == '[' && line.back() == ']') {
            section = line.substr(1, line.size() - 2);
            continue;
        }
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos) throw FileError(name, number, "expected [section] or key=value");
        std::string key = line.substr(0, equals), value = line.substr(equals + 1);
        key.erase(key.find_last_not_of(" \t") + 1);
        value.erase(0, value.find_first_not_of(" \t\""));
        value.erase(value.find_last_not_of(" \t\"") + 1);
        const auto parsed = parse_number(value);
        if (!parsed) {
            if (key.starts_with("fc_") || key.starts_with("cc_") || key.starts_with("k_") ||
                key.starts_with("R_") || key.starts_with("T_") || key.starts_with("res_"))
                throw FileError(name, number, key + " is " + shown(value) + ", expected a finite number");
            continue;
        }
        values[section + "." + key] = *parsed;
    }
    const auto get = [&](const std::string& key) {
        const auto found = values.find(key);
        if (found == values.end())
            throw FileError(name, "no key '" + key + "', expected a dVRK stereo calibration");
        return found->second;
    };
    StereoRig rig;
    for (const auto& [eye, camera] :
         {std::pair{"StereoLeft.", &rig.left}, std::pair{"StereoRight.", &rig.right}}) {
        const std::string s = eye;
        const double width = get(s + "res_x"), height = get(s + "res_y");
        if (!(width >= 1 && width <= 65536 && height >= 1 && height <= 65536))
            throw FileError(name, s + "res_x, res_y: no image size");
        camera->width_px = static_cast<int>(width);
        camera->height_px = static_cast<int>(height);
        const double fx = get(s + "fc_x"), fy = get(s + "fc_y"), cx = get(s + "cc_x"), cy = get(s + "cc_y");
        Eigen::Matrix3d K;
        K << fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0;
        set_intrinsics(name, s + "fc", K, *camera);
        for (int i = 0; i < 5; ++i)
            camera->distortion[static_cast<std::size_t>(i)] = get(s + "k_" + std::to_string(i));
    }
    Eigen::Matrix3d R;
    for (int i = 0; i < 9; ++i) R(i / 3, i % 3) = get("StereoRight.R_" + std::to_string(i));
    rig.X_RC.linear() = rotation(name, "R", R);
    for (int i = 0; i < 3; ++i) rig.X_RC.translation()[i] = get("StereoRight.T_" + std::to_string(i)) / 1e3;
    check_rig(name, rig);
    return rig;
}

StereoRig load_calibration(const std::filesystem::path& file) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) {
        if (file_exists(file / "stereo.yaml")) return load_calibration(file / "stereo.yaml");
        const auto left = file / "left.yaml", right = file / "right.yaml";
        return parse_ros_calibration(left.string(), read_text_file(left, kMaxBytes), right.string(),
                                     read_text_file(right, kMaxBytes));
    }
    const std::string text = read_text_file(file, kMaxBytes);
    return file.extension() == ".ini" ? parse_ini_calibration(file.string(), text)
                                      : parse_opencv_calibration(file.string(), text);
}

}  // namespace atropos::scenes
