#include <stdexcept>

#include "scenes/stereo_rig.hpp"

namespace atropos::scenes {
namespace {

// Padoy and Hager give the image size and a 5 mm baseline, but no focal length. 575 px at 640 wide (58
// degrees) is what da Vinci endoscopes measure.
constexpr double kPaperFocalPerWidth = 575.0 / 640.0;

StereoRig paper_rig(int width_px, int height_px) {
    return parallel_rig(width_px, height_px, kPaperFocalPerWidth * width_px, 0.005);
}

StereoRig scared_rig() {
    StereoRig rig;
    rig.left = {1280, 1024, 1035.3, 1035.1, 596.95, 520.41, {-0.0006, -0.0005, 0.0, 0.0, 0.0018}};
    rig.right = {1280, 1024, 1035.2, 1035.0, 688.36, 521.49, {-0.0006, -0.0005, 0.0, 0.0, 0.0018}};
    rig.X_RC.translation() = 1e-3 * Eigen::Vector3d(-4.14339, -0.0238, -0.0019);
    return rig;
}

StereoRig hamlyn_rig() {
    StereoRig rig = parallel_rig(320, 240, 383.19, 0.005382);
    rig.left.cx_px = rig.right.cx_px = 155.97;
    rig.left.cy_px = rig.right.cy_px = 124.33;
    return rig;
}

}  // namespace

const std::vector<RigPreset>& rig_presets() {
    static const std::vector<RigPreset> presets = {
        {"paper",
         "Padoy and Hager 2011: HD reduced by 3, baseline 5 mm; focal length and distance our choice", 0.100,
         paper_rig(640, 360)},
        {"paper-half", "Padoy and Hager 2011: half-size HD of the robot demonstration, baseline 5 mm", 0.100,
         paper_rig(960, 540)},
        {"paper-a", "reading A of Table I: millimetres as printed, full HD, working distance 70 mm", 0.070,
         paper_rig(1920, 1080)},
        {"paper-b", "reading B of Table I: 3D columns in centimetres, 640 wide, working distance 220 mm",
         0.220, paper_rig(640, 360)},
        {"hd", "full HD at the default working distance of 100 mm, baseline 5 mm", 0.100,
         paper_rig(1920, 1080)},
        {"scared",
         "SCARED challenge, da Vinci Xi: 1280x1024, baseline 4.143 mm, principal points 91 px apart", 0.080,
         scared_rig()},
        {"hamlyn", "Hamlyn phantom heart, da Vinci: 320x240, f 383.19 px, baseline 5.382 mm", 0.080,
         hamlyn_rig()},
        {"serv-ct",
         "SERV-CT class, da Vinci Classic PAL: 720x576; focal length and baseline (5 mm) our choice", 0.080,
         parallel_rig(720, 576, 760.0, 0.005)},
    };
    return presets;
}

const RigPreset& rig_preset(std::string_view name) {
    std::string known;
    for (const RigPreset& preset : rig_presets()) {
        if (preset.name == name) return preset;
        known += (known.empty() ? "" : ", ") + std::string(preset.name);
    }
    throw std::invalid_argument("no camera preset '" + std::string(name) + "', expected one of " + known);
}

}  // namespace atropos::scenes
