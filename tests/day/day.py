#!/usr/bin/env python3
"""A day at the runway, as a person has it: matrig day on a terminal, the emulated board beside it.

    day.py FOLDER LANDINGS [KILLS]

Plays a day of so many landings, killed (-9) at so many of the places in PLACES, each once, and begun again with the same
command. Then asks the campaign by SQLite: every reading that was typed is there once, every landing is whole, nothing was asked
twice. Prints keystrokes and seconds of each landing. Exit 1 when something is not so.
"""
import os, pty, re, select, signal, sqlite3, subprocess, sys, time

RUNS = ["landing1", "landing4", "landing5", "landing4", "landing5"]
# where it is killed: landing, and the place in it
PLACES = [(0, "series"), (0, "survey"), (0, "load"), (1, "log"), (1, "landing"), (1, "look"), (2, "survey"), (2, "advise"),
          (3, "ready"), (4, "landing")]
PROMPT = "q leave > "
ASKED = r"\d+/(\d+)  "  # of a reading


class Board:
    """The emulated board: at rest, or with a landing."""

    def __init__(self, folder):
        self.folder, self.process = folder, None

    def play(self, rig, *more):
        self.stop()
        self.process = subprocess.Popen(
            ["build/matrig-board", "--flash", f"{self.folder}/flash.bin", "--nor", f"{self.folder}/nor.bin", "--elf",
             "build/firmware/matrig.elf", "--serial", f"pty:{self.folder}/tty", "--rig", rig, *more], stderr=subprocess.DEVNULL)

    def rest(self, *can):
        self.play("hil/rest.run", *can, "--speed", "real")

    def rest_with_can(self):  # that side waits for its host, and takes one
        self.rest("--can", f"unix:{self.folder}/can")

    def land(self, run):
        self.play(f"tests/runs/{run}.run", "--can", f"unix:{self.folder}/can")

    def stop(self):
        if self.process:
            self.process.send_signal(signal.SIGINT)
            self.process.wait(60)
            self.process = None


class Day:
    """matrig day on a terminal of its own."""

    def __init__(self, folder):
        self.folder, self.keys, self.text, self.seen = folder, 0, "", ""
        self.pid = None

    def begin(self):
        words = ["build/matrig", "day", f"{self.folder}/day.db", "--serial", f"pty:{self.folder}/tty", "--can",
                 f"unix:{self.folder}/can", "--edges", "none", "--who", "tester"]
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.environ["TERM"] = "dumb"
            os.execv(words[0], words)
        self.text = ""

    def expect(self, pattern, limit_s=60):
        """Until it is said; what was said before is done with."""
        until = time.monotonic() + limit_s
        while not (found := re.search(pattern, self.text)):
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.terminal], [], [], max(left, 0))[0]:
                sys.exit(f"not said within {limit_s} s: {pattern}; said last: {self.text[-1500:]}")
            try:
                more = os.read(self.terminal, 65536).decode(errors="replace").replace("\r", "")
            except OSError:
                sys.exit(f"the day ended before it said: {pattern}; said last: {self.text[-1500:]}")
            self.text += more
            self.seen += more
        self.text = self.text[found.end():]
        return found

    def type(self, text):
        self.keys += len(text)
        os.write(self.terminal, text.encode())

    def kill(self):
        """As a power cut: no end, no last word. What it had begun at its terminal ends with it."""
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        os.close(self.terminal)

    def kill_and_begin(self):
        self.kill()
        self.begin()

    def next(self, step):
        """The screen, and what is next on it."""
        found = self.expect(r"> \d (\w+) +next[^\n]*\n(?:.*\n)*?.*" + re.escape(PROMPT))
        if found[1] != step:
            sys.exit(f"next is {found[1]}, not {step}: {self.seen[-1500:]}")


def await_motion(folder, run):
    """Until the gear moves, as the campaign has it."""
    until = time.monotonic() + 60
    while time.monotonic() < until:
        db = sqlite3.connect(f"file:{folder}/day.db?mode=ro", uri=True)
        moving = db.execute("SELECT count(*) FROM landings WHERE id=? AND state=2", (run,)).fetchone()[0]
        db.close()
        if moving:
            return
        time.sleep(0.01)
    sys.exit(f"RUN {run} does not move within 60 s")


def survey(day, kill):
    """Every place read once; killed in the middle when asked for."""
    day.type("\n")
    typed, count = 0, int(day.expect(ASKED)[1])
    while typed < count:
        if kill and typed == count // 3:
            kill = False
            day.kill_and_begin()
            day.next("survey")
            day.type("\n")
            day.expect(ASKED)
        day.type("33.7%d\n" % (typed % 10))
        typed += 1
        if typed < count:
            day.expect(ASKED)
    day.next("load")
    return count


def main():
    folder, landings = sys.argv[1], int(sys.argv[2])
    kills = set(PLACES[:int(sys.argv[3])] if len(sys.argv) > 3 else PLACES)
    os.makedirs(folder, exist_ok=True)
    board, day = Board(folder), Day(folder)
    readings, killed = 0, 0

    def place(n, name):
        """Killed here, when it is one of the places."""
        nonlocal killed
        if (n, name) not in kills:
            return False
        killed += 1
        return True

    board.rest()
    day.begin()
    day.expect("Begin a new campaign")
    day.type("y")
    day.next("series")
    day.type("\n")
    day.expect("A name for the series")
    day.type("standard\n")
    day.expect("the runway")
    day.type("relaid\n")
    for n in range(landings):
        begun, keys = time.monotonic(), day.keys
        day.next("survey")
        if place(n, "series"):
            day.kill_and_begin()
            day.next("survey")
        readings += survey(day, place(n, "survey"))
        if place(n, "load"):
            day.kill_and_begin()
            day.next("load")
        day.type("\n")
        if n > 0:
            day.next("advise")
            day.type("\n")
            day.expect("planned speed")
            day.type("28ft/s\n")
            day.expect("planned mean")
            day.type("\n")
            if place(n, "advise"):
                day.expect("hardest|against|clear|caution")
                day.kill_and_begin()
                found = day.expect(r"> \d (\w+) +next")[1]
                if found == "advise":  # it had not come so far as to keep it
                    day.type("\n")
                    day.expect("planned speed")
                    day.type("\n")
                    day.expect("planned mean")
                    day.type("\n")
                day.text = "> 7 ready      next \n" + PROMPT if found != "advise" else day.text
        day.next("ready")
        board.rest_with_can()
        day.type("\n")
        if place(n, "ready"):
            day.expect(r"\$ matrig ready")
            day.kill_and_begin()
            day.next("ready")
            board.rest_with_can()
            day.type("\n")
        day.next("land")
        board.stop()
        day.type("\n")
        day.expect("a arm ")
        if place(n, "log"):
            day.kill_and_begin()
            day.next("land")
            day.type("\n")
            day.expect("a arm ")
        board.land(RUNS[n])
        if place(n, "landing"):
            await_motion(folder, n + 1)
            day.kill_and_begin()
            found = day.expect(r"> \d (\w+) +next")[1]
            day.expect(re.escape(PROMPT))
            if found == "land":
                day.type("\n")
                day.next("look")
        else:
            day.next("look")
        board.rest()
        day.type("\n")
        day.expect("what was seen")
        if place(n, "look"):
            day.kill_and_begin()
            day.next("look")
            day.type("\n")
            day.expect("what was seen")
        day.type(f"seen {n + 1}\n")
        print(f"landing {n + 1}: {day.keys - keys} keystrokes, {time.monotonic() - begun:.1f} s")
    day.next("survey")
    day.type("q")
    day.expect("goes on here")
    board.stop()

    db = sqlite3.connect(f"{folder}/day.db")
    one = lambda sql: db.execute(sql).fetchone()[0]
    wanted = {
        "readings": (one("SELECT count(*) FROM gage_readings"), readings),
        "places read": (one("SELECT count(*) FROM (SELECT DISTINCT survey, kind, line, place FROM gage_readings)"), readings),
        "surveys": (one("SELECT count(*) FROM gage_surveys WHERE ended_us IS NOT NULL"), landings),
        "landings": (one("SELECT count(*) FROM landings"), landings),
        "landings done": (one("SELECT count(*) FROM landings WHERE state=4"), landings),
        "lost or bad": (one("SELECT sum(lost + bad) FROM links"), 0),
        "notes": (one("SELECT group_concat(value) FROM landing_changes WHERE field='note'"),
                  ",".join(f"seen {n + 1}" for n in range(landings))),
        "series": (one("SELECT count(*) FROM series"), 1),
        "integrity": (one("PRAGMA integrity_check"), "ok"),
        "series asked": (len(re.findall("A name for the series", day.seen)), 1),
        "links asked": (len(re.findall("such as (serial|can):", day.seen)), 0),
        "killed": (killed, len([k for k in kills if k[0] < landings])),
    }
    print(f"killed at {killed} places; {readings} readings; {day.keys} keystrokes in all")
    wrong = {k: v for k, v in wanted.items() if v[0] != v[1]}
    for name, (is_, be) in wrong.items():
        print(f"{name}: {is_}, not {be}")
    sys.exit(1 if wrong else 0)


main()
