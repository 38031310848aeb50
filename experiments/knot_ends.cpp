#include "experiments/knot_ends.hpp"

namespace atropos::experiments {
using tracker::MeasuredTip;

void KnotEnds::place(tracker::StereoFrame& frame) const {
    for (size_t end : {0, 1})
        if (frame.tips[end] && frame.tips[end]->kind == MeasuredTip::Kind::kFixed && held_C_[end])
            frame.tips[end]->p_C = *held_C_[end];
}

void KnotEnds::learn(const tracker::StereoFrame& frame, const scenes::ThreadEstimate& estimate) {
    if (estimate.samples.empty()) return;
    for (size_t end : {0, 1})
        if (frame.tips[end] && frame.tips[end]->kind == MeasuredTip::Kind::kHeld)
            held_C_[end] = end == 0 ? estimate.samples.front().p_C : estimate.samples.back().p_C;
}

}  // namespace atropos::experiments
