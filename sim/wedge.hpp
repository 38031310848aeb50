#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "sim/thread_dynamics.hpp"

namespace atropos::sim {

/// The room between two jaws or two blades that open by `opening_rad` about the axis y of their frame F, the
/// pin at -z: what lies in it cannot leave through them, however fast they close.
struct Wedge {
    Eigen::Isometry3d X_WF = Eigen::Isometry3d::Identity();
    double opening_rad = 0.0;
    double pin_to_origin_m = 0.0;
    double root_m = 0.0;
    double length_m = 0.0;
    double half_width_m = 0.0;  ///< along y

    /// Half the room at distance `r_m` from the pin.
    double half_gap_m(double r_m) const;
    double from_pin_m(const Eigen::Vector3d& p_F) const { return p_F.z() + pin_to_origin_m; }
    /// Beside neither face, not past tip or root; whatever its x.
    bool spans(const Eigen::Vector3d& p_F) const;
};

/// Where the thread passes the wedge.
struct WedgePassage {
    int edge;
    double t;  ///< on the edge
    double s_m;
    Eigen::Vector3d p_F;
};

/// Keeps track of what is between a pair of jaws (or blades) and makes their faces hold it there.
class WedgeTrap {
  public:
    /// Thread that passes the wedge now: for jaws sampled over their width, for blades where it crosses their
    /// plane.
    static std::vector<WedgePassage> passages(const Wedge& wedge, const ThreadState& state, bool blades);

    /// Brings the list of trapped thread up to date with the wedge as it stands now.
    void update(const Wedge& wedge, const ThreadState& state, double radius_m, bool blades);
    const std::vector<WedgePassage>& trapped() const { return trapped_; }
    void clear() { trapped_.clear(); }

    /// Contacts of the trapped thread with both faces, which moved from `before` to `now` in `dt_s`.
    void add_contacts(const Wedge& before, const Wedge& now, const ThreadState& state, double dt_s,
                      double friction, int body, std::vector<SurfaceContact>& contacts) const;

  private:
    std::vector<WedgePassage> trapped_;
};

}  // namespace atropos::sim
