// What a refined tracker carries from one frame to the next.
#include <algorithm>
#include <stdexcept>
#include <string>

#include "tracker/refined_tracker.hpp"

namespace atropos::tracker {

// method_state: length and its sigma, how wrong predictions were, velocities, what is known of the ends,
// expected depths of the thread.
TrackerState RefinedTracker::state() const {
    TrackerState state;
    state.started = started_;
    state.status = status_;
    state.frames_unseen = frames_unseen_;
    state.capture_time_s = capture_time_s_;
    if (!started_) return state;
    state.control_points = curve_of(fit_.Q).control_points();
    state.method_state.resize(method_state_size());
    double* out = state.method_state.data();
    *out++ = expected_length_m_;
    *out++ = expected_length_sigma_m_;
    *out++ = length_refuted_ ? 1.0 : 0.0;
    *out++ = surprise_px_;
    out = std::copy_n(motion_.velocity_m_s.data(), motion_.velocity_m_s.size(), out);
    ends_.save(out);
    sight_.save(out + MeasuredEnds::kStateSize);
    if (eye_) eye_->save(out + MeasuredEnds::kStateSize + sight_.state_size());
    return state;
}

void RefinedTracker::restore(const TrackerState& state) {
    if (state.started && chooses_control_points())
        set_control_points(std::clamp(static_cast<int>(state.control_points.size()), 4, 64));
    const std::size_t K = static_cast<std::size_t>(refinement_.basis().count());
    if (state.started &&
        (state.control_points.size() != K || state.method_state.size() != method_state_size()))
        throw std::invalid_argument("a state of " + std::to_string(state.control_points.size()) +
                                    " control points and " + std::to_string(state.method_state.size()) +
                                    " numbers, expected one of this tracker with " + std::to_string(K) +
                                    " and " + std::to_string(method_state_size()));
    started_ = confirmed_ = state.started;
    status_ = state.status;
    frames_unseen_ = state.frames_unseen;
    capture_time_s_ = state.capture_time_s;
    if (!started_) return;
    for (std::size_t k = 0; k < K; ++k) fit_.Q.col(static_cast<int>(k)) = state.control_points[k];
    const double* in = state.method_state.data();
    expected_length_m_ = *in++;
    expected_length_sigma_m_ = *in++;
    length_refuted_ = *in++ != 0.0;
    surprise_px_ = *in++;
    std::copy_n(in, motion_.velocity_m_s.size(), motion_.velocity_m_s.data());
    in += motion_.velocity_m_s.size();
    ends_.load(in);
    sight_.load(in + MeasuredEnds::kStateSize);
    if (!eye_) return;
    eye_->load(in + MeasuredEnds::kStateSize + sight_.state_size());
    set_rig(eye_->found().correction.applied_to(given_rig_));
}

std::size_t RefinedTracker::method_state_size() const {
    return 4 + static_cast<std::size_t>(motion_.velocity_m_s.size()) + MeasuredEnds::kStateSize +
           sight_.state_size() + (eye_ ? EyeSight::kStateSize : 0);
}

}  // namespace atropos::tracker
