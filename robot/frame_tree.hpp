#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace atropos::robot {

/// Named frames, each with a pose in its parent; the root is W, the world. The one place where poses of
/// different arms and cameras meet.
class FrameTree {
  public:
    /// Adds `frame` below `parent`, or moves it: `X_PF` is its pose in the parent. Throws
    /// std::invalid_argument when the parent is unknown, or when a known frame would change its parent.
    void set(std::string_view frame, std::string_view parent, const Eigen::Isometry3d& X_PF);

    /// X_AB: pose of frame `B` in frame `A`. Throws std::invalid_argument that lists the known frames.
    Eigen::Isometry3d pose(std::string_view A, std::string_view B) const;

    bool contains(std::string_view frame) const;
    std::vector<std::string> names() const;

  private:
    struct Node {
        std::string parent;
        Eigen::Isometry3d X_PF;
    };
    Eigen::Isometry3d in_world(std::string_view frame) const;

    std::map<std::string, Node, std::less<>> nodes_;
};

}  // namespace atropos::robot
