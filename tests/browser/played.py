#!/usr/bin/env python3
"""played.py CAMPAIGN: the page docs/measured/demo.md, of the campaign that `make demo` leaves. Truths are those of the run files."""
import json
import os
import subprocess
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
WHAT = {1: "gentle", 4: "gentle", 5: "against the advice: 6.6 to 9.2 ft/s²", 6: "as advised: 6.5 ft/s²", 7: "8.5 ft/s² from touchdown"}
# of landing 5, whose file does not state it (tests/runs/README.md)
AT_50_S = {5: 2.751}


def answer(*words):
    return json.loads(subprocess.run([ROOT + "/build/matrig", "--json", "show", *words], check=True, capture_output=True).stdout)


def truth(landing):
    lines = [line.split() for line in open("%s/tests/runs/landing%d.run" % (ROOT, landing)) if line.startswith(("truth", "touchdown"))]
    given = {word[1]: float(word[2]) for word in lines if word[0] == "truth"}
    touchdown_s = next(float(word[2]) for word in lines if word[0] == "touchdown")
    at_s = AT_50_S.get(landing)
    if at_s is None and given.get("wheel_at_50_mats_t_s", -1.0) > 0.0:
        at_s = given["wheel_at_50_mats_t_s"] - touchdown_s
    mats = int(given["zone_ahead_longest_mats"])
    if mats >= 50 and at_s is None:
        sys.exit("landing %d: its truth has a zone of %d mats and no time" % (landing, mats))
    return mats, at_s


def main(db):
    campaign = answer(db)
    advice = subprocess.run(["sqlite3", "-separator", " ", db, "select verdict, zone, zone_low, zone_high, hardest_ft_s2, speed_ft_s, deceleration_ft_s2, "
                             "most from advices"], check=True, capture_output=True, text=True).stdout.split()
    p, low, high, hardest, speed, planned, limit = (float(word) for word in advice[1:])
    print("# Measured: the landings of the demo\n")
    print("`make demo` plays synthetic landings on the emulated board. `make pictures` generates this page.\n")
    print("Advice before landing 5 for a plan of %.1f ft/s and %.1f ft/s²: **%s**. The probability that the wheel reaches a zone of 50 closed mats is %.0f %% (95 %% interval: %.0f to %.0f %%); the limit\n"
          "is %.0f %%. At this speed, braking up to %.1f ft/s² keeps the probability below the limit.\n" % (speed, planned, advice[0], 100 * p, 100 * low, 100 * high, 100 * limit, hardest))
    print("| Landing | Touchdown speed (ft/s) | Mean deceleration (ft/s²) | Warning (s after touchdown) | Wheel truly reaches 50 closed mats (s after touchdown) | True lead (s) | Longest true zone ahead (mats) |")
    print("|---|--:|--:|--:|--:|--:|--:|")
    for row in campaign["landings"]:
        landing, one = row["landing"], answer(db, str(row["run"]))
        mats, at_s = truth(landing)
        warned = one["zone"]["t_s"] if one["zone"]["warned"] else None
        print("| %d, %s | %.3f ± %.3f | %.3f ± %.3f | %s | %s | %s | %d |" % (
            landing, WHAT[landing], one["touchdown_speed_ft_s"], one["touchdown_speed_error_ft_s"], one["mean_deceleration_ft_s2"],
            one["mean_deceleration_error_ft_s2"], "none" if warned is None else "%.2f" % warned, "never" if at_s is None else "%.2f" % at_s,
            "" if warned is None or at_s is None else "%.2f" % (at_s - warned), mats))
    w = campaign["record"]["warnings"]
    print("\n± is one standard error. Outcomes, determined from survey and transducers only (`matrig show`): %d warning in time, %d too late, %d missing, %d false; %d landings correctly quiet." % (
        w["hits"], w["late"], w["misses"], w["false"], w["silences"]))


main(sys.argv[1])
