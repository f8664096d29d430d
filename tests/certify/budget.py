"""What the predictor costs in the dearest second of a landing, from the emulated board's profiles, counted as tests/budget.sh does: an
instruction 1.5 cycles, a divide or root of the floating-point unit 14, of 168 MHz."""
import re
import subprocess

STEP_S = 0.5
PARTS = re.compile(r"common/(predictor(_[a-z]+)?|matchain|zonescan|closure|runway|risk)\.c$|(firmware/predict|common/onboard/(predict_feed|release))\.c$")


def functions_of(elf):
    """Names of the predictor's functions."""
    out = subprocess.run(["arm-none-eabi-nm", "-l", elf], capture_output=True, text=True, check=True).stdout
    found = set()
    for line in out.splitlines():
        words = line.split()
        if len(words) >= 4 and words[1] in "tTwW" and PARTS.search(words[3].rsplit(":", 1)[0]):
            found.add(words[2])
    return found


def profile(path, functions):
    """Instructions of the predictor and of all, and divides."""
    mine = everything = divides = 0
    inside = False
    for line in open(path):
        words = line.split()
        if "floating point divide, root" in line:
            divides = int(words[0])
        if line.startswith("by function"):
            inside = True
        elif inside and words and words[0].isdigit():
            everything += int(words[0])
            if words[3].split(".")[0] in functions or words[3] in functions:
                mine += int(words[0])
    return mine, everything, divides


def dearest(board, options, from_s, to_s, out):
    """Percent of 168 MHz in the dearest second: the predictor's with all divides, and of all tasks."""
    functions = functions_of(options[options.index("--elf") + 1])
    at = options.index("--for")
    options = options[:at] + options[at + 2:]
    counts, until_s = [], from_s
    while until_s <= to_s:
        path = out + "/profile.txt"
        subprocess.run([board, *options, "--for", "%.3f" % until_s, "--profile", path], check=True, stderr=subprocess.DEVNULL)
        counts.append(profile(path, functions))
        until_s += STEP_S
    behind = round(1.0 / STEP_S)
    worst = worst_all = 0.0
    for before, now in zip(counts, counts[behind:]):
        mine, everything, divides = (b - a for a, b in zip(before, now))
        worst = max(worst, (1.5 * mine + 12.5 * divides) / 1.68e6)
        worst_all = max(worst_all, (1.5 * everything + 12.5 * divides) / 1.68e6)
    return worst, worst_all
