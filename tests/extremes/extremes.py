#!/usr/bin/env python3
"""Landings beyond every rig: each ends with an answer and its error, or is refused with a reason, within a minute.

usage: extremes.py MATRIG SCENES SERIES FOLDER

Writes FOLDER/extremes.md. Exit 1 when a row neither ends nor says why, takes longer than a minute, or is not what closed forms demand of it.
"""
import json
import math
import os
import subprocess
import sys

MINUTE_S = 60.0
NUMERICS = 5  # exit code: refused or failed by its numbers
NONSENSE = "k 0, lines left in"  # the one scene that contradicts itself

RIGID = 7e13  # lb/ft: Coulomb's law


def fewer(scene, *keys):
    return {key: value for key, value in scene.items() if key not in keys}


GEAR = ("gear_k_lb_ft", "gear_lines_ft", "gear_axles", "gear_foot_ft")

# What it is called, and what it does to a scene.
SCENE_EXTREMES = [
    ("as it is", lambda s: s),
    ("ground 1e4 times as stiff", lambda s: {**s, "gear_k_lb_ft": 7e7}),
    ("ground rigid (1e10 times)", lambda s: {**s, "gear_k_lb_ft": RIGID}),
    ("ground 1e-12 times as stiff", lambda s: {**s, "gear_k_lb_ft": 7e-9}),
    (NONSENSE, lambda s: {**s, "gear_k_lb_ft": 0}),
    ("k 0, no lines: Coulomb's law under the wheel", lambda s: fewer(s, *GEAR)),
    ("k 0, no lines, no load: weightless", lambda s: fewer(s, *GEAR, "wheel_load")),
    ("load 0", lambda s: {**s, "wheel_load": 0}),
    ("load 10 times", lambda s: {**s, "wheel_load": 1083}),
    ("load and thrust 10 times", lambda s: {**s, "wheel_load": 1083, "path": [[t, x, 10 * f] for t, x, f in s["path"]]}),
    ("thrust 10 times", lambda s: {**s, "path": [[t, x, 10 * f] for t, x, f in s["path"]]}),
    ("nothing springs back (rho 1e-6)", lambda s: {**s, "gear_unloading": 1e-6}),
    ("ground undamped", lambda s: {**s, "gear_damping": 0}),
    ("ground damped 10 times critically", lambda s: {**s, "gear_damping": 10}),
    ("foot of four mats", lambda s: {**s, "gear_foot_ft": 4 * s["L"]}),
    ("no foot", lambda s: fewer(s, "gear_foot_ft")),
    ("f 5", lambda s: {**s, "f": 5}),
    ("no friction", lambda s: {**s, "friction": "none"}),
    ("joints 100 times as stiff", lambda s: {**s, "KL": 100 * s["KL"]}),
    ("joints 1e-3 times as stiff", lambda s: {**s, "KL": 1e-3 * s["KL"]}),
    ("mats 1e-3 times as heavy", lambda s: {**s, "W": 1e-3 * s["W"]}),
    ("2,000 mats", lambda s: {**s, "N": 2000}),
    ("one mat", lambda s: {**fewer(s, "u_mats"), "N": 1, "path": [[0, 0.1, 0], [0.05, 0.1, 20], [0.3, 0.1, 20], [0.3, 0.1, 0]]}),
    ("joints of paper (tear 1 lb)", lambda s: {**s, "tear": 1}),
    ("cleats that hold 1e4 lb", lambda s: {**s, "cleat_every": 6, "cleat_hold": 1e4}),
    ("bands 1e3 times as stiff", lambda s: {**s, "bands": 490, "band_T0": 1e5}),
]

# Likewise of a study: of its file.
STUDY_EXTREMES = [
    ("as it is", lambda c: c),
    ("50 landings", lambda c: {**c, "landings": [{"deceleration_ft_s2": [4, 4.6], "times": 50}]}),
    ("2,000 mats, landings at 80 ft/s", lambda c: {**c, "scene": {**c["scene"], "N": 2000}, "landings": [{"speed_ft_s": 80, "deceleration_ft_s2": 7, "times": 3}]}),
    ("ground 1e4 times as stiff", lambda c: {**c, "elastic": {**c["elastic"], "gear_k_lb_ft": 7e7}}),
    ("load 0", lambda c: {**c, "elastic": {**c["elastic"], "wheel_load": 0}}),
    ("load 10 times", lambda c: {**c, "elastic": {**c["elastic"], "wheel_load": 1083}}),
    ("gear of 10 times the weight, load with it", lambda c: {**c, "aircraft": {"weight_lb": 13000}, "elastic": {**c["elastic"], "wheel_load": 1083}}),
    ("heights 10 times", lambda c: {**c, "runway": {"irregularity_in": [0, 0.43]}}),
]


def run(command):
    """Exit status, what it says, its error in one line, seconds of processor time."""
    before = os.times()
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=20 * MINUTE_S)
    after = os.times()
    took_s = after.children_user + after.children_system - before.children_user - before.children_system
    said = json.loads(done.stdout) if done.stdout.startswith("{") else {}
    return done.returncode, said, " ".join(done.stderr.split()), took_s


def last_u_ft(said):
    return max((abs(u) for out in said.get("outputs", []) for u in out["u_ft"].values()), default=math.nan)


def reason_of(said, errors):
    text = said.get("error") or errors
    if isinstance(text, dict):
        text = text.get("text", "")
    return text.replace("|", "/")[:160]


def scene_rows(matrig, scenes, folder, wrong):
    for file in ("model_runway_gear.json",):
        with open(os.path.join(scenes, file), encoding="utf-8") as source:
            base = json.load(source)
        for model in ("chain", "consistent"):
            heights = {} if model == "chain" else {"I": 1.19e-4, "KV": 1.3e4, "CV": 60, "KT": 41.6, "CT": 1.57e-4, "TAD_deg": 7, "profile": "full",
                                                  "ground": [0.001 * ((7 * j * j + 3 * j) % 11) / 11 for j in range(base["N"] + 1)]}
            for name, change in SCENE_EXTREMES:
                scene = change({**base, **heights, "model": model, "name": name})
                if model == "consistent":
                    scene["ground"] = [0.001 * ((7 * j * j + 3 * j) % 11) / 11 for j in range(scene["N"] + 1)]
                path = os.path.join(folder, "scene.json")
                with open(path, "w", encoding="utf-8") as out:
                    json.dump(scene, out)
                status, said, errors, took_s = run([matrig, "--json", "--quiet", "sim", path, "--limit", str(MINUTE_S)])
                answered = status == 0 and said.get("status") == "ok"
                u_ft = last_u_ft(said)
                error_ft = said.get("error_estimate", {}).get("u_ft")
                what = f"{model}, {name}"
                if answered and not (math.isfinite(u_ft) and error_ft is not None and math.isfinite(error_ft)):
                    wrong.append(f"{what}: no finite answer")
                if not answered and (status != NUMERICS and name != NONSENSE or not reason_of(said, errors)):
                    wrong.append(f"{what}: neither an answer nor a reason: {reason_of(said, errors)}")
                if took_s > MINUTE_S + 5.0:
                    wrong.append(f"{what}: {took_s:.0f} s")
                # An axle's thrust, 13.5 lb, is below what its weight holds by friction, 54 lb; where mats heave, joints turn and shorten a little.
                still = name in ("ground rigid (1e10 times)", "k 0, no lines: Coulomb's law under the wheel")
                if still and not u_ft < (1e-6 if model == "chain" else 1e-3):
                    wrong.append(f"{what}: {u_ft:.3g} ft, and nothing should move")
                yield (model, name, "answered" if answered else said.get("status", "refused"), u_ft, error_ft, took_s,
                       "" if answered else reason_of(said, errors))


def study_rows(matrig, series, folder, wrong):
    with open(os.path.join(series, "standard.json"), encoding="utf-8") as source:
        base = json.load(source)
    for key in ("scene", "elastic"):
        with open(os.path.join(series, base[key]), encoding="utf-8") as source:
            base[key] = json.load(source)
    for name, change in STUDY_EXTREMES:
        study = {**change(base), "seeds": 2, "name": name}
        path = os.path.join(folder, "study.json")
        with open(path, "w", encoding="utf-8") as out:
            json.dump(study, out)
        status, said, errors, took_s = run([matrig, "--json", "--quiet", "study", path, "--ground", "elastic"])
        runs = said.get("runways", [])
        landings = sum(len(r.get("landings", [])) for r in runs)
        most_in = max((landing.get("peak_in", math.nan) for r in runs for landing in r.get("landings", [])), default=math.nan)
        if status not in (0, NUMERICS):
            wrong.append(f"study, {name}: {reason_of(said, errors)}")
        if took_s / max(landings, 1) > MINUTE_S:
            wrong.append(f"study, {name}: {took_s:.0f} s for {landings} landings")
        yield name, status, landings, sum(1 for r in runs if r.get("buckled_landing")), most_in, took_s, "" if status == 0 else reason_of(said, errors)


def number(value, form):
    return format(value, form) if value is not None and math.isfinite(value) else ""


def main():
    matrig, scenes, series, folder = sys.argv[1:]
    os.makedirs(folder, exist_ok=True)
    wrong, lines = [], []
    lines.append("| model | what | outcome | largest u, ft | stated error, ft | processor s | reason |")
    lines.append("|---|---|---|---|---|---|---|")
    for model, name, outcome, u_ft, error_ft, took_s, reason in scene_rows(matrig, scenes, folder, wrong):
        lines.append(f"| {model} | {name} | {outcome} | {number(u_ft, '.4g')} | {number(error_ft, '.2g')} | {took_s:.2f} | {reason} |")
        print(lines[-1], flush=True)
    lines += ["", "| series on elastic ground, 2 runways | landings played | buckled | largest movement, in | processor s | reason |", "|---|---|---|---|---|---|"]
    for name, _, landings, buckled, most_in, took_s, reason in study_rows(matrig, series, folder, wrong):
        lines.append(f"| {name} | {landings} | {buckled} | {number(most_in, '.3g')} | {took_s:.1f} | {reason} |")
        print(lines[-1], flush=True)
    with open(os.path.join(folder, "extremes.md"), "w", encoding="utf-8") as out:
        out.write("\n".join(lines) + "\n")
    for text in wrong:
        print("WRONG " + text, file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
