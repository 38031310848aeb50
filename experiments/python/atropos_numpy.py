"""Reads Atropos sequences with numpy alone: `for frame in read_sequence("data/sequence_000000"): frame["left"]`."""
import csv, pathlib, re, struct, zlib
import numpy as np


def read_png(path):
    """An 8- or 16-bit PNG without interlacing as (height, width[, 3]); colour as red, green, blue."""
    data, at, packed = pathlib.Path(path).read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR":
            width, height, bits, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
        packed += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += length + 12
    pixel = (3 if colour == 2 else 1) * bits // 8
    raw, stride = zlib.decompress(packed), width * pixel
    rows, above = [], bytes(stride)
    for y in range(height):
        kind, row = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        if kind == 2:
            row = bytearray((np.frombuffer(row, np.uint8) + np.frombuffer(above, np.uint8)).tobytes())
        elif kind:
            for i in range(stride):
                a, c = (row[i - pixel], above[i - pixel]) if i >= pixel else (0, 0)
                b = above[i]
                near = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
                row[i] = (row[i] + (a, b, (a + b) // 2, near)[kind - 1]) & 255
        rows.append(row)
        above = row
    picture = np.frombuffer(b"".join(rows), ">u2" if bits == 16 else np.uint8).astype(np.uint16 if bits == 16 else np.uint8)
    return picture.reshape((height, width, 3) if colour == 2 else (height, width))


def read_calibration(sequence):
    """M1 D1 M2 D2 R T (mm) ... of calib/stereo.yaml as arrays."""
    text = (pathlib.Path(sequence) / "calib/stereo.yaml").read_text()
    found = re.findall(r"^(\w+): !!opencv-matrix\s+rows: (\d+)\s+cols: (\d+)\s+dt: \w\s+data: \[([^\]]*)\]", text, re.M)
    return {name: np.array(values.split(","), float).reshape(int(rows), int(cols)) for name, rows, cols, values in found}


def read_table(path):
    """A CSV file as a dictionary of columns; numbers where all of a column are."""
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    columns = {name: np.array(values) for name, values in zip(rows[0], zip(*rows[1:]))}
    return {name: v.astype(float) if all(re.fullmatch(r"[-+.\deE]+", x) for x in v) else v for name, v in columns.items()}


def read_sequence(sequence):
    """Frame by frame: left, right, time_s, and with truth: centreline (N, 3) in mm in the left camera, mask, depth_mm."""
    sequence = pathlib.Path(sequence)
    times, truth = read_table(sequence / "frames.csv"), sequence / "truth"
    thread = read_table(truth / "thread.csv") if truth.is_dir() else None
    for i, time_s in enumerate(times["time_s"]):
        name = f"{i:06d}.png"
        frame = {"time_s": time_s, "left": read_png(sequence / "left" / name), "right": read_png(sequence / "right" / name)}
        if thread is not None:
            span = (thread["frame"] == i) & (thread["in_span"] == 1)
            frame["centreline"] = np.stack([thread[k][span] for k in ("x_mm", "y_mm", "z_mm")], axis=1)
        for key, folder, scale in (("mask", "mask_left", 1), ("depth_mm", "depth_left", 64)):
            if (truth / folder).is_dir():
                frame[key] = read_png(truth / folder / name) / scale
        yield frame
