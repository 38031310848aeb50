#include "experiments/version.hpp"

namespace atropos::experiments {

std::string version_number() {
    return ATROPOS_VERSION;
}

std::string version_text() {
    return std::string("atropos " ATROPOS_VERSION " (" ATROPOS_BUILD_TYPE ", ") +
#if defined(__clang__)
           "clang " __clang_version__ +
#else
           "g++ " __VERSION__ +
#endif
           ")";
}

}  // namespace atropos::experiments
