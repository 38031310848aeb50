// Curves found from the straight line between both ends, the length given.
#include <cstdio>
#include <vector>

#include "scenes/random_stream.hpp"
#include "tests/bench/tracker_tables.hpp"
#include "tests/support/table_cases.hpp"

namespace atropos::bench {

int print_start_table(int curves) {
    constexpr double kWithin_px = 2.0;
    constexpr double kBins[5] = {0.75, 0.80, 0.85, 0.90, 0.95};
    int tried[4] = {}, within[4] = {}, none[4] = {};
    for (int i = 0; i < curves; ++i) {
        const int bin = i % 4;
        scenes::RandomStream random(static_cast<std::uint64_t>(i), "chord");
        const double ratio = random.uniform(kBins[bin], kBins[bin + 1]);
        const std::optional<double> error_px = support::error_from_straight_line_px(
            support::start_options(1000 + static_cast<std::uint64_t>(i), ratio));
        ++tried[bin];
        within[bin] += error_px && *error_px <= kWithin_px;
        none[bin] += !error_px;
        if (!error_px || *error_px > kWithin_px)
            std::fprintf(stderr, "curve %d, chord %.3f of the length: %s\n", i, ratio,
                         error_px ? (std::to_string(*error_px) + " px").c_str() : "none found");
    }
    std::printf("| chord over length | curves | within 2 px | none found |\n|---|---|---|---|\n");
    int all = 0;
    for (int bin = 0; bin < 4; ++bin) {
        std::printf("| %.2f-%.2f | %d | %d | %d |\n", kBins[bin], kBins[bin + 1], tried[bin], within[bin],
                    none[bin]);
        all += within[bin];
    }
    const double percent = 100.0 * all / curves;
    std::printf("\n- %d of %d within 2 px, %.1f %%, bound 95 %%: %s\n", all, curves, percent,
                percent >= 95.0 ? "met" : "not met");
    return percent >= 95.0 ? 0 : 1;
}

}  // namespace atropos::bench
