#include "tracker/stereo_cost_images.hpp"

namespace atropos::tracker {

StereoCostImages::StereoCostImages(const scenes::TrackerConfig& config, std::vector<double> sigmas_px,
                                   int truncation_px)
    : makers_{CostImageMaker(config, sigmas_px, truncation_px),
              CostImageMaker(config, sigmas_px, truncation_px)} {}

void StereoCostImages::begin(const StereoFrame& frame) {
    makers_[0].begin(frame.left);
    makers_[1].begin(frame.right);
}

void StereoCostImages::set_truncation(int truncation_px) {
    for (CostImageMaker& maker : makers_) maker.set_truncation(truncation_px);
}

void StereoCostImages::compute(scenes::WorkerPool& pool) {
    pool.run(2, [&](int eye) { makers_[static_cast<std::size_t>(eye)].compute(); });
}

void StereoCostImages::make(const StereoFrame& frame, scenes::WorkerPool& pool) {
    begin(frame);
    for (int eye = 0; eye < 2; ++eye) want(eye, {0, 0, frame.left.cols, frame.left.rows});
    compute(pool);
}

void StereoCostImages::show(TrackObserver& observer) const {
    for (int eye = 0; eye < 2; ++eye) {
        const CostImageMaker::Pictures pictures = makers_[static_cast<std::size_t>(eye)].pictures();
        observer.image("gray", eye, pictures.gray);
        observer.image("ridge", eye, pictures.ridge);
        observer.image("mask", eye, pictures.mask);
        observer.image("cost", eye, pictures.cost);
    }
}

}  // namespace atropos::tracker
