#!/usr/bin/env python3
"""The certification: every case of cases.txt on the emulated board, with the firmware image as it is, held against its bounds.

usage: certify.py [--image ELF] [--out FOLDER] [--page] [NAME...]     from the sources' root; NAMEs: these cases alone, and no sums

Writes FOLDER/table.md (build/certify) and, with --page, from it docs/measured/certification.md. Exit: 0; 1 a bound does not hold; 2 usage;
3 a case could not be played. What a case is made of, and what its words mean, says cases.txt.
"""
import argparse
import datetime
import json
import os
import sqlite3
import subprocess
import sys
import time

sys.path.insert(0, os.path.dirname(__file__))
import budget
import runs

MATRIG, BOARD, AGAIN = "build/matrig", "build/matrig-board", "build/tests/again/again"
CASES = "tests/certify/cases.txt"
PAGE = "docs/measured/certification.md"
AFTER_S = 1.2  # the board keeps the runway within that time after a run of tests/runs
# common/fault.h: scans stopped, overran, blocks late, excitation wrong, edges lost, a reset, a task late
FAULTS = "6, 7, 8, 9, 10, 19, 20, 29"


class Failed(Exception):
    """A case that could not be played."""


def call(*words, ok=(0,), **more):
    done = subprocess.run(words, capture_output=True, text=True, check=False, **more)
    if done.returncode not in ok:
        raise Failed("%s: exit %d: %s" % (" ".join(words[:4]), done.returncode, done.stderr.strip()[-300:]))
    return done.stdout


class Case:
    """A row of cases.txt: name | board | run | made | wanted."""

    WORDS = ("quiet", "warned", "missed-today", "false-today", "unsame")
    NUMBERED = ("by", "after", "lead", "pushed", "budget")

    def __init__(self, line):
        parts = [part.strip() for part in line.split("|")]
        if len(parts) != 5 or len(parts[2].split()) != 2:
            raise ValueError("not `name | board | series N | made | wanted`")
        self.name, self.board, run, made, wanted = parts
        self.series, self.number = run.split()
        self.made = [] if made == "-" else made.split(";")
        self.wanted = wanted.split()
        self.check()

    def check(self):
        """A word that nobody knows would be a bound that cannot fail."""
        words = list(self.wanted)
        if self.board not in ("fresh", "next"):
            raise ValueError("a board is fresh or next, not `%s`" % self.board)
        if not self.number.isdigit() or not any(word in words for word in self.WORDS + self.NUMBERED[:3]):
            raise ValueError("nothing is wanted, or no landing is named")
        while words:
            word = words.pop(0)
            if word in self.NUMBERED:
                try:
                    float(words.pop(0))
                except (IndexError, ValueError):
                    raise ValueError("`%s` needs a number" % word) from None
            elif word not in self.WORDS:
                raise ValueError("nobody knows what `%s` wants" % word)

    def option(self, key):
        """Values of `key=VALUE` among what the run is made with."""
        return [word.strip().split("=", 1)[1] for word in self.made if word.strip().startswith(key + "=")]

    def limit(self, key):
        """The number behind a word of what is wanted; None: it is not there."""
        return float(self.wanted[self.wanted.index(key) + 1]) if key in self.wanted else None


def read_cases():
    cases, sums = [], []
    for number, line in enumerate(open(CASES), 1):
        if not line.strip() or line.startswith("#"):
            continue
        if line.startswith("sum "):
            sums.append(line.split()[1:])
            continue
        try:
            cases.append(Case(line))
        except ValueError as error:
            print("certify: %s:%d: %s" % (CASES, number, error), file=sys.stderr)
            sys.exit(2)
    return cases, sums


class Bench:
    """One emulated board with its memories, and the folder where everything lies."""

    def __init__(self, image, out):
        self.image, self.out = image, out
        self.flash, self.nor = out + "/flash.bin", out + "/nor.bin"
        self.configured = {}

    def talk(self, *words):
        """A board with its flash, and matrig talking to it."""
        sock = self.out + "/board.sock"
        if os.path.exists(sock):
            os.unlink(sock)
        board = subprocess.Popen([BOARD, "--elf", self.image, "--serial", "unix:" + sock, "--flash", self.flash],
                                 stderr=subprocess.DEVNULL)
        try:
            return call(MATRIG, "board", "--serial", "unix:" + sock, *words)
        finally:
            board.terminate()
            board.wait()

    def configure(self, settings):
        """A blank board with these fields; made once for the same ones."""
        for path in (self.flash, self.nor):
            if os.path.exists(path):
                os.unlink(path)
        key = json.dumps(sorted(settings.items()))
        if not settings:
            return
        if key not in self.configured:
            got, wanted = self.out + "/built-in.cfg", self.out + "/wanted.cfg"
            self.talk("config", "get", "-o", got, "--force")
            lines, left = open(got).read().splitlines(), dict(settings)
            for i, line in enumerate(lines):
                name = line.split(" ", 1)[0]
                if name in left:
                    lines[i] = "%s = %s" % (name, left.pop(name))
            if left:
                raise Failed("no such field of the configuration: %s" % ", ".join(left))
            open(wanted, "w").write("\n".join(lines) + "\n")
            self.talk("config", "set", wanted)
            self.configured[key] = open(self.flash, "rb").read()
        open(self.flash, "wb").write(self.configured[key])


def settings_of(case):
    settings = {}
    path = "build/certify/land/%s.set" % case.series
    if os.path.exists(path):
        settings.update(line.split(" = ") for line in open(path).read().splitlines())
    for pair in case.option("config"):
        name, value = pair.split(":", 1)
        settings[name] = value
    return settings


def write_run(case, path):
    source = ("build/runs/landing%s.run" % case.number if case.series == "standard" else
              "build/certify/land/%s-%s.run" % (case.series, case.number))
    run = runs.Run(source)
    for word in case.made:
        run.change(word.strip())
    run.write(path)
    return run


def play(bench, case):
    """Plays and logs it; the run, the file of the campaign and the options the board had."""
    at = "%s/%s" % (bench.out, case.name)
    run = write_run(case, at + ".run")
    if case.board == "fresh":
        bench.configure(settings_of(case))
    for offset in case.option("memory"):  # a byte of the runway's copies
        with open(bench.nor, "r+b") as nor:
            nor.seek(int(offset, 0))
            nor.write(b"\x55")
    image = "build/tests/variant/%s.elf" % case.option("image")[0] if case.option("image") else bench.image
    faults = case.option("fault")
    if faults:
        open(at + ".faults", "w").write("matrig-faults 1\n" + "\n".join(faults) + "\n")
    options = ["--elf", image, "--rig", at + ".run", "--for", "%.3f" % (run.duration_s() + AFTER_S), "--seed", (case.option("seed") or ["1"])[0]]
    options += ["--faults", at + ".faults"] if faults else []
    options += ["--board-seed", case.option("board-seed")[0]] if case.option("board-seed") else []
    links = ["--can", "file:%s.can" % at, "--serial", "file:%s.serial" % at]
    call(BOARD, *options, "--flash", bench.flash, "--nor", bench.nor, *links)
    db = at + ".db"
    for ending in ("", "-wal", "-shm"):
        if os.path.exists(db + ending):
            os.unlink(db + ending)
    call(MATRIG, "--quiet", "log", *links, "--db", db, ok=(0, 1, 4))
    return run, db, options


def look(run, db):
    """What the campaign says of its landing, as a dictionary."""
    seen = {}
    show = json.loads(call(MATRIG, "--json", "show", db, "1"))
    again = json.loads(call(AGAIN, db, "1", ok=(0, 1, 5)) or "{}")
    with sqlite3.connect(db) as base:
        ask = lambda sql: base.execute(sql).fetchone()[0]
        block = ask("select min(block) from zones where landing = 1 and warning = 1")
        seen["blocks"] = ask("select count(*) from blocks where landing = 1")
        seen["holes"] = ask("select coalesce(max(idx) - min(idx) + 1 - count(*), -1) from blocks where landing = 1")
        seen["pushed"] = ask("select count(*) from events where kind = 'pushback'")
        seen["faults"] = ask("select count(*) from events where kind = 'crash' or (kind = 'fault' and code in (%s))" % FAULTS)
        seen["risk"] = ask("select max(risk) from risks where landing = 1")
    seen["warned_s"] = None if block is None else show["zone"]["t_s"]  # after touchdown, by the board's clock
    seen["same"] = bool(again.get("possible")) and again.get("differ") == 0 and again.get("statements", 0) > 20
    seen["statements"] = again.get("statements", 0)
    seen["mats"], event_s = run.truth()
    seen["event_s"] = None if event_s is None else event_s - run.touchdown_s()
    seen["lead_s"] = None if block is None or seen["event_s"] is None else seen["event_s"] - seen["warned_s"]
    return seen


def judge(case, seen):
    """Why it does not hold; an empty list: it holds."""
    wrong = []
    if "quiet" in case.wanted and seen["warned_s"] is not None:
        wrong.append("warned")
    if "warned" in case.wanted and seen["warned_s"] is None:
        wrong.append("not warned")
    for key, value, beyond in (("by", seen["warned_s"], 1), ("after", seen["warned_s"], -1), ("lead", seen["lead_s"], -1), ("pushed", seen["pushed"], -1)):
        limit = case.limit(key)
        if limit is not None and (value is None or beyond * (value - limit) > 0):
            wrong.append("%s %s, bound %g" % (key, "none" if value is None else "%.2f" % value, limit))
    if "unsame" not in case.wanted and not seen["same"]:
        wrong.append("the host computes something else")
    if seen["holes"] != 0:
        wrong.append("%d blocks lost" % seen["holes"])
    if seen["faults"]:
        wrong.append("%d faults of the firmware" % seen["faults"])
    limit = case.limit("budget")
    if limit is not None and not 0 < seen["budget"][0] <= limit:
        wrong.append("predictor %.1f %% of a second" % seen["budget"][0])
    return wrong


def certify(bench, case):
    run, db, options = play(bench, case)
    seen = look(run, db)
    if "budget" in case.wanted:
        seen["budget"] = budget.dearest(BOARD, options, run.touchdown_s(), run.duration_s(), bench.out)
    return seen, judge(case, seen)


def number(value, form):
    return "" if value is None else form % value


def row(case, seen, wrong):
    """A line of the page. What a damaged landing is made of stands in cases.txt."""
    load = seen.get("budget")
    cells = [case.name, number(seen["mats"], "%d"), number(seen["event_s"], "%.2f"), number(seen["warned_s"], "%.2f"), number(seen["lead_s"], "%.2f"),
             number(seen["risk"], "%.2f"), number(load and load[0], "%.1f"), " ".join(case.wanted) + (" **failed: %s**" % "; ".join(wrong) if wrong else "")]
    return "| " + " | ".join(cells) + " |"


def add_up(results):
    """Sums over the cases whose truth is known and that were not damaged."""
    sums = dict.fromkeys(("hits", "misses", "false", "silences"), 0)
    leads = []
    for case, seen, _ in results:
        if case.made or seen["mats"] is None:
            continue
        came = seen["mats"] >= 50
        sums[("hits" if came else "false") if seen["warned_s"] is not None else "misses" if came else "silences"] += 1
        if came and seen["lead_s"] is not None:
            leads.append(seen["lead_s"])
    leads.sort()
    sums["median"] = leads[len(leads) // 2] if leads else 0.0
    sums["in_time"] = sum(lead >= 0.5 for lead in leads)
    return sums


def judge_sums(sums, bounds):
    rows, wrong = [], 0
    for name, relation, limit in bounds:
        good = sums[name] >= float(limit) if relation == ">=" else sums[name] <= float(limit)
        wrong += not good
        rows.append("| %s | %g | %s %s%s |" % (SUMS[name], round(sums[name], 3), relation, limit, "" if good else " **failed**"))
    return rows, wrong


HEAD = """| Case | True zone (mats) | Reached (s) | Warned (s) | Lead (s) | Peak risk | Load (%) | Bound |
|---|--:|--:|--:|--:|--:|--:|---|"""
SUMS = {"hits": "hits", "misses": "misses", "false": "false warnings", "silences": "correctly quiet", "in_time": "leads of 0.5 s or more", "median": "median lead (s)"}


def commit():
    name = call("git", "log", "-1", "--format=%h", "--abbrev=7").strip()
    return name + (" with changes" if call("git", "status", "--porcelain", "--untracked-files=no").strip() else "")


def condensed(table, damaged):
    """The table for the page: cases that failed, or had a short lead. Cases that had to be quiet and were, DAMAGED ones that met their bound,
    long leads and loads are a sentence each; build/certify/table.md has all of them."""
    kept, quiet, warned, leads, loads = [], [], [], [], []
    notes = {"missed-today": "known miss", "false-today": "known false warning"}
    for line in table.split("\n"):
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) != 8:
            kept.append(line)
            continue
        fine = "**" not in cells[7] and cells[7] not in notes
        if line in HEAD:
            kept.append("|".join(line.split("|")[:7]) + ("|---|" if "---" in line else "| Note |"))
        elif fine and cells[7].startswith("quiet"):
            quiet.append((float(cells[5] or 0.0), cells[0]))
        elif fine and cells[0] in damaged:
            warned.append((float(cells[3]), cells[0]))
        elif fine and cells[4] and float(cells[4]) >= 0.5:
            leads.append((float(cells[4]), cells[0]))
        else:
            kept.append("| " + " | ".join(cells[:6] + ["" if fine else notes.get(cells[7], cells[7])]) + " |")
        if cells[6] and line not in HEAD:
            loads.append(float(cells[6]))
    warned.sort()
    said = ("- %d cases had no warning, as required. The highest peak risk was %.2f (%s).\n- In %d cases the lead was 0.5 s or more, up to %.2f s (%s).\n"
            "- In %d cases of landing 5 with a fault, the warning came in time: %.2f s (%s) to %.2f s (%s) after touchdown.\n"
            "- %d cases check the processor load: the predictor took at most %.1f %% of the processor in any second.") % (
                len(quiet), *max(quiet), len(leads), *max(leads), len(warned), *warned[0], *warned[-1], len(loads), max(loads, default=0.0))
    return "\n".join(kept).replace("Sums over", said + "\nSums over", 1)


def write(path, text):
    with open(path, "w") as file:
        file.write(text)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--image", default="build/firmware/matrig.elf")
    parser.add_argument("--out", default="build/certify")
    parser.add_argument("--page", action="store_true")
    parser.add_argument("names", nargs="*")
    given = parser.parse_args()
    cases, bounds = read_cases()
    strangers = set(given.names) - {case.name for case in cases}
    if strangers:
        print("no such case: %s; %s has them" % (", ".join(sorted(strangers)), CASES), file=sys.stderr)
        return 2
    begun = time.time()
    os.makedirs("build/certify/land", exist_ok=True)
    os.makedirs(given.out, exist_ok=True)
    call("build/tests/certify/land", "build/certify/land")
    if not os.path.exists("build/runs/landing5.run"):
        os.makedirs("build/runs", exist_ok=True)
        call("build/tests/runs/synthesise", "build/runs")
    bench, results = Bench(given.image, given.out), []
    for case in cases:
        if given.names and case.name not in given.names:
            continue
        try:
            seen, wrong = certify(bench, case)
        except (Failed, ValueError, OSError) as failure:
            print("%s of %s: %s" % (case.name, CASES, failure), file=sys.stderr)
            return 3
        results.append((case, seen, wrong))
        print(row(*results[-1]), flush=True)
    failed = sum(bool(wrong) for _, _, wrong in results)
    table = HEAD + "\n" + "\n".join(row(*result) for result in results) + "\n"
    if not given.names:
        rows, wrong = judge_sums(add_up(results), bounds)
        failed += wrong
        table += "\nSums over all undisturbed landings:\n\n| | Result | Bound |\n|---|--:|---|\n" + "\n".join(rows) + "\n"
    same = [seen["statements"] for _, seen, _ in results if seen["same"]]
    table += "\n%d cases in %.0f min; %s. Host and board agree bit for bit in %d cases (%d reports).\n" % (
        len(results), (time.time() - begun) / 60, "**%d bounds failed**" % failed if failed else "all bounds hold", len(same), sum(same))
    write(given.out + "/table.md", table)
    if given.page and not given.names:
        page = open(PAGE).read() if os.path.exists(PAGE) else ""
        head = page.split("<!-- made by make certify -->")[0]
        stamp = "`make certify`, commit %s, %s:\n\n" % (commit(), datetime.date.today().isoformat())
        write(PAGE, head + "<!-- made by make certify -->\n\n" + stamp + condensed(table, {case.name for case in cases if case.made}))
    print(table[table.rindex("\n\n") + 2:] if given.names else table[table.index("\nSums over"):])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
