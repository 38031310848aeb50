#pragma once

#include <filesystem>
#include <string>

#include "scenes/stereo_rig.hpp"

namespace atropos::scenes {

/// Reads a stereo calibration: OpenCV FileStorage YAML (M1 D1 M2 D2 R T in mm), a folder with stereo.yaml or
/// with ROS camera_info left.yaml and right.yaml (m), or a dVRK / SurgPose .ini. Throws FileError on anything
/// that is no calibration: missing keys, wrong shapes, no finite numbers, focal length or baseline 0, not a
/// rotation.
StereoRig load_calibration(const std::filesystem::path& file);

StereoRig parse_opencv_calibration(const std::string& name, const std::string& text);
StereoRig parse_ros_calibration(const std::string& left_name, const std::string& left_text,
                                const std::string& right_name, const std::string& right_text);
StereoRig parse_ini_calibration(const std::string& name, const std::string& text);

/// calib/stereo.yaml of a sequence: T in mm.
std::string to_opencv_yaml(const StereoRig& rig);

/// calib/left.yaml and right.yaml of a sequence: ROS camera_info, metres.
std::string to_ros_yaml(const StereoRig& rig, bool right);

}  // namespace atropos::scenes
