#include <fmt/format.h>

#include "scenes/calibration_file.hpp"
#include "scenes/text_file.hpp"

namespace atropos::scenes {
namespace {

std::string joined(const Eigen::MatrixXd& m, double unit) {
    std::string text;
    for (Eigen::Index r = 0; r < m.rows(); ++r)
        for (Eigen::Index c = 0; c < m.cols(); ++c) {
            std::string number = decimal(m(r, c), unit);
            if (number.find_first_of(".en") == std::string::npos)
                number += '.';  // OpenCV reads "5" as an int
            text += (text.empty() ? "" : ", ") + number;
        }
    return text;
}

std::string opencv_matrix(const char* key, const Eigen::MatrixXd& m, double unit = 1.0) {
    return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: [ {} ]\n", key,
                       m.rows(), m.cols(), joined(m, unit));
}

std::string ros_matrix(const char* key, const Eigen::MatrixXd& m) {
    return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: [{}]\n", key, m.rows(), m.cols(),
                       joined(m, 1.0));
}

Eigen::MatrixXd distortion(const Camera& camera) {
    // Five coefficients where they suffice: the form that every reader knows.
    const bool rational =
        camera.distortion[5] != 0.0 || camera.distortion[6] != 0.0 || camera.distortion[7] != 0.0;
    return Eigen::Map<const Eigen::RowVectorXd>(camera.distortion.data(), rational ? 8 : 5);
}

}  // namespace

std::string to_opencv_yaml(const StereoRig& rig) {
    const Rectification r = rig.rectification();
    // Lengths in mm: the last column of P2, and the last row of Q by its inverse.
    ProjectionMatrix P2_mm = r.P2;
    P2_mm.col(3) *= 1e3;
    Eigen::Matrix4d Q_mm = r.Q;
    Q_mm.row(3) *= 1e-3;
    return "%YAML:1.0\n---\n" +
           fmt::format("image_size: !!opencv-matrix\n   rows: 1\n   cols: 2\n   dt: i\n   data: [ {}, {} ]\n",
                       rig.left.width_px, rig.left.height_px) +
           opencv_matrix("M1", rig.left.K()) + opencv_matrix("D1", distortion(rig.left)) +
           opencv_matrix("M2", rig.right.K()) + opencv_matrix("D2", distortion(rig.right)) +
           opencv_matrix("R", rig.X_RC.linear()) + opencv_matrix("T", rig.X_RC.translation(), 1e-3) +
           opencv_matrix("R1", r.R1) + opencv_matrix("R2", r.R2) + opencv_matrix("P1", r.P1) +
           opencv_matrix("P2", P2_mm) + opencv_matrix("Q", Q_mm);
}

std::string to_ros_yaml(const StereoRig& rig, bool right) {
    const Rectification r = rig.rectification();
    const Camera& camera = right ? rig.right : rig.left;
    const Eigen::MatrixXd D = distortion(camera);
    return fmt::format("image_width: {}\nimage_height: {}\ncamera_name: {}\n", camera.width_px,
                       camera.height_px, right ? "right" : "left") +
           ros_matrix("camera_matrix", camera.K()) +
           fmt::format("distortion_model: {}\n", D.size() == 5 ? "plumb_bob" : "rational_polynomial") +
           ros_matrix("distortion_coefficients", D) +
           ros_matrix("rectification_matrix", right ? r.R2 : r.R1) +
           ros_matrix("projection_matrix", right ? r.P2 : r.P1);
}

}  // namespace atropos::scenes
