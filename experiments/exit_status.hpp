#pragma once

namespace atropos::experiments {

/// What the program's end says to scripts.
enum ExitStatus : int {
    kDone = 0,
    kNegative = 1,  ///< a verdict is negative, a comparison unequal, or a job failed
    kBadInput = 2,  ///< usage, input or environment
    kInternal = 3,
};

}  // namespace atropos::experiments
