// The finder on real, rendered and generated frames, as Markdown:
// `finder_table [--data FOLDER] [--only KIND] [--frames N] [--pictures FOLDER]`.
#include <CLI/CLI.hpp>
#include <cstdlib>

#include "tests/bench/finder_cases.hpp"

int main(int argc, char** argv) {
    CLI::App program("the finder on real, rendered and generated frames");
    atropos::bench::FinderTableOptions options;
    if (const char* data = std::getenv("ATROPOS_DATA")) options.data = data;
    std::string only;
    program.add_option("--data", options.data, "folder that holds stereo-pairs/ (default: $ATROPOS_DATA)");
    program.add_option("--pictures", options.pictures, "folder for the curves drawn over the images");
    program.add_option("--frames", options.frames, "of each generated kind")->capture_default_str();
    program.add_option("--first-seed", options.first_seed)->capture_default_str();
    program.add_option("--only", only)
        ->check(CLI::IsMember({"real", "sim", "generated", "rendered", "pad", "track"}));
    program.add_flag("--verbose", options.verbose, "a line for each frame that is wrong or doubted");
    CLI11_PARSE(program, argc, argv);
    const auto wanted = [&](const char* kind) { return only.empty() || only == kind; };
    if (wanted("real")) print_real_pairs(options);
    if (wanted("sim")) print_rendered_pairs(options);
    if (wanted("generated")) print_generated(options);
    if (wanted("rendered")) print_rendered(options);
    if (wanted("pad")) print_on_pad(options);
    if (wanted("track")) print_tracked(options);
}
