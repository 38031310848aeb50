#include <array>
#include <stdexcept>
#include <string>

#include "render/thread_ribbon.hpp"

namespace atropos::render {
namespace {

struct Dye {
    std::string_view name;
    Eigen::Vector3f colour;
};

const std::array<Dye, 5> kDyes = {{{"violet", {0.095f, 0.045f, 0.300f}},
                                   {"black", {0.013f, 0.013f, 0.015f}},
                                   {"blue", {0.020f, 0.085f, 0.330f}},
                                   {"undyed", {0.620f, 0.560f, 0.430f}},
                                   {"red", {0.330f, 0.018f, 0.022f}}}};

}  // namespace

ThreadLook thread_look(std::string_view colour, std::string_view surface) {
    ThreadLook look;
    std::string known;
    bool found = false;
    for (const Dye& dye : kDyes) {
        if (dye.name == colour) {
            look.colour = dye.colour;
            found = true;
        }
        known += (known.empty() ? "" : ", ") + std::string(dye.name);
    }
    if (!found) {
        throw std::invalid_argument("no thread colour '" + std::string(colour) + "', expected one of " +
                                    known);
    }
    if (surface == "monofilament") {
        look.surface = ThreadLook::Surface::kMonofilament;
        look.roughness = 0.24f;
    } else if (surface != "braided") {
        throw std::invalid_argument("no thread surface '" + std::string(surface) +
                                    "', expected braided or monofilament");
    }
    return look;
}

}  // namespace atropos::render
