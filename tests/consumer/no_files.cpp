// Links the tracker and nothing for files: what this program needs is what the tracker costs.
#include <atropos/tracker/stereo_tracker.hpp>

int main() {
    const auto tracker =
        atropos::tracker::make_tracker({}, atropos::scenes::parallel_rig(640, 360, 575.0, 0.005));
    return tracker->state().started ? 1 : 0;
}
