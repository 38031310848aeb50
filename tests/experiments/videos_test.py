#!/usr/bin/env python3
"""The program from outside: videos as sequences. Usage: videos_test.py PROGRAM [unittest arguments]. Standard library only."""
import subprocess, unittest

from program import Folder, atropos


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
