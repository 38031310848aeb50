#pragma once

#include "sim/thread_material.hpp"

namespace atropos::sim {

enum class ThreadModel {
    kRod,         ///< implicit discrete elastic rod
    kBulletSoft,  ///< Bullet's own soft-body rope, as a second opinion
};

struct ThreadOptions {
    ThreadModel model = ThreadModel::kRod;
    ThreadMaterial material = thread_material("silk", 0.25e-3);
    double diameter_m = 0.25e-3;
    /// Material length; 0 takes the length of the initial curve. The curve is scaled to it along its arc.
    double length_m = 0.0;
    int edges = 100;  ///< 140 where a knot is tied
    /// Memory: 1 over the radius to which it curls when free; 0 is straight. The rod only.
    double natural_curvature_per_m = 0.0;
    bool self_contact = true;
    double air_drag_N_s_m2 = 1e-4;       ///< force a metre of thread a m/s; assumed
    double surface_stiffness_N_m = 5e4;  ///< of one contact with tissue or an instrument
    int soft_iterations = 200;           ///< of Bullet's position solver, model kBulletSoft only
};

}  // namespace atropos::sim
