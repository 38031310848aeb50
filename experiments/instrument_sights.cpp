#include "experiments/instrument_sights.hpp"

#include <opencv2/imgproc.hpp>

#include "robot/imperfection.hpp"

namespace atropos::experiments {
using Eigen::Vector3d;
namespace {

constexpr int kLearnEvery = 5;  // frames: colours change slowly

// One sigma of a tip's error in each axis without the wrist's play: hand-eye and the first three joints.
constexpr double kCalibratedShift_m = 0.0008, kUncalibratedShift_m = 0.0022;

}  // namespace

InstrumentSights::InstrumentSights(const scenes::StereoRig& rig, const InstrumentModels& instruments,
                                   const SightPrior& prior, int threads)
    : rig_(rig), pool_(threads) {
    for (const render::InstrumentModel& instrument : instruments) sights_.emplace_back(instrument, prior);
    eyes_[0] = {&rig_.left, Eigen::Isometry3d::Identity(), {}, {}};
    eyes_[1] = {&rig_.right, rig_.X_RC, {}, {}};
}

void InstrumentSights::label(size_t eye) {
    eyes_[eye].labels.setTo(0);
    for (size_t i = 0; i < sights_.size(); ++i)
        paint(sights_[i].outline(eye), static_cast<int>(i) + 1, eyes_[eye].labels);
}

void InstrumentSights::learn(size_t eye, const cv::Mat& image) {
    constexpr int kSure_px = 7, kClear_px = 31;
    const auto square = [](int size) { return cv::getStructuringElement(cv::MORPH_RECT, {size, size}); };
    cv::Mat inside, outside;
    cv::erode(eyes_[eye].labels, inside, square(kSure_px));
    cv::dilate(eyes_[eye].labels, outside, square(kClear_px));
    colours_[eye].learn(image, inside, outside == 0);
}

void InstrumentSights::look(const cv::Mat& left, const cv::Mat& right, const ArmReadings& arms) {
    const std::array<const cv::Mat*, 2> images = {&left, &right};
    const int count = static_cast<int>(sights_.size());
    pool_.run(count, [&](int i) {
        const auto arm = static_cast<size_t>(i);
        sights_[arm].predict(arms[arm]);
        sights_[arm].project(eyes_);
    });
    pool_.run(2, [&](int side) {
        const auto eye = static_cast<size_t>(side);
        eyes_[eye].labels.create(images[eye]->size(), CV_8U);
        label(eye);
        if (!colours_[eye].learned()) learn(eye, *images[eye]);
        eyes_[eye].probability = colours_[eye].probability(*images[eye]);
    });
    pool_.run(count, [&](int i) { sights_[static_cast<size_t>(i)].look(eyes_, i); });
    if (looks_++ % kLearnEvery != 0) return;
    pool_.run(2, [&](int side) {
        const auto eye = static_cast<size_t>(side);
        label(eye);
        learn(eye, *images[eye]);
    });
}

SightPrior sight_prior(scenes::ArmAccuracy accuracy) {
    return {accuracy == scenes::ArmAccuracy::kUncalibrated ? kUncalibratedShift_m : kCalibratedShift_m,
            robot::Imperfection::of(accuracy).play};
}

std::unique_ptr<InstrumentSights> make_instrument_sights(scenes::ArmAccuracy accuracy,
                                                         const scenes::StereoRig& rig,
                                                         const InstrumentModels& instruments, int threads) {
    if (accuracy == scenes::ArmAccuracy::kPerfect) return nullptr;
    return std::make_unique<InstrumentSights>(rig, instruments, sight_prior(accuracy), threads);
}

std::array<Vector3d, kArms> add_instruments(InstrumentSights* sights, const ArmReadings& arms,
                                            tracker::StereoFrame& frame) {
    if (sights) sights->look(frame.left, frame.right, arms);
    std::array<Vector3d, kArms> grips_C;
    for (int arm = 0; arm < kArms; ++arm) {
        const ArmReading& reading = arms[static_cast<size_t>(arm)];
        const auto capsules = sights ? (*sights)[arm].capsules_C() : reading.capsules_C();
        frame.instruments.insert(frame.instruments.end(), capsules.begin(), capsules.end());
        grips_C[static_cast<size_t>(arm)] =
            sights ? (*sights)[arm].X_CT() * reading.psm->tool().X_TG.translation() : reading.grip_C();
    }
    return grips_C;
}

}  // namespace atropos::experiments
