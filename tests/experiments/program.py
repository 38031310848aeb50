"""What the tests of the program from outside share: the program, a tiny scene and experiment, folders. Standard library only."""
import filecmp, os, pathlib, random, shutil, signal, subprocess, sys, tempfile, time, unittest

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
        if not os.path.ismount(self.folder / "disk"):
            shutil.rmtree(self.folder)

    def assertSameFolders(self, a, b):
        self.assertEqual(files_of(a), files_of(b))
        for name in sorted(files_of(a)):
            if pathlib.Path(name).name != "timing.json":
                self.assertTrue(filecmp.cmp(pathlib.Path(a) / name, pathlib.Path(b) / name, shallow=False), name)

    def mounted(self, options):
        """A small file system of its own, until the test ends."""
        disk = self.folder / "disk"
        disk.mkdir()
        if subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(disk)], capture_output=True).returncode != 0:
            self.skipTest("no file system can be mounted here")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)  # once it is unmounted
        self.addCleanup(subprocess.run, ["umount", str(disk)], check=True)
        return disk

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
