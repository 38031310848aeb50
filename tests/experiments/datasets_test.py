#!/usr/bin/env python3
"""The program from outside: datasets. Usage: datasets_test.py PROGRAM [unittest arguments]. Standard library only."""
import json, subprocess, sys, time, unittest

from program import SCENE, Folder, atropos, files_of


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
        disk = self.mounted("size=1500k")
        done = atropos("generate", self.folder / "tiny.yaml", "-o", disk / "data", "--quiet", "--count", 20)
        self.assertOneLine(done, "No space left on device")
        self.assertFalse((disk / "data").exists())
        self.assertTrue((disk / "data.partial/sequence_000000/meta.json").exists())
        self.assertEqual([p for p in (disk / "data.partial").iterdir() if p.suffix == ".partial"], [])

    def test_say_when_nothing_can_be_written(self):
        disk = self.mounted("ro")
        for command in (["generate", self.folder / "tiny.yaml"], ["experiment", self.experiment], ["run", self.folder / "tiny.yaml"]):
            self.assertOneLine(atropos(*command, "-o", disk / "out", "--quiet"), str(disk), "Read-only file system")
        picture = atropos("render", self.folder / "tiny.yaml", "-o", disk / "still.png", "--quiet")
        self.assertOneLine(picture, "still.png")


if __name__ == "__main__":
    unittest.main()
