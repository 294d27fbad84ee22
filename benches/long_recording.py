"""A recording of many frames from one of few: forward, backward, and so on.

Usage: modiolus recording speech.c3d --out speech.csv; python3 benches/long_recording.py speech.csv 10000 long.csv
then:  time modiolus track long.csv --map examples/speech/map.toml [--contact off] --out out/long
"""

import sys
from pathlib import Path

short, frames, long = sys.argv[1], int(sys.argv[2]), sys.argv[3]
head, *rows = Path(short).read_text().splitlines()
times, markers = zip(*(row.split(",", 1) for row in rows))
step_s = float(times[1]) - float(times[0])
there_and_back = [*markers, *markers[-2:0:-1]]
table = (f"{k * step_s:.6f},{there_and_back[k % len(there_and_back)]}" for k in range(frames))
Path(long).write_text("\n".join([head, *table]) + "\n")
