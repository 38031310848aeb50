#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

// Reads the include lines of the tree: a folder may include only what stands to its right in
// CONTRIBUTING.md's table.
namespace atropos {
namespace {
namespace fs = std::filesystem;

using Folders = std::set<std::string>;
const std::map<std::string, Folders> kMayInclude = {
    {"scenes", {"scenes"}},
    {"tracker", {"scenes", "tracker"}},
    {"robot", {"scenes", "robot"}},
    {"sim", {"scenes", "robot", "sim"}},
    {"render", {"scenes", "render"}},
    {"experiments", {"scenes", "tracker", "robot", "sim", "render", "experiments"}},
};

/// Headers that only one folder may include, by their beginning.
const std::map<std::string, std::string> kOnlyIn = {
    {"bullet/", "sim"},         {"btBullet", "sim"},        {"BulletCollision/", "sim"},
    {"BulletDynamics/", "sim"}, {"BulletSoftBody/", "sim"}, {"LinearMath/", "sim"},
    {"GL/", "render"},          {"EGL/", "render"},         {"assimp/", "render"},
};

std::string breach(const std::string& folder, const std::string& header) {
    const std::string top = header.substr(0, header.find('/'));
    if (kMayInclude.contains(top) && !kMayInclude.at(folder).contains(top))
        return "may not include " + top + "/";
    if (top == "tests") return "may not include tests/";
    for (const auto& [beginning, owner] : kOnlyIn)
        if (header.starts_with(beginning) && folder != owner)
            return header + " belongs to " + owner + "/ alone";
    if (header.starts_with("opencv2/") && folder == "tracker" &&
        !std::regex_match(header, std::regex("opencv2/(core|imgproc)(/.*|\\.hpp)")))
        return "tracker uses OpenCV's core and imgproc alone";
    if ((header.starts_with("opencv2/") || header.starts_with("yaml-cpp/")) && folder == "robot")
        return "robot uses Eigen alone";
    return "";
}

TEST(DependencyRule, holds_for_every_include_line) {
    const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
    int lines = 0;
    for (const auto& [folder, allowed] : kMayInclude)
        for (const auto& entry : fs::recursive_directory_iterator(fs::path(ATROPOS_SOURCE_DIR) / folder)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".hpp" && extension != ".cpp") continue;
            std::ifstream file(entry.path());
            std::string line;
            std::smatch match;
            while (std::getline(file, line))
                if (std::regex_search(line, match, include)) {
                    ++lines;
                    EXPECT_EQ(breach(folder, match[1]), "") << entry.path() << ": " << line;
                }
        }
    EXPECT_GT(lines, 50) << "the tree was not found";
}

TEST(DependencyRule, would_notice_a_breach) {
    EXPECT_NE(breach("tracker", "sim/world.hpp"), "");
    EXPECT_NE(breach("render", "robot/psm.hpp"), "");
    EXPECT_NE(breach("experiments", "btBulletDynamicsCommon.h"), "");
    EXPECT_NE(breach("tracker", "opencv2/calib3d.hpp"), "");
    EXPECT_EQ(breach("tracker", "opencv2/imgproc.hpp"), "");
    EXPECT_EQ(breach("sim", "robot/psm.hpp"), "");
}

}  // namespace
}  // namespace atropos
