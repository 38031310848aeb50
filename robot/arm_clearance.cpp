#include "robot/arm_clearance.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace atropos::robot {
namespace {

// How far any point of a group can be from its place at the nearer end of the interval: half of the longest
// way of an end point. Instruments turn about points far away, so that ways between samples are nearly
// straight; a tenth more covers their bow.
double half_way_m(const Capsules& from, const Capsules& to) {
    assert(from.size() == to.size());
    double longest = 0.0;
    for (size_t i = 0; i < from.size(); ++i)
        longest = std::max({longest, (from[i].a - to[i].a).norm(), (from[i].b - to[i].b).norm()});
    return 0.55 * longest;
}

struct Sample {
    double at;
    Capsules first, second;
    double clearance;
};

struct Search {
    const MovingCapsules& first;
    const MovingCapsules& second;
    double tolerance;
    double enough;

    Sample sample(double at) const {
        Sample s{at, first(at), second(at), 0.0};
        s.clearance = clearance_m(s.first, s.second);
        return s;
    }

    Sweep least(const Sample& from, const Sample& to, int depth) const {
        const Sample& nearer = from.clearance <= to.clearance ? from : to;
        const double cost = half_way_m(from.first, to.first) + half_way_m(from.second, to.second);
        if (depth > 0 && (cost <= tolerance || depth >= 24 || nearer.clearance - cost >= enough))
            return {nearer.clearance - cost, nearer.at};
        const Sample middle = sample(0.5 * (from.at + to.at));
        const Sweep a = least(from, middle, depth + 1), b = least(middle, to, depth + 1);
        return a.clearance_m <= b.clearance_m ? a : b;
    }
};

}  // namespace

double clearance_m(const Capsules& first, const Capsules& second) {
    double least = std::numeric_limits<double>::infinity();
    for (const scenes::Capsule& a : first)
        for (const scenes::Capsule& b : second) least = std::min(least, scenes::clearance_m(a, b));
    return least;
}

// Quarters first, so that a motion that returns to its beginning is seen.
Sweep swept_clearance(const MovingCapsules& first, const MovingCapsules& second, double tolerance_m,
                      double enough_m) {
    const Search search{first, second, tolerance_m, enough_m};
    Sweep best{std::numeric_limits<double>::infinity(), 0.0};
    Sample from = search.sample(0.0);
    for (int i = 1; i <= 4; ++i) {
        Sample to = search.sample(0.25 * i);
        const Sweep part = search.least(from, to, 0);
        if (part.clearance_m < best.clearance_m) best = part;
        from = std::move(to);
    }
    return best;
}

}  // namespace atropos::robot
