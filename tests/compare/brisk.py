#!/usr/bin/env python3
"""The model runway with a brisk landing on it, so that tests are short: brisk.py SCENE >BRISK

From 40 ft/s with 8 ft/s2, the brake rising over 50 ms, to a stop after 5 s; closed form of the way, thrust (1300 lb / 12) a/g.
"""
import json
import sys

V_FT_S, A_FT_S2, ONSET_S, START_FT, STEP_S = 40.0, 8.0, 0.05, 3.0, 0.01
scene = json.load(open(sys.argv[1]))
speed = V_FT_S - A_FT_S2 * ONSET_S / 2  # when the brake is on
reach = START_FT + V_FT_S * ONSET_S - A_FT_S2 * ONSET_S**2 / 6
stop_s = ONSET_S + speed / A_FT_S2


def at(t):
    if t < ONSET_S:
        return START_FT + V_FT_S * t - A_FT_S2 * t**3 / (6 * ONSET_S), A_FT_S2 * t / ONSET_S
    return reach + speed * (t - ONSET_S) - A_FT_S2 * (t - ONSET_S) ** 2 / 2, A_FT_S2


times = [i * STEP_S for i in range(int(stop_s / STEP_S) + 1)] + [stop_s]
rows = [[t, at(t)[0], 1300 / 12 * at(t)[1] / 32.174] for t in times]
scene["path"] = rows + [[stop_s, rows[-1][1], 0.0]]
scene["name"] = "model runway, brisk"
json.dump(scene, sys.stdout)
