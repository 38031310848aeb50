#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "render/light.hpp"
#include "render/thread_ribbon.hpp"
#include "scenes/render_item.hpp"

namespace atropos::render {

/// A point whose pixel and visibility are asked for.
struct SamplePoint {
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
    int ribbon = -1;   ///< index of the ribbon whose axis the point lies on; -1: on none
    double s_m = 0.0;  ///< arc length there, so that a thread doesn't hide itself by its own neighbourhood
};

/// Whether a sample is seen, or what hides it. By geometry: rays against triangles and against the thread's
/// body.
enum class Visibility : std::uint8_t {
    kVisible,
    kOutside,       ///< behind the camera or off the image
    kBehindTool,    ///< an instrument or the needle
    kBehindTissue,  ///< tissue or anything else at rest
    kBehindThread,  ///< the thread itself
};

struct SampleView {
    Eigen::Vector2d pixel =
        Eigen::Vector2d::Zero();  ///< on the distorted image; unset when behind the camera
    Visibility visibility = Visibility::kOutside;
};

/// What is in front of the endoscope at one instant. Everything spanned must live during the call only.
struct FrameInput {
    Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();
    std::span<const scenes::RenderItem> items;
    std::span<const ThreadRibbon> ribbons;
    std::span<const SamplePoint> samples;
    Light light;
};

/// One eye's image and its truth, rows from the top, all of the rig's size and distortion.
struct EyeFrame {
    cv::Mat linear;    ///< CV_32FC3, B G R, linear light, 1 = white at exposure 1
    cv::Mat depth_m;   ///< CV_32F, z in the eye's frame at the pixel's centre, 0 = nothing; thread left out
    cv::Mat labels;    ///< CV_8U, scenes::Label at the pixel's centre; thread where coverage >= 0.5
    cv::Mat coverage;  ///< CV_32F, share of the pixel's light that comes from the thread, [0, 1]
    std::vector<SampleView> samples;  ///< one a sample point
};

struct StereoFrame {
    EyeFrame left;
    EyeFrame right;
};

}  // namespace atropos::render
