#!/usr/bin/env python3
"""A push test on a mat that `matrig sim` moves: forces up and down, each held until the mat is at rest, and what it moved then. Between
the engine's law (host/sim/elements/gear.c) and the fit (host/push) nothing is shared but the page that states it.

usage: by_sim.py MATRIG FOLDER K_LB_FT RHO LAW >PUSH.csv

One mat, so --mats 1; 100 lb an axle, one and two of them; the most force is 0.75 of what slides."""
import json
import subprocess
import sys

matrig, folder = sys.argv[1], sys.argv[2]
k, rho, law = (float(v) for v in sys.argv[3:])
HOLD_S, RAMP_S = 2.0, 3.0
print("test,load (lb),force (lb),displacement (in)")
for axles in (1, 2):
    forces = [0, 6, 12, 18, 24, 30, 36, 42, 48, 36, 24, 12, 0, 12, 24]
    path, outputs, t = [[0, 50, 0]], [], 0.0
    for force in forces[1:]:
        path += [[t + RAMP_S, 50, force], [t + RAMP_S + HOLD_S, 50, force]]
        t += RAMP_S + HOLD_S
        outputs.append(t)
    scene = {"model": "chain", "N": 1, "L": 100, "W": 32.174, "left": "free", "right": "free", "f": 0.5, "friction": "stick", "v0": 0,
             "wheel_load": 100, "gear_k_lb_ft": k, "gear_unloading": rho, "gear_axle_law": law, "gear_lines_ft": [0], "gear_axles": [axles],
             "path": path, "tend": t, "t_out": outputs}
    with open(folder + "/push_scene.json", "w") as file:
        json.dump(scene, file)
    said = subprocess.run([matrig, "--json", "sim", folder + "/push_scene.json"], check=True, capture_output=True, text=True, timeout=100)
    moved = [0.0] + [12 * output["u_ft"]["1"] for output in json.loads(said.stdout)["outputs"]]
    for force, in_ in zip(forces, moved):
        print("%d,%d,%g,%.9f" % (axles, 100 * axles, axles * force, in_))
