#pragma once

namespace atropos::experiments {

/// The Python files that are written into each dataset, from experiments/python/.
extern const char* const kAtroposNumpyPy;
extern const char* const kAtroposTorchPy;

}  // namespace atropos::experiments
