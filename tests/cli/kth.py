"""kth.py FOLDER: TAP of commands of which one call of the system fails (tests/link/kth.c): each call of write, sync, rename, open and mmap in
turn, or with FEW=yes the first, the last and some between. FOLDER holds base.db, a campaign; can, a log of another landing; keys, readings.

A command either succeeds with all of its result, or ends with an error of one line; the campaign opens, is sound and has all it had before;
an output is there as a whole, as it was before, or not at all."""
import collections
import concurrent.futures
import errno
import os
import random
import re
import shutil
import sqlite3
import struct
import subprocess
import sys
import tempfile

MATRIG = os.path.abspath("build/matrig")
SHIM = os.path.abspath("build/tests/link/kth.so")
FOLDER = os.path.abspath(sys.argv[1])
FEW = bool(os.environ.get("FEW"))
EVERY = 300  # of a kind with more calls than this: the first and last 50, and as many drawn
NUMBERS = {"write": (errno.EIO, errno.ENOSPC), "sync": (errno.EIO,), "rename": (errno.EIO,), "open": (errno.EIO,), "mmap": (errno.ENOMEM,)}
COMMANDS = {  # words; standard input; outputs
    "log": ("log --can file:can --db base.db", None, ()),
    "log-new": ("log --can file:can --db new.db", None, ("new.db",)),
    "import": ("import base.db can", None, ()),
    "survey": ("survey base.db --edges none", "keys", ()),
    "note": ("landing base.db 1 --note wet --who kl", None, ()),
    "report": ("report base.db -o page.html", None, ("page.html",)),
    "bundle": ("bundle base.db 1 -o one.db", None, ("one.db",)),
    "csv": ("export base.db 1 --format csv -o one.csv", None, ("one.csv",)),
    "mdf4": ("export base.db 1 --format mdf4 -o one.mf4", None, ("one.mf4",)),
}
TIMES = re.compile("(_us|^pid|^who|^can_link|^reason)$")  # columns that another run has otherwise


def rows_of(path):
    """Of each table its rows, without the times of this computer, as texts and how often each is there; a journal counts."""
    db = sqlite3.connect(path)
    try:
        if db.execute("PRAGMA integrity_check").fetchall() != [("ok",)]:
            raise ValueError("integrity_check")
        found = {}
        for (table,) in db.execute("SELECT name FROM sqlite_schema WHERE type='table' AND name NOT LIKE 'sqlite%'").fetchall():
            names = [c[1] for c in db.execute(f"PRAGMA table_info({table})") if c[1] == "board_us" or not TIMES.search(c[1])]
            found[table] = collections.Counter(repr(r) for r in db.execute("SELECT %s FROM %s" % (", ".join('"%s"' % n for n in names), table)))
        return found
    finally:
        db.close()


def text_of(path):
    with open(path, "rb") as file:
        return re.sub(rb"(?m)^.*<dt>made<.*$", b"", file.read())


class Trial:
    def __init__(self, name, kind="none", k=0, number=0):
        self.folder = tempfile.mkdtemp(dir=FOLDER)
        words, keys, self.outputs = COMMANDS[name]
        for file in ("base.db", "can"):
            shutil.copy(os.path.join(FOLDER, file), self.folder)
        if name == "report":
            with open(os.path.join(self.folder, "page.html"), "w") as old:
                old.write("an older page")
        count = os.path.join(self.folder, "count")
        with open(count, "wb") as file:
            file.write(bytes(8))
        environment = {**os.environ, "LD_PRELOAD": SHIM, "KTH": "%s:%d:%d" % (kind, k, number), "KTH_COUNT": count, "LC_ALL": "C", "TMPDIR": self.folder}
        with open(os.path.join(FOLDER, keys) if keys else os.devnull) as stdin:
            done = subprocess.run([MATRIG, "--quiet"] + words.split(), cwd=self.folder, env=environment, stdin=stdin, capture_output=True, timeout=120)
        self.code, self.out, self.err = done.returncode, done.stdout.decode(errors="replace"), done.stderr.decode(errors="replace")
        with open(count, "rb") as file:
            self.calls = struct.unpack("q", file.read())[0]

    def again(self, name):
        """The exit code of the same command without a fault, on what this one left."""
        return subprocess.run([MATRIG, "--quiet"] + COMMANDS[name][0].split(), cwd=self.folder, stdin=subprocess.DEVNULL, capture_output=True, timeout=120).returncode

    def result(self):
        """All that it left: of campaigns the rows, of other outputs the bytes; None: not there."""
        left = {}
        for file in ("base.db",) + self.outputs:
            path = os.path.join(self.folder, file)
            left[file] = None if not os.path.exists(path) else rows_of(path) if file.endswith(".db") else text_of(path)
        return left

    def remove(self):
        shutil.rmtree(self.folder)


def lacks(part, whole):
    """A table of which `part` has a row that `whole` has not; both by rows_of."""
    for table, rows in part.items():
        for row in rows - whole.get(table, collections.Counter()):
            return "%s: %s" % (table, row[:300])
    return None


def fault(name, trial, known, before):
    """What is wrong with a trial; None: nothing."""
    try:
        left = trial.result()
    except (sqlite3.Error, ValueError) as wrong:
        return "the campaign: %s" % wrong
    if trial.code < 0 or trial.code > 5:
        return "exit %d" % trial.code
    strange = [f for f in os.listdir(trial.folder) if "matrig" in f or "making" in f]
    if strange:
        return "left behind: %s" % strange
    gone = lacks(before, left["base.db"])
    if gone:
        return "lost of what was there: %s" % gone
    if trial.code == 0:
        for file, now in left.items():
            if now != known[file]:
                return "exit 0, and %s is not whole" % file
        return None
    if not re.search("(?m)^matrig: .+; .+", trial.err):
        return "exit %d without an error" % trial.code
    if not name.startswith("log") and trial.err.count("\n") != 1:
        return "more than one line"
    if name == "log-new" and trial.again(name) != 0:
        return "what it left takes no log"
    for file in trial.outputs:
        if file != "new.db" and left[file] not in (None, known[file], b"an older page"):
            return "half of %s" % file
    return None


def places(calls, draw):
    if FEW:
        return sorted({1, calls // 2, calls} & set(range(1, calls + 1)))
    if calls <= EVERY:
        return range(1, calls + 1)
    return sorted({*range(1, 51), *range(calls - 49, calls + 1), *draw.sample(range(51, calls - 49), 50)})


def one(name, kind, k, number, known, before):
    trial = Trial(name, kind, k, number)
    wrong = fault(name, trial, known, before)
    told = trial.err.strip().split("\n")[-1] if trial.code else ""
    text = None if wrong is None else "%s %s %d %s: %s; exit %d: %s" % (name, kind, k, errno.errorcode[number], wrong, trial.code, trial.err.strip()[-600:])
    trial.remove()
    return trial.code, told, text


def told_kinds(lines):
    """The messages, without paths and numbers, with how often each was given."""
    kinds = {}
    for line in lines:
        line = re.sub(r"/\S+|\S+\.(db|html|csv|mf4)\S*", "FILE", re.sub(r"\d+", "N", line))
        kinds[line] = kinds.get(line, 0) + 1
    return sorted(kinds.items(), key=lambda item: -item[1])


def main():
    draw, test = random.Random(33), 0
    before = rows_of(os.path.join(FOLDER, "base.db"))
    pool = concurrent.futures.ProcessPoolExecutor(os.cpu_count() + 1)
    for name in os.environ.get("COMMANDS", " ".join(COMMANDS)).split():
        plain = Trial(name)
        known = plain.result()
        assert plain.code == 0, (name, plain.err)
        plain.remove()
        for kind, numbers in NUMBERS.items():
            counted = Trial(name, kind)
            calls = counted.calls
            counted.remove()
            tried = [pool.submit(one, name, kind, k, n, known, before) for k in places(calls, draw) for n in numbers]
            done = [t.result() for t in tried]
            wrong = [text for _, _, text in done if text]
            failed = [told for code, told, _ in done if code]
            test += 1
            print("%sok %d - %s: %s fails, %d calls, %d trials, %d ended by an error" % ("not " if wrong else "", test, name, kind, calls, len(done), len(failed)))
            for text in wrong[:int(os.environ.get("SHOWN", "5"))]:
                print("# " + text.replace("\n", "\n#   "))
            if wrong:
                print("# %d wrong" % len(wrong))
            if os.environ.get("TOLD"):
                for line, count in told_kinds(failed):
                    print("#   %d times: %s" % (count, line))
            sys.stdout.flush()
    print("1..%d" % test)


main()
