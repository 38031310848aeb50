#!/usr/bin/env python3
"""The program from outside: somebody's own trackers. Usage: trackers_test.py PROGRAM [unittest arguments]. Standard library only."""
import json, pathlib, subprocess, sys, unittest

from program import Folder, atropos


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


if __name__ == "__main__":
    unittest.main()
