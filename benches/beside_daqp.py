"""The bench "60 frames of 28 muscles" by DAQP, beside what the bench measured.

Usage: cargo bench --bench inverse -- "60 frames"; python3 benches/beside_daqp.py    (needs numpy and daqp 0.11 from PyPI)

The programs are those of benches/inverse.rs, from the same sequence of numbers. DAQP's times are what it measures itself, without Python:
each frame from nothing, and in a workspace that goes on from the active set of the frame before, given all arrays of the frame
anew (as the frames of a recording differ), or only its linear term.
"""

import json
import math
import statistics
import time
from pathlib import Path

import daqp
import numpy as np

MUSCLES, FRAMES, REPEATS = 28, 60, 200


def programs():
    """The arrays of each frame."""
    state, m = 1, MUSCLES

    def next_number():
        nonlocal state
        state = (state * 6364136223846793005 + 1442695040888963407) % 2**64
        return (state >> 11) / 2.0**53 - 0.5

    def matrix(rows, columns):
        return np.array([[next_number() for _ in range(rows)] for _ in range(columns)]).T

    activation_map = matrix(2 * m, m)
    wanted = np.array([0.5 + 1.5 * next_number() for _ in range(m)])
    hessian = activation_map.T @ activation_map + 0.1 * np.eye(m)
    linear = -activation_map.T @ (activation_map @ wanted)
    rows = np.ascontiguousarray(matrix(m, m))
    for frame in range(FRAMES):
        turned = np.where(np.arange(m) % 3 == 0, math.cos(0.1 * frame), 1.0)
        yield hessian, linear * turned, rows


def limits():
    """Bounds first, then rows."""
    upper = np.concatenate([np.ones(MUSCLES), np.full(MUSCLES, 0.5)])
    lower = np.concatenate([np.zeros(MUSCLES), np.full(MUSCLES, -1e30)])
    return upper, lower, np.zeros(2 * MUSCLES, dtype=np.intc)


def alone(frames):
    """Seconds to solve each frame from nothing, and the answers."""
    upper, lower, kinds = limits()
    spent, answers = 0.0, []
    for hessian, linear, rows in frames:
        x, _, flag, info = daqp.solve(hessian, linear, rows, upper, lower, kinds)
        assert flag == 1
        spent += info["setup_time"] + info["solve_time"]
        answers.append(x)
    return spent, answers


def hot(frames, whole):
    """The same in one workspace; `whole` gives it all arrays of each frame. Updates are timed from outside."""
    upper, lower, kinds = limits()
    model = daqp.Model()
    hessian, linear, rows = frames[0]
    _, spent = model.setup(hessian, linear, rows, upper, lower, kinds)
    answers = []
    for frame, (hessian, linear, rows) in enumerate(frames):
        if frame > 0:
            start = time.perf_counter()
            if whole:
                model.update(H=hessian, f=linear, A=rows, bupper=upper, blower=lower)
            else:
                model.update(f=linear)
            spent += time.perf_counter() - start
        x, _, flag, info = model.solve()
        assert flag == 1
        spent += info["solve_time"]
        answers.append(x)
    return spent, answers


def main():
    frames = list(programs())
    ways = {
        "each from nothing": alone,
        "hot, all arrays anew": lambda frames: hot(frames, True),
        "hot, linear term anew": lambda frames: hot(frames, False),
    }
    reference = alone(frames)[1]
    micro = {}
    for name, way in ways.items():
        assert max(np.abs(x - y).max() for x, y in zip(way(frames)[1], reference)) < 1e-6
        micro[name] = statistics.median(way(frames)[0] for _ in range(REPEATS)) / FRAMES * 1e6
        print(f"DAQP, {name}: {micro[name]:.1f} us a frame")
    for name in ["each alone, active set", "each alone, Clarabel"]:
        places = Path(__file__).parent.parent.glob(f"target/criterion/60 frames*/{name.replace('/', '_')}/new/estimates.json")
        for place in places:
            own = json.loads(place.read_text())["median"]["point_estimate"] / FRAMES / 1e3
            ratios = ", ".join(f"{own / value:.2f} x DAQP {way}" for way, value in micro.items())
            print(f"{name}: {own:.1f} us a frame; {ratios}")


if __name__ == "__main__":
    main()
