"""An Atropos dataset for torch: `AtroposDataset("data", split="train")[0]` is a dictionary of tensors for one frame."""
import json, pathlib
import numpy as np
import torch
from atropos_numpy import read_calibration, read_png, read_table

try:
    import cv2  # many times faster than read_png
    load = lambda path: cv2.imread(str(path), cv2.IMREAD_UNCHANGED)[..., ::-1] if "mask" not in str(path) and "disparity" not in str(path) \
        else cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
except ImportError:
    load = read_png


class AtroposDataset(torch.utils.data.Dataset):
    """left, right: (3, H, W) in 0..1; disparity: (H, W) px, 0 = unknown; mask: (H, W) labels; centreline: (N, 3) mm in
    the left camera; K: (3, 3), T: (3,) mm from the left to the right camera. Rectified where the dataset has it
    (generate --rectified): then the centreline is in the rectified left camera, and there is no mask."""

    def __init__(self, folder, split="train"):
        self.folder = pathlib.Path(folder)
        dataset = json.loads((self.folder / "dataset.json").read_text())
        self.rectified, self.frames = "rectified" in dataset["layers"], []
        frames = {sequence["name"]: sequence["frames"] for sequence in dataset["sequences"]}
        for name in dataset["splits"][split]:
            self.frames += [(name, i) for i in range(frames[name])]
        self.threads = {}

    def __len__(self):
        return len(self.frames)

    def thread(self, name):
        if name not in self.threads:
            table = read_table(self.folder / name / "truth/thread.csv")
            keep = table["in_span"] == 1
            self.threads[name] = table["frame"][keep], np.stack([table[k][keep] for k in ("x_mm", "y_mm", "z_mm")], axis=1)
        return self.threads[name]

    def __getitem__(self, index):
        name, i = self.frames[index]
        sequence, picture = self.folder / name, f"{i:06d}.png"
        calibration, (of_frame, points) = read_calibration(sequence), self.thread(name)
        pictures = sequence / "rectified" if self.rectified else sequence
        item = {eye: np.ascontiguousarray(load(pictures / eye / picture)).transpose(2, 0, 1).astype(np.float32) / 255 for eye in ("left", "right")}
        item["centreline"] = points[of_frame == i].astype(np.float32)
        if self.rectified:
            item["disparity"] = load(sequence / "truth/disparity_left" / picture).astype(np.float32) / 64
            item["centreline"] = item["centreline"] @ calibration["R1"].T.astype(np.float32)
            item["K"], T = calibration["P1"][:, :3], calibration["P2"][:, 3] / calibration["P2"][0, 0]
        else:
            if (sequence / "truth/mask_left").is_dir():
                item["mask"] = load(sequence / "truth/mask_left" / picture).astype(np.int64)
            item["K"], T = calibration["M1"], calibration["T"][:, 0]
        item["K"], item["T"] = item["K"].astype(np.float32), T.astype(np.float32)
        return {key: torch.from_numpy(value) for key, value in item.items()}
