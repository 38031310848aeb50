#include <gmock/gmock.h>
#include <unistd.h>

#include <map>
#include <set>
#include <thread>

#include "experiments/experiment_plan.hpp"
#include "experiments/folder_comparison.hpp"
#include "experiments/job_pool.hpp"
#include "experiments/result_tables.hpp"
#include "scenes/file_error.hpp"
#include "scenes/scene_file.hpp"
#include "tests/experiments/temporary_folder.hpp"

namespace atropos::experiments {
namespace {
namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ExperimentPlanTest : public TemporaryFolder {
  protected:
    ExperimentPlanTest() { write("base.yaml", "duration_s: 1\n"); }
    ExperimentPlan plan(const std::string& text) {
        return load_experiment(write("e.yaml", "scene: base.yaml\n" + text), {});
    }
    std::string error(const std::string& text) {
        try {
            plan(text);
        } catch (const scenes::FileError& e) {
            return e.what();
        }
        return "no error";
    }
};
class ResultTablesTest : public TemporaryFolder {};
class JobPoolTest : public TemporaryFolder {};
class FolderComparisonTest : public TemporaryFolder {};

TEST_F(ExperimentPlanTest, crosses_the_grid_with_trackers_and_seeds) {
    const ExperimentPlan p = plan(
        "grid: {accel: [1, 2, 5], arms.accuracy: [perfect, calibrated]}\n"
        "trackers: [e1, e2]\nseeds: 3\nset: {tracker: {K: 9}}\n");
    EXPECT_EQ(p.jobs.size(), 36u);
    EXPECT_EQ(p.cells.size(), 36u);
    std::set<std::string> sequences, ids;
    for (const JobSpec& job : p.jobs) {
        sequences.insert(job.sequence_id);
        ids.insert(job.id);
        EXPECT_EQ(job.scene.tracking.tracker.curve.control_points, 9);
    }
    EXPECT_EQ(ids.size(), 36u);
    EXPECT_EQ(sequences.size(), 6u) << "trackers and accelerations share pictures";
    for (const Cell& cell : p.cells) {
        const JobSpec& job = p.jobs[cell.job];
        EXPECT_EQ(std::to_string(job.accel), cell.levels.at("accel"));
        EXPECT_EQ(job.scene.seed, cell.seed);
        EXPECT_EQ(job.scene.tracking.tracker.method == scenes::TrackerMethod::kE1,
                  cell.levels.at("tracker") == "e1");
        EXPECT_EQ(job.scene.arms.accuracy == scenes::ArmAccuracy::kPerfect,
                  cell.levels.at("arms.accuracy") == "perfect");
    }
}

TEST_F(ExperimentPlanTest, keeps_the_jobs_of_a_sequence_together) {
    const ExperimentPlan p = plan("grid: {tracker.K: [6, 8]}\nseeds: [4, 9]\n");
    ASSERT_EQ(p.jobs.size(), 4u);
    EXPECT_EQ(p.jobs[0].sequence_id, p.jobs[1].sequence_id);
    EXPECT_EQ(p.jobs[2].sequence_id, p.jobs[3].sequence_id);
    EXPECT_NE(p.jobs[0].sequence_id, p.jobs[2].sequence_id);
}

TEST_F(ExperimentPlanTest, takes_lists_of_alternatives_one_at_a_time) {
    const ExperimentPlan p = plan(
        "list:\n- {name: base}\n- {name: slack, set: {thread.length_mm: 80}}\n"
        "- {name: points, vary: {tracker.K: [6, 10]}}\n");
    ASSERT_EQ(p.cells.size(), 4u);
    EXPECT_EQ(p.cells[1].levels.at("case"), "slack");
    EXPECT_DOUBLE_EQ(p.jobs[p.cells[1].job].scene.thread.length_m, 0.080);
    EXPECT_EQ(p.cells[3].levels.at("value"), "10");
    EXPECT_EQ(p.jobs[p.cells[3].job].scene.tracking.tracker.curve.control_points, 10);
    EXPECT_DOUBLE_EQ(p.jobs[p.cells[3].job].scene.thread.length_m, 0.070);
}

TEST_F(ExperimentPlanTest, does_a_job_once_that_stands_in_two_cells) {
    const ExperimentPlan p = plan("list:\n- {name: base}\n- {name: K, vary: {tracker.K: [8, 9]}}\n");
    EXPECT_EQ(p.cells.size(), 3u);
    EXPECT_EQ(p.jobs.size(), 2u) << "K is 8 in the base, too";
}

TEST_F(ExperimentPlanTest, gives_a_job_an_id_by_what_it_is_not_by_how_it_is_written) {
    const auto id = [&](const std::string& text) { return plan(text).jobs.front().id; };
    EXPECT_EQ(id("set: {tracker: {K: 9}}\n"), id("set: {tracker.K: 9}\nname: other\n"));
    EXPECT_NE(id("set: {tracker.K: 9}\n"), id("set: {tracker.K: 10}\n"));
    EXPECT_NE(id("job: run\n"), id("job: track\n"));
    EXPECT_NE(id("trackers: {mine: {command: a}}\n"), id("trackers: {mine: {command: b}}\n"));
}

TEST_F(ExperimentPlanTest, names_the_line_of_what_is_wrong) {
    EXPECT_THAT(error("sceen: x\n"), HasSubstr("e.yaml:2: unknown key 'sceen', nearest known is 'scene'"));
    EXPECT_THAT(error("grid: {thread.lenght_mm: [1]}\n"), HasSubstr("nearest known is 'length_mm'"));
    EXPECT_THAT(error("grid: {tracker.K: []}\n"), HasSubstr("e.yaml:2: tracker.K: expected a list"));
    EXPECT_THAT(error("\nseeds: 0\n"), HasSubstr("e.yaml:3: expected a number from 1"));
    EXPECT_THAT(error("trackers: [e9]\n"), HasSubstr("expected one of e1 e2 refined"));
    EXPECT_THAT(error("job: walk\n"), HasSubstr("expected track or run"));
    EXPECT_THAT(error("table: {rows: nothing}\n"), HasSubstr("no factor 'nothing'"));
    EXPECT_THAT(error("table: {metrics: [acuracy_3d_mm]}\n"), HasSubstr("nearest known is 'accuracy_3d_mm'"));
    EXPECT_THAT(error("set: {accel: 0}\n"), HasSubstr("expected a number from 1"));
}

TEST(CutScenes, are_the_shipped_scenes) {
    const ExperimentPlan p = load_experiment(ATROPOS_EXPERIMENTS "/cut_scenes.yaml", {});
    const std::map<std::string, std::string> files = {
        {"uncalibrated arms", "uncalibrated"}, {"occluded", "occluded"}, {"fast", "fast"},
        {"Bullet's soft rope", "bullet_soft"}, {"long", "long"},         {"paper", "paper"}};
    std::set<std::string> compared;
    for (const Cell& cell : p.cells) {
        const auto file = files.find(cell.levels.at("case"));
        if (file == files.end() || cell.seed != 1) continue;
        scenes::SceneConfig shipped =
            scenes::load_scene(ATROPOS_SCENES "/auto_scissors_" + file->second + ".yaml");
        const scenes::SceneConfig& ran = p.jobs[cell.job].scene;
        shipped.name = ran.name;
        EXPECT_EQ(scenes::to_yaml(ran), scenes::to_yaml(shipped)) << file->second;
        compared.insert(file->second);
    }
    EXPECT_EQ(compared.size(), files.size());
}

TEST(WilsonInterval, agrees_with_published_values) {
    // Newcombe 1998, table I: 81 of 263, 15 of 148, 0 of 20.
    EXPECT_NEAR(wilson_interval(81, 263).first, 0.2553, 5e-5);
    EXPECT_NEAR(wilson_interval(81, 263).second, 0.3662, 5e-5);
    EXPECT_NEAR(wilson_interval(15, 148).first, 0.0624, 5e-5);
    EXPECT_NEAR(wilson_interval(15, 148).second, 0.1605, 5e-5);
    EXPECT_NEAR(wilson_interval(0, 20).second, 0.1611, 5e-5);
}

TEST_F(ResultTablesTest, pool_seeds_by_frames_and_stand_beside_the_published_figures) {
    write("experiment.json", R"({"name":"t","title":"T","factors":{"accel":["1"],"tracker":["e1"]},"seeds":3,
        "jobs":[{"id":"a"},{"id":"b"},{"id":"c"},{"id":"d"}],
        "cells":[{"levels":{"accel":"1","tracker":"e1"},"job":"a"},{"levels":{"accel":"1","tracker":"e1"},"job":"b"},
                 {"levels":{"accel":"1","tracker":"e1"},"job":"c"},{"levels":{"accel":"1","tracker":"e1"},"job":"d"}],
        "table":{"rows":"accel","columns":"tracker","metrics":["tip_mm"]},
        "published":[{"levels":{"tracker":"e1"},"metric":"tip_mm","mean":0.47,"std":0.21}]})");
    const auto job = [&](const char* id, double mean, double std, int frames, int lost) {
        write(std::string("jobs/") + id + "/result.json",
              R"({"status":"done","metrics":{"tip_mm":{"mean":)" + std::to_string(mean) + R"(,"std":)" +
                  std::to_string(std) + R"(,"max":9},"frames":)" + std::to_string(frames) +
                  R"(,"lost_frames":)" + std::to_string(lost) +
                  R"(,"silent_failures":1,"failure_rate":0.25}})");
    };
    job("a", 1.0, 0.0, 12, 2);  // ten values of 1
    job("b", 3.0, 0.0, 30, 0);  // thirty of 3
    write("jobs/c/result.json", R"({"status":"failed","reason":"x"})");
    const ExperimentResults results = read_results(folder_);
    EXPECT_EQ(results.missing(), 1u);
    EXPECT_EQ(results.failed(), 1u);
    const std::vector<CellStatistics> cells = statistics(results);
    ASSERT_EQ(cells.size(), 1u);
    EXPECT_NEAR(cells[0].metrics.at("tip_mm").mean, 2.5, 1e-12);
    EXPECT_NEAR(cells[0].metrics.at("tip_mm").std, std::sqrt(0.75), 1e-12);
    EXPECT_EQ(cells[0].lost_frames, 2);
    EXPECT_EQ(cells[0].failed_jobs, 1);
    EXPECT_EQ(cells[0].missing_jobs, 1);
    const std::string text = markdown_tables(results);
    EXPECT_THAT(text, HasSubstr("| 1 | 2.5 ± 0.866 (paper 0.47 ± 0.21), 2 lost, 1 jobs failed |"));
    EXPECT_THAT(text, HasSubstr("unfinished: 1 of 4 jobs are missing"));
    write_tables(results, folder_);
    EXPECT_THAT(read(folder_ / "tables/cells.csv"),
                HasSubstr("1,e1,tip_mm,2.500000,0.866025,9.000000,0.47,0.21,42,2,2,1,1\n"));
    EXPECT_THAT(read(folder_ / "tables/t.tex"), HasSubstr("2.5 $\\pm$ 0.866 (paper 0.47 $\\pm$ 0.21)"));
    EXPECT_THAT(read(folder_ / "plots/tip_mm.csv"), HasSubstr("1,2.500000,0.866025\n"));
}

TEST_F(ResultTablesTest, refuse_files_changed_by_hand_in_one_line) {
    const auto error = [&] {
        try {
            read_results(folder_);
        } catch (const scenes::FileError& e) {
            return std::string(e.what());
        }
        return std::string("no error");
    };
    EXPECT_THAT(error(), HasSubstr("experiment.json: no such file"));
    write("experiment.json", "{");
    EXPECT_THAT(error(), HasSubstr("experiment.json: no JSON object"));
    write("experiment.json", R"({"jobs":[{"id":7}]})");
    EXPECT_THAT(error(), HasSubstr("experiment.json: a key is missing or of another type"));
    write("experiment.json",
          R"({"jobs":[{"id":"a"}],"cells":[],"table":{"rows":"","columns":"","metrics":[]},"published":[]})");
    EXPECT_EQ(error(), "no error");
    write("jobs/a/result.json", R"({"status":"done"})");
    EXPECT_THAT(error(), HasSubstr("a/result.json: a key is missing"));
}

TEST_F(JobPoolTest, tells_how_each_child_ended) {
    JobPool pool(2);
    std::map<std::string, TaskEnd> ends;
    const auto start = [&](const std::string& name, double timeout_s, const JobPool::Work& work) {
        if (!pool.has_room()) pool.wait();
        pool.start(work, timeout_s, folder_ / (name + ".log"),
                   [&ends, name](const TaskEnd& end) { ends[name] = end; });
    };
    start("good", 60, [] { return 0; });
    start("input", 60, []() -> int { throw scenes::FileError("a.png", "corrupt"); });
    start("throws", 60, []() -> int { throw std::runtime_error("no luck"); });
    start("dies", 60, []() -> int { abort(); });
    start("sleeps", 0.3, [] {
        sleep(100);
        return 0;
    });
    while (!pool.is_idle()) pool.wait();
    EXPECT_EQ(ends.at("good").kind, TaskEnd::Kind::kDone);
    EXPECT_EQ(ends.at("input").kind, TaskEnd::Kind::kBadInput);
    EXPECT_EQ(ends.at("input").reason, "a.png: corrupt");
    EXPECT_EQ(ends.at("throws").kind, TaskEnd::Kind::kFailed);
    EXPECT_EQ(ends.at("throws").reason, "no luck");
    EXPECT_EQ(ends.at("dies").reason, "ended by signal 6");
    EXPECT_EQ(ends.at("sleeps").reason, "took longer than 0.3 s");
    EXPECT_TRUE(fs::is_empty(folder_)) << "no logs stay";
}

TEST_F(FolderComparisonTest, says_first_differences_in_words) {
    const auto compare = [&](const Tolerances& t = {}) {
        return compare_folders(folder_ / "a", folder_ / "b", t, 3);
    };
    for (const char* side : {"a", "b"}) {
        write(std::string(side) + "/track.csv", "frame,x_mm\n0,1.5\n1,2\n");
        write(std::string(side) + "/meta.json", R"({"metrics":{"tip_mm":{"mean":2.0}},"name":"n"})");
        write(std::string(side) + "/timing.json", side);
        write(std::string(side) + "/sub/left.png", std::string("x\0y", 3));
    }
    EXPECT_THAT(compare(), IsEmpty());
    write("b/track.csv", "frame,x_mm\n0,1.6\n1,2\n");
    EXPECT_THAT(compare(), ElementsAre("track.csv:2: x_mm is 1.6, baseline 1.5, tolerance 0"));
    EXPECT_THAT(compare({{}, {{"*.csv", "x_*", 0.2, 0.0}}}), testing::Contains(HasSubstr("timing.json")))
        << "tolerances without the usual ignores";
    Tolerances loose;
    loose.rules = {{"track.csv", "x_mm", 0.0, 0.1}};
    EXPECT_THAT(compare(loose), IsEmpty());
    write("b/meta.json", R"({"metrics":{"tip_mm":{"mean":2.5}},"name":"m"})");
    EXPECT_THAT(compare(loose),
                ElementsAre("meta.json: metrics.tip_mm.mean is 2.5, baseline 2.0, tolerance 0",
                            "meta.json: name is 'm', baseline 'n'"));
    write("b/sub/left.png", std::string("x\0z", 3));
    write("b/new.txt", "1");
    fs::remove(folder_ / "b/track.csv");
    EXPECT_THAT(compare(),
                ElementsAre(HasSubstr("meta.json"), HasSubstr("meta.json"),
                            "sub/left.png: differs from byte 2 on (3 bytes, baseline 3)", "and 2 more"));
}

TEST_F(FolderComparisonTest, reads_tolerances_and_refuses_what_is_none) {
    const Tolerances t = read_tolerances(
        write("t.yaml",
              "ignore: ['*.mp4']\nrules:\n- {file: '*.csv', key: '*_mm', absolute: 0.01, relative: 1e-3}\n"));
    EXPECT_EQ(t.ignored.back(), "*.mp4");
    ASSERT_EQ(t.rules.size(), 1u);
    EXPECT_EQ(t.rules[0].relative, 1e-3);
    EXPECT_THROW(read_tolerances(write("t.yaml", "rules: [{absolute: -1}]\n")), scenes::FileError);
    EXPECT_THROW(read_tolerances(write("t.yaml", "rule: []\n")), scenes::FileError);
}

}  // namespace
}  // namespace atropos::experiments
