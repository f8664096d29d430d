#!/usr/bin/env python3
"""What `matrig advise` would have said before each landing of 1973's series, as the certification has played them, beside what came.

usage: advised.py [--out FOLDER] [--page]     after certify.py, from the sources' root

A series is a campaign; before each landing it is asked with what was known then, and with the speed and the mean braking that the landing then
had as its plan. Writes FOLDER/advised.md (build/certify) and, with --page, docs/measured/advised.md. Exit: 0; 2 usage; 3 a landing is missing.
"""
import argparse
import datetime
import json
import os
import re
import subprocess
import sys

MATRIG = "build/matrig"
PAGE = "docs/measured/advised.md"
# series of cases.txt, and what the report says of them (page of the report)
SERIES = [
    ("standard", 5, "waves two panels long from landing 2 on; buckles on landing 5 at 85 and 91 (4.2, 4.3)"),
    ("grit", 4, "buckles on landing 4 at 93; about 40 rows tightly compressed (4.5, 5.4)"),
    ("bands-preliminary", 3, "no wave; 1/16 in of movement a landing where banded (5.1.2)"),
    ("bands-off", 2, "two landings after the bands came off: several times as much movement (5.1.2)"),
    ("bands-detailed", 4, "no buckling in 26 landings; 1/16 in of movement a landing (5.1.3)"),
    ("diagonal", 4, "no buckling in 16 landings; nearly 7 in of movement over 15 (5.3)"),
    ("cleats", 6, "very small movements for two landings, growing; buckles on landing 8 (5.5)"),
    ("stiffeners", 4, "compressed between 70 and 90 after the third landing; buckles on landing 4 (5.6)"),
]
HEAD = """# Measured: what `advise` would have said

The series of 1973 as [the certification](certification.md) plays them: synthetic landings on the emulated board, decelerations within what the report states, told friction and survey before each.
`matrig advise --before RUN` with 256 members; the plan is the speed and mean braking that the landing then had, met within 10 %. Truth is of the synthetic landing, whose mats are bound, stiffened or laid as the series says;
`advise` knows nothing of that but what landings have taught. 1973's outcome is no truth of these landings: thrust, ground and mats of then are not known.

"""


def call(*words, ok=(0,)):
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if done.returncode not in ok:
        sys.exit("advised: %s: exit %d: %s" % (" ".join(words[:4]), done.returncode, done.stderr.strip()[-300:]))
    return done.stdout


def truths(out):
    """Longest zone at the wheel by case, as the certification's table has it."""
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in open(out + "/table.md") if line.startswith("|")]
    return {row[0]: row[2] for row in rows if len(row) > 2}


def percent(chance, low, high):
    return "%.0f %% (%.0f to %.0f)" % (100 * chance, 100 * low, 100 * high)


def advised(db, run, row):
    """Cells of a landing: plan, zone, wave, verdict and hardest."""
    plan = "%.1f ft/s, %.1f ft/s2" % (row["touchdown_speed_ft_s"], row["mean_deceleration_ft_s2"])
    done = subprocess.run([MATRIG, "--quiet", "--json", "advise", db, "--before", str(run), "--speed", "%.4fft/s" % row["touchdown_speed_ft_s"],
                           "--deceleration", "%.4fft/s2" % row["mean_deceleration_ft_s2"]], capture_output=True, text=True, check=False)
    said = json.loads(done.stdout)
    if done.returncode not in (0, 1):
        return [plan, "nothing: the campaign has no runway yet" if run == 1 else said["error"]["message"], "", "", ""]
    planned = [r for r in said["rows"] if r.get("plan")][0]
    hardest = "%.1f ft/s2" % said["hardest_ft_s2"] if said.get("hardest_ft_s2") else "none"
    return [plan, percent(planned["zone"], planned["zone_low"], planned["zone_high"]),
            percent(planned["wave"], planned["wave_low"], planned["wave_high"]) if planned["wave"] is not None else "", said["verdict"], hardest]


parser = argparse.ArgumentParser(add_help=False)
parser.add_argument("--out", default="build/certify")
parser.add_argument("--page", action="store_true")
arguments = parser.parse_args()
true, lines = truths(arguments.out), []
for name, count, then in SERIES:
    db = "%s/series-%s.db" % (arguments.out, name)
    if os.path.exists(db):
        os.unlink(db)
    lines += ["## %s" % name.replace("-", ", "), "", "1973: %s." % then, "",
              "| landing | plan | said: zone of 50 mats | bow wave | verdict | hardest below 20 % | truth: longest zone at the wheel |", "|---|---|---|---|---|---|---|"]
    for run in range(1, count + 1):
        played = "%s/%s-%d" % (arguments.out, name, run)
        if not os.path.exists(played + ".serial"):
            sys.exit("advised: %s is missing; make certify plays it" % played)
        call(MATRIG, "--quiet", "log", "--can", "file:%s.can" % played, "--serial", "file:%s.serial" % played, "--db", db)
        row = json.loads(call(MATRIG, "--quiet", "--json", "show", db, str(run)))
        lines.append("| %d | %s | %s |" % (run, " | ".join(advised(db, run, row)), true["%s-%d" % (name, run)]))
        print(lines[-1], file=sys.stderr)
    lines.append("")
text = "\n".join(lines)
open(arguments.out + "/advised.md", "w").write(text)
if arguments.page:
    commit = call("git", "describe", "--always", "--abbrev=7", "--exclude=*").strip()
    open(PAGE, "w").write(HEAD + "<!-- made by make advised -->\n\n`make advised PAGE=yes`, commit %s, %s. All values are shown in the tables.\n\n%s"
                          % (commit, datetime.date.today(), re.sub(r"\n+$", "\n", text)))
