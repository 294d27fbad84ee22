"""Recordings that others write, or read, are read alike: recordings.py PROGRAM FOLDER.

ezc3d writes C3D files of floating numbers, and reads those of whole numbers and of DEC, which it does not write; MIPS it does
not read. TRC files are laid out as OpenSim's TRCFileAdapter does.
"""

import csv
import struct
import subprocess
import sys
from pathlib import Path

import ezc3d
import numpy as np

program, folder = sys.argv[1], Path(sys.argv[2])
folder.mkdir(parents=True, exist_ok=True)
random = np.random.default_rng(15)


def ours(path):
    """Labels, times and positions (3, n, f) that the program reads."""
    out = path.with_suffix(path.suffix + ".csv")
    subprocess.run([program, "recording", str(path), "--out", str(out)], check=True, stdout=subprocess.DEVNULL)
    with open(out, newline="") as file:
        rows = list(csv.reader(file))
    labels = [head.removesuffix("_x_mm") for head in rows[0][1::3]]
    numbers = np.array([[float(x) if x else np.nan for x in row] for row in rows[1:]])
    return labels, numbers[:, 0], numbers[:, 1:].reshape(len(numbers), -1, 3).transpose(2, 1, 0)


def check(name, read, labels, times, points, tolerance):
    assert read[0] == labels, (name, read[0][:5], labels[:5])
    assert np.abs(read[1] - times).max() <= 1e-9, (name, "times")
    assert np.array_equal(np.isnan(read[2]), np.isnan(points)), (name, "gaps")
    difference = np.nanmax(np.abs(read[2] - points))
    assert difference <= tolerance, (name, difference)
    print(f"{name}: {points.shape[1]} markers, {points.shape[2]} frames, {np.isnan(points[0]).sum()} gaps, "
          f"at most {difference:.1e} mm apart")


def movement(n, f, unit=1.0):
    points = np.round(random.normal(0, 300, (3, n, 1)) + random.normal(0, 5, (3, n, f)), 2) / unit
    points[:, random.random((n, f)) < 0.05] = np.nan
    return points


def by_ezc3d(name, n, f, unit, first=1, analog=0):
    """Written by ezc3d; LABELS2 and more where there are more than 255 points."""
    scale = {"mm": 1.0, "m": 1000.0}[unit]
    points = movement(n, f, scale)
    c3d = ezc3d.c3d()
    c3d["parameters"]["POINT"]["RATE"]["value"] = [125]
    c3d["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    labels = [f"m{k}" for k in range(n)]
    c3d["parameters"]["POINT"]["LABELS"]["value"] = labels
    c3d["data"]["points"] = np.concatenate([points, np.ones((1, n, f))])
    if analog:
        c3d["parameters"]["ANALOG"]["RATE"]["value"] = [1250]
        c3d["parameters"]["ANALOG"]["LABELS"]["value"] = [f"a{k}" for k in range(analog)]
        c3d["data"]["analogs"] = random.normal(0, 1, (1, analog, 10 * f))
    path = folder / name
    c3d.write(str(path))
    # As floating numbers of four bytes hold them.
    stored = points.astype(np.float32).astype(float) * scale
    check(f"ezc3d writes {name}", ours(path), labels, np.arange(f) / 125, stored, 1e-9)


def encode(processor, whole, value):
    if whole:
        return struct.pack("<h", value)
    if processor == 85:
        a, b, c, d = struct.pack(">f", value * 4)
        return bytes([b, a, d, c])
    return struct.pack("<f", value)


def for_ezc3d(name, processor, scale):
    """Read by ezc3d and by the program: whole numbers or floating ones of a processor."""
    n, f, whole = 3, 20, scale > 0
    word = lambda value: struct.pack("<H", value)
    real = lambda value: encode(processor, False, value)
    entry = lambda name, group, data: bytes([len(name), group & 255]) + name.encode() + word(len(data) + 2) + data
    parameter = lambda name, kind, dims, data, group=1: entry(
        name, group, bytes([kind & 255, len(dims), *dims]) + data + b"\0")
    parameters = bytes([1, 80, 1, processor]) + entry("POINT", -1, b"\0") + entry("ANALOG", -2, b"\0")
    parameters += parameter("USED", 2, [], word(n)) + parameter("SCALE", 4, [], real(scale))
    parameters += parameter("RATE", 4, [], real(60)) + parameter("DATA_START", 2, [], word(3))
    parameters += parameter("FRAMES", 2, [], word(f)) + parameter("UNITS", -1, [2], b"mm")
    parameters += parameter("LABELS", -1, [4, n], b"lip chineye ") + parameter("DESCRIPTIONS", -1, [1, n], b"   ")
    parameters += parameter("USED", 2, [], word(0), 2) + parameter("RATE", 4, [], real(0), 2)
    parameters += parameter("LABELS", -1, [1, 0], b"", 2) + b"\0\0"
    header = bytes([2, 80]) + word(n) + word(0) + word(1) + word(f) + word(10) + real(scale) + word(3) + word(0) + real(60)
    data = b""
    for _ in range(f):
        for _ in range(n):
            unseen = random.random() < 0.2
            for _ in range(3):
                data += encode(processor, whole, 0 if unseen else int(random.integers(-9000, 9000)))
            data += encode(processor, whole, -1 if unseen else 0)
    path = folder / name
    path.write_bytes(header.ljust(512, b"\0") + parameters.ljust(512, b"\0") + data)
    theirs = ezc3d.c3d(str(path))
    points = theirs["data"]["points"][:3]
    points[:, theirs["data"]["meta_points"]["residuals"][0] < 0] = np.nan
    labels = theirs["parameters"]["POINT"]["LABELS"]["value"]
    check(f"ezc3d reads {name}", ours(path), labels, np.arange(f) / 60, points, 1e-6)


def as_opensim(name, unit, missing):
    scale, n, f = {"mm": 1.0, "m": 1000.0}[unit], 5, 30
    points = np.round(movement(n, f, scale), 5)
    labels = [f"m{k}" for k in range(n)]
    number = lambda x: missing if np.isnan(x) else f"{x:.5f}"
    lines = [f"PathFileType\t4\t(X/Y/Z)\t{name}",
             "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
             f"60\t60\t{f}\t{n}\t{unit}\t60\t1\t{f}",
             "Frame#\tTime\t" + "\t\t\t".join(labels) + "\t\t",
             "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(n) for axis in "XYZ"), ""]
    for t in range(f):
        lines.append(f"{t + 1}\t{t / 64:.6f}\t" + "\t".join(number(x) for x in points[:, :, t].T.flatten()))
    path = folder / name
    path.write_text("\n".join(lines) + "\n")
    check(f"OpenSim's {name}", ours(path), labels, np.arange(f) / 64, points * scale, 1e-9)


by_ezc3d("floats.c3d", 40, 100, "mm")
by_ezc3d("metres.c3d", 3, 10, "m", analog=4)
by_ezc3d("many.c3d", 600, 5, "mm")
for processor, called in [(84, "intel"), (85, "dec")]:
    for scale, kind in [(0.05, "whole"), (-0.05, "floating")]:
        for_ezc3d(f"{called}_{kind}.c3d", processor, scale)
as_opensim("tabs.trc", "mm", "")
as_opensim("nan.trc", "m", "NaN")
