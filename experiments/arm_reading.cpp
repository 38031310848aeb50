#include "experiments/arm_reading.hpp"

namespace atropos::experiments {

std::vector<scenes::Capsule> ArmReading::capsules_C() const {
    auto capsules = psm->capsules(measured.q, measured.jaw_rad);
    for (scenes::Capsule& c : capsules) c = {X_CB * c.a, X_CB * c.b, c.radius_m};
    return capsules;
}

ArmReading read(const robot::RobotArm& arm) {
    return {&arm.psm(), arm.X_CB(), arm.measured().value};
}

}  // namespace atropos::experiments
