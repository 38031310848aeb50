#pragma once

#include "sim/hanging_curve.hpp"

namespace atropos::sim {

/// A smooth curve of `length_m` from `first` to `last` with a loose overhand knot in its middle, hanging as
/// far down as the length allows: a first guess for `World::settle`. The knot is the polynomial trefoil
/// (t^3 - 3t, t^4 - 4t^2, t^5/5 - 2t). Throws std::invalid_argument when the length is too short for it.
scenes::Polyline knotted_curve(const CurveEnd& first, const CurveEnd& last, double length_m);

}  // namespace atropos::sim
