#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/support/tracking_trial.hpp"

namespace {
std::atomic<long> allocations{0};
}

// Every allocation of the program is counted; the C library's own names for it are kept.
void* operator new(std::size_t size) {
    ++allocations;
    if (void* p = std::malloc(size)) return p;
    throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
    ++allocations;
    const std::size_t a = static_cast<std::size_t>(alignment);
    if (void* p = std::aligned_alloc(a, (size + a - 1) / a * a)) return p;
    throw std::bad_alloc();
}
void operator delete(void* p) noexcept {
    std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
    std::free(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
    std::free(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
    std::free(p);
}

namespace atropos::tracker {
namespace {

TEST(ThreadTracker, allocates_nothing_after_the_first_frame) {
    const scenes::StereoRig rig = scenes::parallel_rig(320, 180, 287.5, 0.005);
    const support::SyntheticSequence sequence({.seed = 7, .rig = rig});
    std::vector<StereoFrame> frames;
    std::vector<support::SyntheticFrame> drawn;
    for (int i = 0; i < 4; ++i) {
        drawn.push_back(sequence.frame(5 * i));
        frames.push_back(support::stereo_frame(drawn.back(), i));
    }
    for (const auto method : {scenes::TrackerMethod::kE1, scenes::TrackerMethod::kE2})
        for (const int threads : {1, 2}) {
            scenes::TrackerConfig config;
            config.method = method;
            config.threads = threads;
            const auto tracker = make_tracker(config, rig);
            tracker->start(frames[0], fit_curve(drawn[0].truth_C, {.length_weight = 1.0}));
            const long before = allocations;
            for (const StereoFrame& frame : frames) tracker->track(frame);
            EXPECT_EQ(allocations - before, 0);
        }
}

}  // namespace
}  // namespace atropos::tracker
