#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "experiments/prior_file.hpp"
#include "scenes/file_error.hpp"

// Any bytes are a learned prior or one clear error; what is a prior reads back equal.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace atropos;
    try {
        const tracker::DeformationPrior prior = experiments::parse_deformation_prior(
            "fuzz", std::string(reinterpret_cast<const char*>(data), size));
        const std::string text = experiments::to_json_text(prior);
        if (experiments::to_json_text(experiments::parse_deformation_prior("again", text)) != text)
            throw std::logic_error("not equal when read back");
    } catch (const scenes::FileError&) {
    }
    return 0;
}
