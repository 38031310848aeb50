#!/usr/bin/env python3
"""The program from outside: batches of experiments. Usage: experiments_test.py PROGRAM [unittest arguments]. Standard library only."""
import json, pathlib, shutil, subprocess, time, unittest

from program import Folder, atropos, files_of


class Experiments(Folder):
    def test_gives_the_same_bytes_whatever_the_number_of_processes_and_shards(self):
        begin = time.time()
        done = atropos("experiment", self.experiment, "-o", self.folder / "one", "--quiet", check=0)
        seconds = time.time() - begin
        self.assertIn("| 1 |", done.stdout)
        self.assertIn("(paper 0.47 ± 0.21)", done.stdout)
        atropos("experiment", self.experiment, "-o", self.folder / "two", "--jobs", 2, "--quiet", check=0)
        self.assertSameFolders(self.folder / "one", self.folder / "two")
        parts = []
        for i in (1, 2, 3, 4):
            parts.append(self.folder / f"part{i}")
            atropos("experiment", self.experiment, "-o", parts[-1], "--shard", f"{i}/4", "--quiet", check=0)
        whole = atropos("merge", *parts, "-o", self.folder / "whole", check=0)
        self.assertEqual(whole.stdout, done.stdout)
        self.assertSameFolders(self.folder / "one", self.folder / "whole")
        half = atropos("merge", parts[0], "-o", self.folder / "half", check=1)
        self.assertIn("unfinished: 4 of 8 jobs are missing", half.stdout)
        self.assertEqual(atropos("check", self.folder / "one", self.folder / "whole", check=0).stdout, "equal\n")
        self.assertIn("is missing, the baseline has it", atropos("check", self.folder / "one", self.folder / "half", check=1).stdout)
        self.kill_and_resume(["experiment", self.experiment, "-o", self.folder / "killed", "--jobs", 2, "--quiet"], self.folder / "killed", seconds)
        self.assertSameFolders(self.folder / "one", self.folder / "killed")

        # The page can be written again, from what the folder holds.
        page = self.folder / "one" / "report.html"
        written = page.read_bytes()
        page.unlink()
        self.assertIn("8 jobs done, 0 missing, 0 failed", atropos("report", self.folder / "one", check=0).stdout)
        self.assertEqual(page.read_bytes(), written)
        self.assertOneLine(atropos("report", self.folder), "expected the folder of a finished run or of an experiment")

        # What is wrong on disk is said in one line, and nothing is lost.
        one = self.folder / "one"
        self.assertOneLine(atropos("experiment", self.experiment, "-o", one), "not empty", "--force")
        manifest = one / "experiment.json"
        text = manifest.read_text()
        manifest.write_text(text.replace('"seeds": 2', '"seeds": 3'))
        self.assertOneLine(atropos("experiment", self.experiment, "-o", one, "--resume"), "experiment.json: belongs to another")
        self.assertOneLine(atropos("merge", one, self.folder / "two", "-o", self.folder / "x"), "belongs to another experiment")
        manifest.write_text(text)
        result = sorted(one.glob("jobs/*/result.json"))[0]
        result.write_text(result.read_text()[:100])
        self.assertOneLine(atropos("experiment", self.experiment, "-o", one, "--resume", "--quiet"), "result.json: no JSON object")
        self.assertOneLine(atropos("merge", one, "-o", self.folder / "x"), "result.json: no JSON object")
        self.assertFalse((self.folder / "x").exists())
        self.assertOneLine(atropos("experiment", self.experiment, "-o", "/dev/null/atropos"), "/dev/null/atropos")

    def test_counts_a_job_out_of_time_as_failed_and_does_the_others(self):
        self.experiment.write_text("scene: tiny.yaml\ntimeout_s: 20\nset: {tracker.method: e1}\ntrackers:\n  ours:\n"
                                   "  theirs: {command: 'sleep 1000'}\n  crash: {command: 'exit 1'}\n")
        done = atropos("experiment", self.experiment, "-o", self.folder / "out", "--jobs", 2, "--quiet", check=1)
        self.assertIn("1 jobs failed", done.stdout)
        results = {json.loads(p.read_text())["status"] for p in self.folder.glob("out/jobs/*/result.json")}
        self.assertEqual(results, {"done", "failed"})
        failed = [p for p in self.folder.glob("out/jobs/*/result.json") if "took longer than 20 s" in p.read_text()]
        self.assertEqual(len(failed), 1)
        self.assertEqual([p for p in files_of(self.folder / "out") if p.endswith((".log", ".partial")) and "tracker.log" not in p], [])

    def test_goes_on_where_a_full_disk_stopped_it(self):
        disk = self.mounted("size=400k")
        begin = ["experiment", self.experiment, "--quiet", "-o"]
        self.assertOneLine(atropos(*begin, disk / "out"), "No space left on device")
        self.assertFalse(any("result.json.partial" in name for name in files_of(disk)))
        subprocess.run(["mount", "-o", "remount,size=50m", str(disk)], check=True)
        atropos(*begin, disk / "out", "--resume", check=0)
        atropos(*begin, self.folder / "undisturbed", check=0)
        self.assertSameFolders(self.folder / "undisturbed", disk / "out")

    def test_goes_on_where_a_vanished_input_stopped_it(self):
        atropos("generate", self.folder / "tiny.yaml", "-o", self.folder / "recorded", "--layers", "none", "--quiet", check=0)
        recording, away, take_away = self.folder / "recording.csv", self.folder / "away.csv", self.folder / "take_away"
        shutil.copy(self.folder / "recorded/sequence_000000/kinematics.csv", recording)
        self.experiment.write_text("scene: tiny.yaml\nseeds: 2\nset: {arms.PSM1: {motion: replay, recording: {file: %s}}}\ntrackers:\n"
                                   "  theirs: {command: 'rm %s && mv %s %s; exit 1'}\n" % (recording, take_away, recording, away))
        begin = ["experiment", self.experiment, "--quiet", "-o"]
        take_away.write_text("")
        self.assertOneLine(atropos(*begin, self.folder / "out"), "recording.csv")
        finished = list(self.folder.glob("out/jobs/*/result.json"))
        self.assertEqual(len(finished), 1, "the first seed's job is kept")
        self.assertFalse(any(".partial" in name for name in files_of(self.folder / "out")))
        away.rename(recording)
        atropos(*begin, self.folder / "out", "--resume", check=0)
        atropos(*begin, self.folder / "undisturbed", check=0)
        self.assertSameFolders(self.folder / "undisturbed", self.folder / "out")

    def test_judges_a_reprojected_track_against_the_spline_it_shows(self):
        self.experiment.write_text("scene: tiny.yaml\nset: {tracker: {tips: exact, method: e2}, camera.width_px: 640}\n"
                                   "grid: {protocol: {P: {protocol: P}, S: {protocol: S}}}\nlist:\n- {name: as it is}\n"
                                   "- {name: worse ends, set: {degrade.tip_error_mm: 3}}\n")
        atropos("experiment", self.experiment, "-o", self.folder / "out", "--keep", "all", "--quiet", check=0)
        self.assertEqual(len(list((self.folder / "out/sequences").iterdir())), 2, "the same pictures for both")
        manifest = json.loads((self.folder / "out/experiment.json").read_text())
        result = {tuple(cell["levels"][f] for f in ("protocol", "case")): json.loads((self.folder / "out/jobs" / cell["job"] / "result.json").read_text())
                  for cell in manifest["cells"]}
        self.assertEqual({r["status"] for r in result.values()}, {"done"})
        spline = next(p for p in (self.folder / "out/sequences").iterdir() if not (p / "truth/kinematics.csv").exists())
        truth = [line.split(",") for line in (spline / "truth/thread.csv").read_text().split()[1:]]
        tips = [line.split(",")[3:] for line in (spline / "tips.csv").read_text().split()[1:]]
        self.assertEqual(tips, [row[5:8] for row in truth if row[2] in ("0", "100")], "the spline's own ends")
        self.assertLess(result["P", "as it is"]["metrics"]["accuracy_2d_px"]["mean"], result["P", "worse ends"]["metrics"]["accuracy_2d_px"]["mean"])
        self.assertNotEqual(result["S", "as it is"]["metrics"], result["S", "worse ends"]["metrics"])
        page = (self.folder / "out/report.html").read_text()
        self.assertIn("--explain", page)
        self.assertNotIn("http://", page.replace("http://www.w3.org", ""))

    def test_says_what_it_would_cost(self):
        done = atropos("experiment", self.experiment, "--dry-run", check=0)
        self.assertIn("8 jobs in 8 cells, 2 sequences, 2 seeds", done.stdout)
        self.assertIn("GB", done.stdout)
        experiments = pathlib.Path(__file__).resolve().parents[2] / "experiments"
        for file in sorted(experiments.glob("*.yaml")):
            if file.name != "tolerance.yaml":
                self.assertIn("core hours", atropos("experiment", file, "--dry-run", check=0).stdout, file.name)


if __name__ == "__main__":
    unittest.main()
