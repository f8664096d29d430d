#!/usr/bin/env python3
"""A simulated landing as a run file for the emulated board: scene_run.py MATRIG SCENE TEMPLATE OUT

The mats below the eight transducers move as `matrig sim SCENE --csv` says, the gear passes the switches as the scene's path says, the
survey is the sum of the scene's gaps. Everything else (stations, gages at rest, timing) is TEMPLATE's, a run of tests/runs.
Own code on purpose: nothing of matrig's comparison is in it.
"""
import csv
import json
import subprocess
import sys
import tempfile
import zlib

matrig, scene_path, template_path, out_path = sys.argv[1:]
scene = json.load(open(scene_path))
with tempfile.NamedTemporaryFile(suffix=".csv") as history:
    subprocess.run([matrig, "--quiet", "sim", scene_path, "--csv", history.name], check=True, stdout=subprocess.DEVNULL)
    rows = list(csv.reader(open(history.name)))[1:]
DURATION_S = 2.62 + float(rows[-1][0])  # from 1.62 s before touchdown until a second after the simulation
moved_in = [[12.0 * float(u) for u in row[1:9]] for row in rows]  # a row a millisecond
assert abs(float(rows[1][0]) - 0.001) < 1e-12 and len(moved_in[0]) == 8


def passes_s(station_ft):
    """When the gear is at a station, straight between two rows of the path; before the first one at its speed."""
    path = [(row[0], row[1]) for row in scene["path"]]
    (t0, x0), (t1, x1) = path[0], path[1]
    if station_ft < x0:
        return t0 + (station_ft - x0) * (t1 - t0) / (x1 - x0)
    for (t0, x0), (t1, x1) in zip(path, path[1:]):
        if x0 <= station_ft < x1:
            return t0 + (t1 - t0) * (station_ft - x0) / (x1 - x0)
    return None


out, touchdown_s, template = [], 0.0, open(template_path).read().splitlines()
first = template.index(next(line for line in template if line.startswith("samples ")))
for line in template[:first]:
    word = line.split()
    if line[0] == "#" or word[0] == "truth":
        continue
    if word[0] == "provenance":
        line = "provenance simulated by matrig itself, to test its comparison"
    elif word[0] == "duration_s":
        line = f"duration_s {DURATION_S:.3f}"
    elif word[0] == "touchdown":
        touchdown_s = float(word[2])
    elif word[0] == "switch":
        t_s = passes_s(float(word[3]))
        line = " ".join(word[:4] + ["-" if t_s is None else f"{touchdown_s + t_s:.9f}"])
    elif word[0] == "command" and word[3] == "survey":
        line = " ".join(word[:5] + [f"{120.0 * scene['gap0']:.3f}"])
    out.append(line)
count = round(1000 * DURATION_S) + 1
out.append(f"samples {count} 1000")
gages = template[first + 1].split()[8:]
for i in range(count):
    at = (i / 1000.0 - touchdown_s) * 1000.0
    k = min(max(int(at), 0), len(moved_in) - 2)
    share = min(max(at - k, 0.0), 1.0)
    now = [a + (b - a) * share for a, b in zip(moved_in[k], moved_in[k + 1])]
    out.append(" ".join([str(round(1e5 * u)) for u in now] + gages))
text = "\n".join(out) + "\n"
open(out_path, "w").write(text + f"end {zlib.crc32(text.encode()) & 0xffffffff:08x}\n")
