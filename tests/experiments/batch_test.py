#!/usr/bin/env python3
"""The program's batch work from outside: usage batch_test.py PROGRAM [unittest arguments]. Standard library only."""
import filecmp, json, os, pathlib, random, shutil, signal, subprocess, sys, tempfile, time, unittest

PROGRAM = os.path.abspath(sys.argv.pop(1))
KILLS = int(os.environ.get("ATROPOS_TEST_KILLS", "2"))

SCENE = "duration_s: 0.2\ncamera: {width_px: 160}\ntracker: {thread: {length_mm: 70, width_mm: 0.25, channel: red}}\n"
EXPERIMENT = """
name: tiny
scene: tiny.yaml
set: {tracker.K: 6}
grid: {accel: [1, 2]}
trackers: [e1, e2]
seeds: 2
table: {rows: accel, columns: tracker, metrics: [accuracy_3d_mm, end_slide_px]}
published: [{tracker: e1, accel: 1, metric: accuracy_3d_mm, mean: 0.47, std: 0.21}]
"""


def atropos(*arguments, check=None):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True)
    if check is not None and done.returncode != check:
        raise AssertionError(f"{arguments}: exit {done.returncode}, expected {check}\n{done.stderr}")
    return done


def files_of(folder):
    folder = pathlib.Path(folder)
    return {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="atropos-batch-"))
        (self.folder / "tiny.yaml").write_text(SCENE)
        (self.folder / "tiny_experiment.yaml").write_text(EXPERIMENT)
        self.experiment = self.folder / "tiny_experiment.yaml"

    def tearDown(self):
        shutil.rmtree(self.folder)

    def assertSameFolders(self, a, b):
        self.assertEqual(files_of(a), files_of(b))
        for name in sorted(files_of(a)):
            if pathlib.Path(name).name != "timing.json":
                self.assertTrue(filecmp.cmp(pathlib.Path(a) / name, pathlib.Path(b) / name, shallow=False), name)

    def assertOneLine(self, done, *words):
        self.assertEqual(done.returncode, 2, done.stderr)
        lines = [line for line in done.stderr.splitlines() if line.startswith("atropos: ")]
        self.assertEqual(len(lines), 1, done.stderr)
        for word in words:
            self.assertIn(word, lines[0])

    def kill_and_resume(self, arguments, target, seconds):
        """kill -9 at random moments until it gets through."""
        resume = []
        for _ in range(KILLS):
            child = subprocess.Popen([PROGRAM, *map(str, arguments), *resume], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(random.uniform(0.0, seconds))
            child.send_signal(signal.SIGKILL)
            if child.wait() == 0:
                return  # through before the kill
            resume = ["--resume"]
        time.sleep(0.2)  # children die with their parent
        atropos(*arguments, *resume, check=0)


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


class Clusters(Folder):
    """The Snakefile: on this machine, and through a Slurm of our own on this machine. Needs snakemake, slurmctld, slurmd, munge."""

    ROOT = pathlib.Path(__file__).resolve().parents[2]

    def snakemake(self, profile, **environment):
        if not shutil.which("snakemake"):
            self.skipTest("no snakemake here")
        atropos("experiment", self.experiment, "-o", self.folder / "one", "--quiet", check=0)
        done = subprocess.run(["snakemake", "-s", self.ROOT / "experiments/Snakefile", "--profile", self.ROOT / "experiments/profiles" / profile, "--config",
                               f"experiment={self.experiment}", f"output={self.folder / 'whole'}", "shards=2", f"atropos={PROGRAM}"],
                              capture_output=True, text=True, cwd=self.folder, timeout=500, env=os.environ | environment)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertSameFolders(self.folder / "one", self.folder / "whole")

    def test_of_one_machine_give_the_same_bytes(self):
        self.snakemake("local")

    def test_of_slurm_give_the_same_bytes(self):
        """munge, slurmctld and slurmd in a folder of their own, as root, one node; skips where they can't start."""
        if os.geteuid() != 0 or not all(shutil.which(p) for p in ("munged", "slurmctld", "slurmd", "sbatch", "sinfo")):
            self.skipTest("needs root, munge, slurmctld, slurmd and slurm-client")
        slurm = self.folder / "slurm"
        for name in ("", "munge", "state", "spool"):
            (slurm / name).mkdir(mode=0o755)
        os.chmod(self.folder, 0o755)
        (slurm / "munge/key").write_bytes(random.randbytes(128))
        os.chmod(slurm / "munge/key", 0o400)
        (slurm / "slurm.conf").write_text(f"""
ClusterName=test
SlurmctldHost=localhost
SlurmUser=root
AuthInfo=socket={slurm}/munge/socket
SlurmctldPort=16817
SlurmdPort=16818
SlurmctldPidFile={slurm}/slurmctld.pid
SlurmdPidFile={slurm}/slurmd.pid
StateSaveLocation={slurm}/state
SlurmdSpoolDir={slurm}/spool
SlurmctldLogFile={slurm}/slurmctld.log
SlurmdLogFile={slurm}/slurmd.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
ReturnToService=2
NodeName=localhost NodeAddr=127.0.0.1 CPUs=2 RealMemory=4096
PartitionName=all Nodes=localhost Default=YES MaxTime=INFINITE State=UP
""")
        environment = {"SLURM_CONF": str(slurm / "slurm.conf")}
        daemons = []
        try:
            for command in (["munged", "--force", "--foreground", f"--socket={slurm}/munge/socket", f"--key-file={slurm}/munge/key",
                             f"--pid-file={slurm}/munge/pid", f"--log-file={slurm}/munge/log", f"--seed-file={slurm}/munge/seed"],
                            ["slurmctld", "-D", "-f", slurm / "slurm.conf"], ["slurmd", "-D", "-f", slurm / "slurm.conf", "-N", "localhost"]):
                daemons.append(subprocess.Popen(command, env=os.environ | environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
                time.sleep(2)
            for _ in range(20):
                state = subprocess.run(["sinfo", "-h", "-o", "%t"], capture_output=True, text=True, env=os.environ | environment).stdout.strip()
                if state == "idle" or any(d.poll() is not None for d in daemons):
                    break
                time.sleep(1)
            if state != "idle":
                log = slurm / "slurmd.log"
                self.skipTest("slurmd can't start here: " + (log.read_text().splitlines()[-1] if log.exists() and log.read_text() else state))
            self.snakemake("slurm", **environment)
        finally:
            for daemon in reversed(daemons):
                daemon.terminate()
                daemon.wait(timeout=30)


class Datasets(Folder):
    def generate(self, name, *more):
        return atropos("generate", self.folder / "tiny.yaml", "-o", self.folder / name, "--quiet", *more, check=0)

    def test_are_whole_verified_and_the_same_after_kills(self):
        (self.folder / "tiny.yaml").write_text(SCENE + "thread: {diameter_mm: 1}\nrandomise:\n  thread.length_mm: [66, 74]\n  thread.colour: {choice: [black, violet]}\n"
                                               "  thread.EI_N_m2: {log: [1.0e-9, 1.0e-8]}\n")
        begin = time.time()
        self.generate("data", "--count", 3, "--rectified", "--coco")
        seconds = time.time() - begin
        data = self.folder / "data"
        self.generate("data", "--count", 3, "--rectified", "--coco", "--resume")  # nothing left to do
        self.assertIn("verified", atropos("info", data, "--verify", check=0).stdout)
        dataset = json.loads((data / "dataset.json").read_text())
        self.assertEqual((dataset["count"], dataset["frames"]), (3, 18))
        self.assertEqual(sorted(sum(dataset["splits"].values(), [])), [s["name"] for s in dataset["sequences"]])
        lengths = {s["drawn"]["thread.length_mm"] for s in dataset["sequences"]}
        self.assertEqual(len(lengths), 3)
        self.assertTrue(all(66 <= float(x) <= 74 for x in lengths))
        for sequence in dataset["sequences"]:
            self.assertIn(f"  length_mm: {sequence['drawn']['thread.length_mm']}\n", (data / sequence["name"] / "scene.yaml").read_text())
        self.check_coco(data)
        self.check_readers(data)
        self.kill_and_resume(["generate", self.folder / "tiny.yaml", "-o", self.folder / "killed", "--quiet", "--count", 3, "--rectified", "--coco"],
                             self.folder / "killed", seconds)
        self.assertSameFolders(data, self.folder / "killed")
        self.assertEqual([p.name for p in self.folder.iterdir() if "partial" in p.name], [])

        # What is wrong with it is said in one line.
        meta, picture, table = (data / "sequence_000001" / name for name in ("meta.json", "left/000002.png", "truth/thread.csv"))
        for path, spoil, command, words in (
                (picture, lambda b: b[:1000] + bytes([b[1000] ^ 1]) + b[1001:], ["info", data, "--verify"], ["000002.png", "checksum"]),
                (picture, lambda b: b[:1000] + bytes([b[1000] ^ 1]) + b[1001:], ["track", data / "sequence_000001", "-o", self.folder / "t"], ["000002.png", "PNG"]),
                (picture, lambda b: None, ["info", data, "--verify"], ["000002.png", "missing"]),
                (picture, lambda b: None, ["track", data / "sequence_000001", "-o", self.folder / "t"], ["000003.png", "expected picture number 000002"]),
                (table, lambda b: b[:-40], ["info", data, "--verify"], ["thread.csv", "checksum"]),
                (table, lambda b: b[:-40], ["evaluate", data / "sequence_000001", self.folder / "track"], ["thread.csv:", "fields"]),
                (meta, lambda b: b.replace(b'"frames": 6', b'"frames": 7'), ["info", data, "--verify"], ["meta.json", "dataset.json"]),
                (data / "dataset.json", lambda b: b[:-30], ["info", data, "--verify"], ["dataset.json", "no JSON object"])):
            if command[0] == "evaluate":
                atropos("track", data / "sequence_000001", "-o", self.folder / "track", "--method", "e1", "--quiet", "--force", check=0)
            before = path.read_bytes()
            path.unlink() if spoil(before) is None else path.write_bytes(spoil(before))
            self.assertOneLine(atropos(*command, "--quiet") if command[0] == "track" else atropos(*command), *words)
            path.write_bytes(before)
        self.assertFalse((self.folder / "t").exists())
        self.assertFalse((self.folder / "t.partial").exists())
        atropos("info", data, "--verify", check=0)

    def check_coco(self, data):
        """The invariants of the COCO format: ids, references, run lengths, boxes, areas, key points."""
        coco = json.loads((data / "coco.json").read_text())
        images = {image["id"]: image for image in coco["images"]}
        self.assertEqual(len(images), 18)
        categories = {c["id"]: c for c in coco["categories"]}
        self.assertEqual(len({a["id"] for a in coco["annotations"]}), len(coco["annotations"]))
        self.assertGreater(len(coco["annotations"]), 0)
        for image in images.values():
            self.assertTrue((data / image["file_name"]).is_file())
        for a in coco["annotations"]:
            image, category = images[a["image_id"]], categories[a["category_id"]]
            height, width = a["segmentation"]["size"]
            self.assertEqual((height, width), (image["height"], image["width"]))
            counts = a["segmentation"]["counts"]
            self.assertEqual(sum(counts), width * height)
            self.assertTrue(all(c > 0 for c in counts[1:]) and counts[0] >= 0)
            self.assertEqual(sum(counts[1::2]), a["area"])
            inside, at = [], 0
            for i, c in enumerate(counts):
                inside += range(at, at + c) if i % 2 else []
                at += c
            x, y = [p // height for p in inside], [p % height for p in inside]
            self.assertEqual(a["bbox"], [min(x), min(y), max(x) - min(x) + 1, max(y) - min(y) + 1])
            self.assertEqual(len(a["keypoints"]), 3 * len(category["keypoints"]))
            flags = a["keypoints"][2::3]
            self.assertTrue(set(flags) <= {0, 1, 2})
            self.assertEqual(sum(f > 0 for f in flags), a["num_keypoints"])

    def check_readers(self, data):
        """The readers that stand in the dataset; torch is replaced by the few calls that they make."""
        script = """
import sys, types, numpy as np
torch = types.ModuleType("torch")
torch.from_numpy = lambda a: a
torch.utils = types.SimpleNamespace(data=types.SimpleNamespace(Dataset=object))
sys.modules["torch"] = torch
import atropos_numpy, atropos_torch
frames = list(atropos_numpy.read_sequence("sequence_000000"))
assert len(frames) == 6 and frames[0]["left"].shape == (90, 160, 3), frames[0]["left"].shape
assert frames[0]["centreline"].shape == (101, 3) and abs(frames[3]["time_s"] - 0.1) < 1e-6
assert (frames[0]["mask"] == 1).sum() > 10 and 60 < frames[0]["depth_mm"].max() < 300
M = atropos_numpy.read_calibration("sequence_000000")["M1"]
uv = frames[0]["centreline"] @ M.T
u, v = np.rint(uv[:, :2] / uv[:, 2:]).astype(int).T
inside = (u > 0) & (v > 0) & (u < 159) & (v < 89)
near = [frames[0]["mask"][b - 1:b + 2, a - 1:a + 2] for a, b in zip(u[inside], v[inside])]
assert np.mean([(n == 1).any() for n in near]) > 0.5, "the curve lies on the thread's mask"
splits = [atropos_torch.AtroposDataset(".", split) for split in ("train", "val", "test")]
assert sum(map(len, splits)) == 18
item = next(s for s in splits if len(s))[0]
assert item["left"].shape == (3, 90, 160) and item["left"].dtype == np.float32 and 0 < item["left"].mean() < 1
assert item["disparity"].shape == (90, 160) and item["K"].shape == (3, 3) and item["T"].shape == (3,)
z = item["K"][0, 0] * np.linalg.norm(item["T"]) / item["disparity"][item["disparity"] > 0]
assert 60 < np.median(z) < 200, np.median(z)
"""
        done = subprocess.run(["/usr/bin/python3", "-B", "-c", script], cwd=data, capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_frames_of_an_accelerated_sequence_are_those_of_the_base_sequence(self):
        self.generate("base", "--layers", "none")
        self.generate("fast", "--layers", "none", "--accel", 2)
        for i in range(3):
            for eye in ("left", "right"):
                self.assertEqual((self.folder / f"base/sequence_000000/{eye}/{2 * i:06d}.png").read_bytes(),
                                 (self.folder / f"fast/sequence_000000/{eye}/{i:06d}.png").read_bytes())
        self.assertEqual(files_of(self.folder / "base/sequence_000000/truth"), {"thread.csv", "events.csv", "kinematics.csv"})

    def test_say_when_the_disk_is_full_and_keep_what_is_finished(self):
        disk = self.folder / "disk"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1500k", "tmpfs", str(disk)], capture_output=True).returncode != 0:
            self.skipTest("no file system can be mounted here")
        try:
            done = atropos("generate", self.folder / "tiny.yaml", "-o", disk / "data", "--quiet", "--count", 20)
            self.assertOneLine(done, "No space left on device")
            self.assertFalse((disk / "data").exists())
            self.assertTrue((disk / "data.partial/sequence_000000/meta.json").exists())
            self.assertEqual([p for p in (disk / "data.partial").iterdir() if p.suffix == ".partial"], [])
        finally:
            subprocess.run(["umount", str(disk)], check=True)


class Trackers(Folder):
    def test_of_others_give_through_the_pipe_what_they_give_alone(self):
        atropos("generate", self.folder / "tiny.yaml", "-o", self.folder / "data", "--quiet", "--set", "camera.width_px=320", check=0)
        python = pathlib.Path(__file__).resolve().parents[2] / "experiments/python"
        sequence = self.folder / "data/sequence_000000"
        done = atropos("track", sequence, "-o", self.folder / "mine", "--quiet", "--tracker-timeout", 120,
                       "--tracker", f"/usr/bin/python3 '{python}/own_tracker.py'", check=0)
        self.assertEqual((self.folder / "mine/tracker.log").read_text(), "", done.stderr)
        script = f"""
import sys
sys.path.insert(0, {str(python)!r})
import numpy as np, own_tracker, atropos_numpy
c = atropos_numpy.read_calibration({str(sequence)!r})
calibration = {{k: c[k].tolist() for k in ("M1", "M2", "R")}} | {{"T": c["T"].ravel().tolist()}}
tips = atropos_numpy.read_table({str(sequence / 'tips.csv')!r})
curve = None
print("frame,i,s_mm,x_mm,y_mm,z_mm")
for i, frame in enumerate(atropos_numpy.read_sequence({str(sequence)!r})):
    ends = [{{"p_mm": [tips[k][(tips["frame"] == i) & (tips["end"] == e)][0] for k in ("x_mm", "y_mm", "z_mm")]}} for e in (0, 1)]
    curve = own_tracker.track(curve, *(frame[eye][..., 0].astype(float) for eye in ("left", "right")), calibration, ends)
    steps = np.r_[0, np.cumsum(np.linalg.norm(np.diff(curve, axis=0), axis=1))]
    for n, s in enumerate(np.linspace(0, steps[-1], 101)):
        print(i, n, *(f"{{v:.5f}}" for v in (s, *(np.interp(s, steps, curve[:, k]) for k in range(3)))), sep=",")
"""
        alone = subprocess.run(["/usr/bin/python3", "-B", "-c", script], capture_output=True, text=True)
        self.assertEqual(alone.returncode, 0, alone.stderr)
        theirs = [line.split(",")[:6] for line in (self.folder / "mine/track.csv").read_text().split()[1:]]
        ours = [line.split(",") for line in alone.stdout.split()[1:]]
        self.assertEqual(len(ours), 606)
        self.assertEqual([r[:2] for r in ours], [r[:2] for r in theirs])
        self.assertLess(max(abs(float(a) - float(b)) for x, y in zip(ours, theirs) for a, b in zip(x[2:], y[2:])), 2e-5)

    def test_costs_its_frames_only_in_the_closed_loop_too(self):
        done = atropos("run", self.folder / "tiny.yaml", "-o", self.folder / "run", "--no-video", "--quiet", "--tracker", "exit 1")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("given up after 3 starts", (self.folder / "run/track/tracker.log").read_text())
        self.assertEqual(json.loads((self.folder / "run/summary.json").read_text())["verdict"], "aborted")


class Videos(Folder):
    def test_become_the_sequence_they_were_made_from(self):
        atropos("generate", self.folder / "tiny.yaml", "-o", self.folder / "data", "--quiet", "--layers", "none", check=0)
        sequence = self.folder / "data/sequence_000000"
        ffmpeg = ["ffmpeg", "-v", "error", "-framerate", "25"]
        for eye in ("left", "right"):
            subprocess.run([*ffmpeg, "-i", sequence / eye / "%06d.png", "-c:v", "ffv1", "-pix_fmt", "bgr0", self.folder / f"{eye}.mkv"], check=True)
        subprocess.run([*ffmpeg, "-i", sequence / "left/%06d.png", "-framerate", "25", "-i", sequence / "right/%06d.png", "-filter_complex", "hstack",
                        "-c:v", "ffv1", "-pix_fmt", "bgr0", self.folder / "both.mkv"], check=True)
        calib = sequence / "calib/stereo.yaml"
        atropos("import", self.folder / "left.mkv", self.folder / "right.mkv", "--calib", calib, "-o", self.folder / "two", check=0)
        atropos("import", self.folder / "both.mkv", "--calib", calib, "-o", self.folder / "one", check=0)
        for eye in ("left", "right"):
            for picture in sorted((sequence / eye).iterdir()):
                for made in ("two", "one"):
                    self.assertEqual((self.folder / made / eye / picture.name).read_bytes(), picture.read_bytes())
        self.assertEqual((self.folder / "two/frames.csv").read_text().split()[2], "1,0.040000")
        atropos("track", self.folder / "two", "-o", self.folder / "track", "--quiet", check=0)
        self.assertOneLine(atropos("import", self.folder / "left.mkv", "--calib", calib, "-o", self.folder / "x"), "left.mkv: 160x90 px, expected 320x90")
        (self.folder / "broken.mkv").write_bytes(b"no video")
        self.assertOneLine(atropos("import", self.folder / "broken.mkv", "--calib", calib, "-o", self.folder / "x"), "no video that ffmpeg can read")
        self.assertOneLine(atropos("import", self.folder / "none.mkv", "--calib", calib, "-o", self.folder / "x"), "none.mkv: no such video")


if __name__ == "__main__":
    unittest.main()
