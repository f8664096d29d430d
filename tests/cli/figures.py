#!/usr/bin/env python3
"""The table of host/sim/FIGURES.md against what matrig sim says of the scenes now.

usage: figures.py MATRIG SCENES PAGE

Of each row: R* has the value that the page states, and reproduces the text or not, as the page states. Exit 1 when a row differs.
"""
import json
import os
import re
import subprocess
import sys
import tempfile

APART = 0.006  # of a value that has three digits
FEW = 300  # times at which a rise is looked for
RISEN_FT = 0.05


class Scenes:
    def __init__(self, matrig, folder):
        self.matrig, self.folder, self.answers = matrig, folder, {}

    def run(self, name, **other):
        """The answer for a scene, with other values of some keys."""
        key = (name, json.dumps(other))
        if key not in self.answers:
            with open(os.path.join(self.folder, name + ".json")) as file:
                scene = {**json.load(file), **other}
            with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
                json.dump(scene, file)
                file.flush()
                told = subprocess.run([self.matrig, "--json", "sim", file.name], stdout=subprocess.PIPE, check=True).stdout
            self.answers[key] = {**json.loads(told), "threshold": max(RISEN_FT, 2 * max(scene.get("bump", [0])))}
        return self.answers[key]

    def u(self, name, mat, at):
        return self.run(name)["outputs"][at]["u_ft"][str(mat)]

    def last(self, name):
        return max(abs(out["u_ft"][str(len(out["u_ft"]))]) for out in self.run(name)["outputs"])

    def falls(self, name):
        u = [out["u_ft"]["4"] for out in self.run(name)["outputs"]]
        return max(before - after for before, after in zip(u, u[1:]))

    def lift(self, name, at):
        return self.run(name)["outputs"][at]["lift_ft"]

    def peak(self, name, **other):
        return self.run(name, **other)["max_lift_ft"]

    def bow(self, name, **other):
        return self.peak(name, **other) / self.run(name, **other)["threshold"]

    def stands(self, name):
        return self.lift(name, -1) / self.peak(name)

    def rises(self, name, **other):
        end = self.run(name)["t_end_s"]
        outs = self.run(name, t_out=[0.9999 * end * (i + 1) / FEW for i in range(FEW)], **other)["outputs"]
        late = next(i for i, out in enumerate(outs) if out["lift_ft"] >= RISEN_FT)
        a, b = outs[late - 1], outs[late]
        return a["t_s"] + (b["t_s"] - a["t_s"]) * (RISEN_FT - a["lift_ft"]) / (b["lift_ft"] - a["lift_ft"])

    def spread(self, *names):
        peaks = [self.peak(name) for name in names]
        return min(peaks) / max(peaks)


def values(s):
    """What each row of the page is about, in its order."""
    tight = {"KL": 16e6}
    f36, f37, f38 = "rstar_fig3_6", "rstar_fig3_7", "rstar_fig3_8_stiff"
    middle, soft, t311 = "rstar_fig3_8_middle", "rstar_fig3_8_soft", "rstar_fig3_11_12000"
    f395, f399, f3105, f3109 = "rstar_fig3_9_f05", "rstar_fig3_9_f09", "rstar_fig3_10_f05", "rstar_fig3_10_f09"
    tad10 = "rstar_fig3_12_tad10"
    return [
        s.u(f36, 4, 2), s.u(f37, 4, 2), s.u(middle, 12, 0), s.u(middle, 16, 0), s.u(middle, 17, 0), s.u(tad10, 4, 3),
        max(s.last(f36), s.last(f37)), max(s.falls(name) for name in (f36, f37, tad10)),
        s.bow(f36), s.bow(f37), s.peak(f36), s.peak(f37), s.rises(f37) / s.rises(f36), s.lift(f36, 2) / s.lift(f37, 2), s.stands(f36), s.stands(f37),
        s.bow(f38), s.lift(soft, 1), s.peak(f38) / s.peak(f37), s.rises(f37) / s.rises(f38),
        s.bow(f395), s.peak(f399) / s.peak(f395), s.u(f399, 4, 2) / s.u(f395, 4, 2), s.bow(f3105), s.peak(f3109) / s.peak(f3105),
        s.bow("rstar_fig3_11_6000"), s.lift(t311, 2), s.lift("rstar_fig3_11_24000", 2), s.bow(t311, **tight), s.rises(t311) / s.rises(t311, **tight),
        s.bow(tad10), s.stands(tad10), s.bow("rstar_fig3_12_tad1"),
        s.bow("full_width_144000"), s.bow("full_width_40000"), s.bow("full_width_36000"), s.peak("rstar_flat"),
        s.spread("rstar_soil_soft", "rstar_soil_hard", "rstar_soil_loose", "rstar_soil_dull"),
        s.peak("rstar_wide") / s.peak(t311), s.spread("rstar_velocity_60", "rstar_velocity_140"),
    ]


def reproduces(row, text, value):
    """Whether a value is what the column `text` asks for: a number within 2 %, or a bound."""
    words = text.split()
    if "factor of 2" in row or "2.5 to 3.5" in row:
        factor = 2 if "factor of 2" in row else 3.5 / 3
        return (float(text) / factor if factor == 2 else 2.5 / 12) <= value <= float(text) * factor
    if words[:2] == ["at", "most"]:
        return value <= float(words[2])
    if words[:2] == ["at", "least"]:
        return value >= float(words[2])
    if len(words) == 3:
        return float(words[0]) <= value <= float(words[2])
    return float(text) / 1.02 <= value <= float(text) * 1.02


def main(matrig, scenes, page):
    with open(page) as file:
        table = file.read().split("<!-- numbers: ")[1].split("<!-- end of numbers -->")[0]
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines() if re.match(r"\| \d", line)]
    found = values(Scenes(matrig, scenes))
    wrong = [] if len(rows) == len(found) else [f"{len(rows)} rows, {len(found)} known"]
    for row, value in zip(rows, found):
        said, holds = float(row[5]), reproduces(row[3], row[4], value)
        print(f"{row[0]}: {value:.4g}, {'reproduced' if holds else 'not reproduced'}")
        if abs(value - said) > APART * abs(said) + 1e-12 or holds != (row[9] in ("both", "R*")):
            wrong.append(f"row {row[0]}, {row[3]}: {value:.4g}, the page says {row[5]}, reproduced by {row[9]}")
    if wrong:
        print(*wrong, sep="; ", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
