#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <memory>

#include "experiments/commands.hpp"
#include "experiments/cost_estimate.hpp"
#include "experiments/exit_status.hpp"
#include "experiments/experiment_job.hpp"
#include "experiments/experiment_plan.hpp"
#include "experiments/experiment_report.hpp"
#include "experiments/job_pool.hpp"
#include "experiments/output_folder.hpp"
#include "experiments/progress_meter.hpp"
#include "experiments/result_tables.hpp"
#include "scenes/file_error.hpp"
#include "scenes/text_file.hpp"

namespace atropos::experiments {
namespace fs = std::filesystem;
using scenes::FileError;
namespace {

struct ExperimentOptions {
    std::string file, output, shard, keep = "none";
    int jobs = 1;
    bool resume = false, dry_run = false, retry_failed = false;
    CommonOptions common;
};

/// "2/8": the second of eight parts.
struct Shard {
    std::size_t part = 1, of = 1;
};

Shard parse_shard(const std::string& text) {
    if (text.empty()) return {};
    const std::size_t slash = text.find('/');
    const auto part = scenes::parse_integer(text.substr(0, slash)),
               of = slash == std::string::npos ? std::nullopt : scenes::parse_integer(text.substr(slash + 1));
    if (!part || !of || *part < 1 || *of < *part || *of > 1'000'000)
        throw FileError("--shard " + text, "expected I/N with I from 1 to N");
    return {static_cast<std::size_t>(*part), static_cast<std::size_t>(*of)};
}

/// Keeps others out of a folder for as long as it lives, and goes with the process, however that ends.
class FolderLock {
  public:
    explicit FolderLock(const fs::path& folder)
        : file_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
        if (file_ < 0)
            throw FileError(folder.string(), std::string("can't be opened: ") + std::strerror(errno));
        if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
            ::close(file_);
            throw FileError(folder.string(),
                            "another experiment is at work here, expected a folder of its own");
        }
    }
    ~FolderLock() { ::close(file_); }
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

  private:
    int file_;
};

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw FileError(folder.string(), "can't be made: " + error.message());
}

/// What an interrupted run left half done.
void remove_leftovers(const fs::path& folder) {
    if (!fs::is_directory(folder)) return;
    std::vector<fs::path> leftovers;
    for (const auto& entry : fs::directory_iterator(folder))
        if (entry.path().extension() == ".partial" || entry.path().extension() == ".log" ||
            entry.path().extension() == ".tmp")
            leftovers.push_back(entry.path());
    for (const fs::path& path : leftovers) fs::remove_all(path);
}

/// Places the manifest, or checks that it is the one that stands there.
void prepare(const fs::path& folder, const std::string& manifest, const ExperimentOptions& options) {
    const fs::path file = folder / "experiment.json";
    if (options.resume && fs::exists(file)) {
        if (scenes::read_text_file(file, std::size_t{1} << 30) != manifest)
            throw FileError(file.string(),
                            "belongs to another experiment file, expected the same one or --force");
    } else {
        if (!options.resume) check_output(folder, options.common.force);
        if (options.resume && fs::exists(folder) && !fs::is_empty(folder))
            remove_leftovers(folder);  // killed before the manifest was whole
        else
            fs::remove_all(folder);
        make_folder(folder);
        write_file(folder / "experiment.json.tmp", manifest);
        fs::rename(folder / "experiment.json.tmp", file);
    }
    for (const char* name : {"jobs", "sequences"}) {
        make_folder(folder / name);
        remove_leftovers(folder / name);
    }
    remove_leftovers(folder);
}

/// Runs the jobs of a shard: those of one sequence after it is there, as many at once as the pool takes.
class Batch {
  public:
    Batch(const ExperimentPlan& plan, const ExperimentOptions& options, Shard shard)
        : plan_(plan), folder_(options.output), pool_(options.jobs), quiet_(options.common.quiet) {
        keep_ = options.keep == "all"        ? Keep::kAll
                : options.keep == "failures" ? Keep::kFailures
                                             : Keep::kNone;
        long pending = 0;
        for (std::size_t i = 0, group = 0; i < plan_.jobs.size(); ++i) {
            const bool begins = i == 0 || plan_.jobs[i].sequence_id != plan_.jobs[i - 1].sequence_id;
            if (begins && i > 0) ++group;
            if (group % shard.of != shard.part - 1) continue;
            if (groups_.empty() || groups_.back().sequence != plan_.jobs[i].sequence_id)
                groups_.push_back({plan_.jobs[i].sequence_id, {}, 0});
            if (is_done(plan_.jobs[i].id, options.retry_failed)) continue;
            groups_.back().jobs.push_back(i);
            ++pending;
        }
        meter_ = std::make_unique<ProgressMeter>("experiment", pending, quiet_);
    }

    /// Throws std::invalid_argument when input or environment stop it; what is finished stays.
    void run() {
        while (true) {
            while (pool_.has_room() && problem_.empty() && start_next()) {
            }
            if (pool_.is_idle()) break;
            pool_.wait();
        }
        if (!problem_.empty()) throw std::invalid_argument(problem_);
        std::error_code error;
        fs::remove(folder_ / "sequences", error);  // only when empty
    }

  private:
    struct Group {
        std::string sequence;
        std::vector<std::size_t> jobs;  ///< still to do
        std::size_t finished;
    };

    fs::path job_folder(const std::string& id) const { return folder_ / "jobs" / id; }
    fs::path sequence_folder(const Group& group) const { return folder_ / "sequences" / group.sequence; }

    bool is_done(const std::string& id, bool retry_failed) const {
        const fs::path result = job_folder(id) / "result.json";
        if (!fs::exists(result)) return false;
        return !retry_failed ||
               scenes::read_text_file(result, 1 << 20).find("\"status\": \"failed\"") == std::string::npos;
    }

    /// False when there is nothing to start now.
    bool start_next() {
        if (!ready_.empty()) {
            const auto [group, job] = ready_.front();
            ready_.pop_front();
            start_job(group, job);
            return true;
        }
        if (next_group_ == groups_.size()) return false;
        Group& group = groups_[next_group_++];
        if (group.jobs.empty()) {
            drop_sequence(group);
        } else if (plan_.jobs[group.jobs.front()].kind == JobSpec::Kind::kRun ||
                   fs::exists(sequence_folder(group))) {
            release(group);
        } else {
            start_sequence(group);
        }
        return true;
    }

    void release(Group& group) {
        for (const std::size_t job : group.jobs) ready_.emplace_back(&group, job);
    }

    void start_sequence(Group& group) {
        const JobSpec& job = plan_.jobs[group.jobs.front()];
        const fs::path folder = sequence_folder(group);
        pool_.start(
            [&job, folder] {
                make_sequence(job, folder);
                return static_cast<int>(kDone);
            },
            plan_.timeout_s, fs::path(folder) += ".log",
            [this, &group, folder](const TaskEnd& end) {
                if (stops(end)) return;
                if (end.kind == TaskEnd::Kind::kDone) return release(group);
                fs::remove_all(fs::path(folder) += ".partial");
                for (const std::size_t job_index : group.jobs)
                    fail(group, job_index, "its sequence: " + end.reason);
            });
    }

    void start_job(Group* group, std::size_t index) {
        const JobSpec& job = plan_.jobs[index];
        const fs::path folder = job_folder(job.id), sequence = sequence_folder(*group);
        pool_.start(
            [&job, folder, sequence, keep = keep_] {
                do_job(job, sequence, folder, keep);
                return static_cast<int>(kDone);
            },
            plan_.timeout_s, fs::path(folder) += ".log",
            [this, group, index](const TaskEnd& end) {
                if (stops(end)) return;
                if (end.kind == TaskEnd::Kind::kDone)
                    finish(*group);
                else
                    fail(*group, index, end.reason);
            });
    }

    bool stops(const TaskEnd& end) {
        if (end.kind == TaskEnd::Kind::kBadInput && problem_.empty()) problem_ = end.reason;
        return end.kind == TaskEnd::Kind::kBadInput;
    }

    void fail(Group& group, std::size_t index, const std::string& reason) {
        const JobSpec& job = plan_.jobs[index];
        write_failure(job, reason, job_folder(job.id));
        if (!quiet_) fmt::print(stderr, "job {} failed: {}\n", job.id, reason);
        finish(group);
    }

    void finish(Group& group) {
        meter_->advance();
        if (++group.finished == group.jobs.size()) drop_sequence(group);
    }

    void drop_sequence(const Group& group) const {
        std::error_code error;
        if (keep_ != Keep::kAll) fs::remove_all(sequence_folder(group), error);
    }

    const ExperimentPlan& plan_;
    fs::path folder_;
    JobPool pool_;
    bool quiet_;
    Keep keep_ = Keep::kNone;
    std::deque<Group> groups_;
    std::size_t next_group_ = 0;
    std::deque<std::pair<Group*, std::size_t>> ready_;
    std::string problem_;
    std::unique_ptr<ProgressMeter> meter_;
};

int finish_tables(const fs::path& folder) {
    const ExperimentResults results = read_results(folder);
    write_tables(results, folder);
    write_report(results, folder);
    fmt::print("{}", markdown_tables(results));
    return results.failed() > 0 ? kNegative : kDone;
}

int experiment(const ExperimentOptions& options) {
    const ExperimentPlan plan = load_experiment(options.file, options.common.all_overrides());
    const Shard shard = parse_shard(options.shard);
    if (options.dry_run) {
        fmt::print("{}", describe_cost(plan, options.jobs * static_cast<int>(shard.of)));
        return kDone;
    }
    if (options.output.empty()) throw FileError("-o", "no folder named, expected -o DIR");
    if (!options.resume) check_output(options.output, options.common.force);
    make_folder(options.output);
    const FolderLock lock(options.output);
    prepare(options.output, plan.manifest(), options);
    Batch(plan, options, shard).run();
    return finish_tables(options.output);
}

/// The files of a job by which two copies of it are compared.
void check_equal(const fs::path& a, const fs::path& b) {
    for (const char* name : {"result.json", "frames.csv"}) {
        if (!fs::exists(a / name) && !fs::exists(b / name)) continue;
        if (scenes::read_text_file(a / name, std::size_t{1} << 30) !=
            scenes::read_text_file(b / name, std::size_t{1} << 30))
            throw FileError((b / name).string(), "differs from " + (a / name).string() +
                                                     ", expected the same job to give the same");
    }
}

int merge(const std::vector<std::string>& parts, const std::string& target, bool force) {
    check_output(target, force);
    OutputFolder output(target, force);
    std::string manifest;
    make_folder(output.path() / "jobs");
    for (const std::string& part : parts) {
        const std::string theirs =
            scenes::read_text_file(fs::path(part) / "experiment.json", std::size_t{1} << 30);
        read_results(part);
        if (manifest.empty()) manifest = theirs;
        if (theirs != manifest)
            throw FileError(
                part, "belongs to another experiment than " + parts.front() + ", expected shards of one");
        for (const auto& entry : fs::directory_iterator(fs::path(part) / "jobs")) {
            if (!fs::exists(entry.path() / "result.json") || entry.path().extension() == ".partial") continue;
            const fs::path to = output.path() / "jobs" / entry.path().filename();
            if (fs::exists(to))
                check_equal(to, entry.path());
            else
                fs::copy(entry.path(), to, fs::copy_options::recursive);
        }
    }
    write_file(output.path() / "experiment.json", manifest);
    const int status = finish_tables(output.path());
    const std::size_t missing = read_results(output.path()).missing();
    output.commit();
    if (missing > 0) fmt::print(stderr, "{} jobs are in none of these folders\n", missing);
    return missing > 0 ? kNegative : status;
}

}  // namespace

void add_experiment_command(CLI::App& program, Command& chosen) {
    CLI::App* app = program.add_subcommand(
        "experiment", "a batch: base scene, alternatives, trackers, seeds; tables and plots");
    const auto options = std::make_shared<ExperimentOptions>();
    app->add_option("FILE", options->file, "experiment file (docs/experiments.md)")->required();
    app->add_option("-o,--output", options->output, "folder of the experiment");
    app->add_option("--jobs", options->jobs, "child processes at a time")->check(CLI::Range(1, 1024));
    app->add_option("--shard", options->shard, "only part I of N; `merge` puts the parts together")
        ->type_name("I/N");
    app->add_option("--keep", options->keep, "tracks and sequences to keep")
        ->check(CLI::IsMember({"none", "failures", "all"}));
    app->add_flag("--resume", options->resume, "go on where an interrupted run stopped");
    app->add_flag("--retry-failed", options->retry_failed, "with --resume: do failed jobs again");
    app->add_flag("--dry-run", options->dry_run, "say jobs, hours and gigabytes, do nothing");
    add_common_options(*app, options->common);
    app->footer("Example: atropos experiment experiments/table1.yaml -o results/table1 --jobs 2");
    app->callback([&chosen, options] { chosen = [options] { return experiment(*options); }; });
}

void add_merge_command(CLI::App& program, Command& chosen) {
    struct MergeOptions {
        std::vector<std::string> parts;
        std::string output;
        bool force = false;
    };
    CLI::App* app = program.add_subcommand("merge", "puts the shards of an experiment together");
    const auto options = std::make_shared<MergeOptions>();
    app->add_option("DIR", options->parts, "folders of `experiment --shard`")->required();
    app->add_option("-o,--output", options->output, "folder of the whole")->required();
    app->add_flag("--force", options->force, "replace a non-empty output folder");
    app->footer("Example: atropos merge results/part1 results/part2 -o results/table1");
    app->callback([&chosen, options] {
        chosen = [options] { return merge(options->parts, options->output, options->force); };
    });
}

}  // namespace atropos::experiments
