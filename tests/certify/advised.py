#!/usr/bin/env python3
"""The advice of `matrig advise` before each landing of the 1973 series as the certification has played them, beside the true zones.

usage: advised.py [--out FOLDER] [--page]     after certify.py, from the sources' root

A series is a campaign. Before each landing `advise` gets what was known then; the plan is the speed and the mean braking that the landing then had. Writes FOLDER/advised.md (build/certify) and, with --page, docs/measured/advised.md. Exit: 0; 2 usage; 3 a landing is missing.
"""
import argparse
import datetime
import json
import os
import subprocess
import sys

MATRIG = "build/matrig"
PAGE = "docs/measured/advised.md"
# series of cases.txt, with the number of landings
SERIES = [("standard", 5), ("grit", 4), ("bands-preliminary", 3), ("bands-off", 2), ("bands-detailed", 4), ("diagonal", 4), ("cleats", 6), ("stiffeners", 4)]
HEAD = """# Measured: advice before each landing of the 1973 series

This page shows the advice of `matrig advise --before RUN` for each landing of the series in [certification](certification.md). The landings are synthetic, with
decelerations from the 1973 report. The plan for `advise` consists of the measured speed and the mean braking of the landing. `advise` assumes that the braking stays within 10 %
of this mean. `advise` knows the friction, the survey and the earlier landings, but not the modification (bands, cleats, ...).

In 1973 these series buckled: standard in landing 5, grit in 4, cleats in 8, stiffeners in 4. In the other series, the mat did not buckle. Without bands
(series bands-off), the mat moved several times as far as with bands (sections 4.2 to 5.6). These outcomes are for comparison only, because the thrust, ground and mats of 1973 are
unknown.

The [demo](demo.md) has a lower probability for standard-5, because plan, landings and surveys differ.

"""


def call(*words, ok=(0,)):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode not in ok:
        sys.exit("advised: %s: exit %d: %s" % (" ".join(words[:4]), done.returncode, done.stderr.strip()[-300:]))
    return done.stdout


def truths(out):
    """Longest zone at the wheel by case, as the certification's table has it."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in open(out + "/table.md") if line.startswith("|")]
    return {row[0]: row[1] for row in rows if len(row) > 3}


def advised(db, run, row):
    """Cells of a landing: speed, deceleration, zone, verdict and hardest braking."""
    done = subprocess.run([MATRIG, "--quiet", "--json", "advise", db, "--before", str(run), "--speed", "%.4fft/s" % row["touchdown_speed_ft_s"],
                           "--deceleration", "%.4fft/s2" % row["mean_deceleration_ft_s2"]], capture_output=True, text=True, check=False)
    answer = json.loads(done.stdout)
    plan = ["%.1f" % row["touchdown_speed_ft_s"], "%.1f" % row["mean_deceleration_ft_s2"]]
    if done.returncode not in (0, 1):
        return plan + [answer["error"]["message"], "", ""]
    planned = [r for r in answer["rows"] if r.get("plan")][0]
    zone = "%.0f (%.0f to %.0f)" % (100 * planned["zone"], 100 * planned["zone_low"], 100 * planned["zone_high"])
    return plan + [zone, answer["verdict"], "%.1f" % answer["hardest_ft_s2"] if answer.get("hardest_ft_s2") else "none"]


parser = argparse.ArgumentParser(add_help=False)
parser.add_argument("--out", default="build/certify")
parser.add_argument("--page", action="store_true")
arguments = parser.parse_args()
true = truths(arguments.out)
lines = ["Zone: probability that the wheel reaches a zone of 50 mats, with the sampling interval in brackets. Hardest: hardest braking that keeps this probability below 20 %. The first landing "
         "of a series has no advice.", "",
         "| Landing | Speed (ft/s) | Braking (ft/s²) | Zone (%) | Advice | Hardest (ft/s²) | True zone (mats) |", "|---|--:|--:|--:|---|--:|--:|"]
for name, count in SERIES:
    db = "%s/series-%s.db" % (arguments.out, name)
    if os.path.exists(db):
        os.unlink(db)
    for run in range(1, count + 1):
        played = "%s/%s-%d" % (arguments.out, name, run)
        if not os.path.exists(played + ".serial"):
            sys.exit("advised: %s is missing; make certify plays it" % played)
        call(MATRIG, "--quiet", "log", "--can", "file:%s.can" % played, "--serial", "file:%s.serial" % played, "--db", db)
        row = json.loads(call(MATRIG, "--quiet", "--json", "show", db, str(run)))
        if run > 1:  # the first landing of a series has no runway to advise on
            lines.append("| %s-%d | %s | %s |" % (name, run, " | ".join(advised(db, run, row)), true["%s-%d" % (name, run)]))
            print(lines[-1], file=sys.stderr)
text = "\n".join(lines) + "\n"
open(arguments.out + "/advised.md", "w").write(text)
if arguments.page:
    commit = call("git", "describe", "--always", "--abbrev=7", "--exclude=*").strip()
    open(PAGE, "w").write(HEAD + "<!-- made by make advised -->\n\n`make advised PAGE=yes`, commit %s, %s\n\n%s"
                          % (commit, datetime.date.today(), text))
