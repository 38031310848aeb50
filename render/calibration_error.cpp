#include "render/calibration_error.hpp"

#include "scenes/random_stream.hpp"

namespace atropos::render {

scenes::StereoRig told_rig(const scenes::StereoRig& truth, const CalibrationError& error,
                           std::uint64_t seed) {
    scenes::RandomStream random(seed, "calibration");
    scenes::StereoRig told = truth;
    const double focal = 1.0 + random.normal(0.0, error.focal_relative);
    for (scenes::Camera* camera : {&told.left, &told.right}) {
        const double centre_px = error.centre_px * camera->width_px / 640.0;
        camera->fx_px *= focal;
        camera->fy_px *= focal;
        camera->cx_px += random.normal(0.0, centre_px);
        camera->cy_px += random.normal(0.0, centre_px);
        camera->distortion[0] += random.normal(0.0, error.k1);
    }
    Eigen::Vector3d turn, shift;
    for (int i = 0; i < 3; ++i) turn[i] = random.normal(0.0, error.rotation_rad);
    for (int i = 0; i < 3; ++i) shift[i] = random.normal(0.0, error.baseline_m);
    const double angle = turn.norm();
    if (angle > 0.0)
        told.X_RC.linear() = told.X_RC.linear() * Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    told.X_RC.translation() += shift;
    return told;
}

}  // namespace atropos::render
