#include <fmt/format.h>

#include <new>

#include "experiments/commands.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/version.hpp"
#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace {

using namespace atropos::experiments;

/// One line, whatever the message holds.
int complain(std::string what, int status) {
    for (char& c : what)
        if (c == '\n' || c == '\r') c = ' ';
    fmt::print(stderr, "atropos: {}\n", what);
    return status;
}

bool knows(const CLI::App& program, const std::string& word) {
    for (const CLI::App* command : program.get_subcommands({}))
        if (command->get_name() == word) return true;
    return false;
}

std::string unknown_command(const CLI::App& program, const std::string& word) {
    std::vector<std::string> known;
    for (const CLI::App* command : program.get_subcommands({})) known.push_back(command->get_name());
    const std::string nearest = atropos::scenes::nearest_word(word, known);
    return fmt::format("no command {}, {}", atropos::scenes::shown(word),
                       nearest.empty() ? fmt::format("expected one of {}", fmt::join(known, " "))
                                       : "nearest known is '" + nearest + "'");
}

int parse_and_run(int argc, char** argv) {
    CLI::App program{
        "Atropos: simulates da Vinci arms and a suture thread, tracks the thread in stereo images, cuts it."};
    program.name("atropos");
    program.set_version_flag("--version", version_text());
    program.require_subcommand(1);
    program.footer("Example: atropos info --cameras\n`atropos COMMAND --help` tells more.");
    Command chosen;
    add_run_command(program, chosen);
    add_generate_command(program, chosen);
    add_render_command(program, chosen);
    add_track_command(program, chosen);
    add_evaluate_command(program, chosen);
    add_experiment_command(program, chosen);
    add_merge_command(program, chosen);
    add_check_command(program, chosen);
    add_replay_command(program, chosen);
    add_report_command(program, chosen);
    add_figure_command(program, chosen);
    add_learn_prior_command(program, chosen);
    add_import_command(program, chosen);
    add_info_command(program, chosen);
    if (argc > 1 && argv[1][0] != '-' && !knows(program, argv[1]))
        return complain(unknown_command(program, argv[1]), kBadInput);
    try {
        program.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return program.exit(success);  // --help, --version
    } catch (const CLI::ParseError& error) {
        return complain(std::string(error.what()) + " (see atropos --help)", kBadInput);
    }
    return chosen();
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return parse_and_run(argc, argv);
    } catch (const atropos::scenes::FileError& error) {
        return complain(error.what(), kBadInput);
    } catch (const std::invalid_argument& error) {
        return complain(error.what(), kBadInput);
    } catch (const std::bad_alloc&) {
        return complain("out of memory", kBadInput);
    } catch (const std::exception& error) {
        return complain(std::string("internal error: ") + error.what(), kInternal);
    }
}
