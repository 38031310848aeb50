#include "robot/frame_tree.hpp"

#include <stdexcept>

namespace atropos::robot {

void FrameTree::set(std::string_view frame, std::string_view parent, const Eigen::Isometry3d& X_PF) {
    if (!contains(parent))
        throw std::invalid_argument("frame '" + std::string(frame) + "' below unknown frame '" +
                                    std::string(parent) + "'");
    if (frame == "W") throw std::invalid_argument("frame W is the root, it has no parent");
    const auto found = nodes_.find(frame);
    if (found == nodes_.end()) {
        nodes_.emplace(std::string(frame), Node{std::string(parent), X_PF});
        return;
    }
    if (found->second.parent != parent)
        throw std::invalid_argument("frame '" + std::string(frame) + "' is below '" + found->second.parent +
                                    "', not below '" + std::string(parent) + "'");
    found->second.X_PF = X_PF;
}

Eigen::Isometry3d FrameTree::in_world(std::string_view frame) const {
    Eigen::Isometry3d X_WF = Eigen::Isometry3d::Identity();
    while (frame != "W") {
        const auto found = nodes_.find(frame);
        if (found == nodes_.end()) {
            std::string known = "W";
            for (const auto& [name, node] : nodes_) known += ", " + name;
            throw std::invalid_argument("no frame '" + std::string(frame) + "', expected one of " + known);
        }
        X_WF = found->second.X_PF * X_WF;
        frame = found->second.parent;
    }
    return X_WF;
}

Eigen::Isometry3d FrameTree::pose(std::string_view A, std::string_view B) const {
    return in_world(A).inverse() * in_world(B);
}

bool FrameTree::contains(std::string_view frame) const {
    return frame == "W" || nodes_.find(frame) != nodes_.end();
}

std::vector<std::string> FrameTree::names() const {
    std::vector<std::string> all = {"W"};
    for (const auto& [name, node] : nodes_) all.push_back(name);
    return all;
}

}  // namespace atropos::robot
