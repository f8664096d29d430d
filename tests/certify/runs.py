"""A run file (tests/runs/runfile.h) read, changed and written: what a case of cases.txt does to a landing."""
import random
import zlib

RUNWAY_JOINTS = 421
LAG_S = 0.05  # between commands of a flood that begins


class Run:
    def __init__(self, path):
        lines = open(path).read().splitlines()
        first = next(i for i, line in enumerate(lines) if line.startswith("samples "))
        self.head = [line for line in lines[:first] if not line.startswith("#")]
        self.rate_hz = int(lines[first].split()[2])
        self.rows = []  # 22 numbers each
        for line in lines[first + 1:-1]:
            if line.startswith("x"):
                self.rows += [self.rows[-1]] * int(line[1:])
            else:
                self.rows.append([int(word) for word in line.split()])
        self.no_landing = False

    def word(self, key, at=1):
        return next(line for line in self.head if line.startswith(key + " ")).split()[at]

    def duration_s(self):
        return float(self.word("duration_s"))

    def touchdown_s(self):
        return float(self.word("touchdown", 2))

    def truth(self):
        """Longest zone at the wheel, and the time of the first one of 50 mats: None, not known or none."""
        told = {line.split()[1]: float(line.split()[2]) for line in self.head if line.startswith("truth ")}
        if self.no_landing:
            return None, None
        if "most_mats" in told:
            return int(told["most_mats"]), told["event_s"] if told["event_s"] > 0 else None
        return int(told["zone_ahead_longest_mats"]), None  # of tests/runs: ahead of the wheel; when is not told

    # ---- changes ----

    def change(self, word):
        key, _, value = word.partition("=")
        change = {"nosurvey": self.no_survey, "later": self.later, "drop": self.drop, "open": self.open, "still": self.still,
                  "shake": self.shake, "flood": self.flood, "slide": self.slide}.get(key)
        if change:
            change(value)
        elif key not in ("fault", "config", "memory", "image", "seed", "board-seed"):
            raise ValueError("no such change: " + word)

    def no_survey(self, _):
        self.head = [line for line in self.head if not (line.startswith("command ") and line.split()[3] == "survey")]

    def later(self, value):
        """Everything but the survey and the arming comes so many seconds later."""
        by_s = float(value)
        for i, line in enumerate(self.head):
            words = line.split()
            if words[0] == "duration_s":
                words[1] = "%.3f" % (float(words[1]) + by_s)
            elif words[0] == "touchdown":
                words[2] = "%.9f" % (float(words[2]) + by_s)
            elif words[0] == "switch" and words[4] != "-":
                words[4] = "%.9f" % (float(words[4]) + by_s)
            elif words[0] == "truth" and words[1] == "event_s" and float(words[2]) > 0:
                words[2] = "%.3f" % (float(words[2]) + by_s)
            elif words[0] == "command" and words[3] not in ("survey", "arm"):
                words[1] = "%.3f" % (float(words[1]) + by_s)
            else:
                continue
            self.head[i] = " ".join(words)
        self.rows = [self.rows[0]] * round(by_s * self.rate_hz) + self.rows

    def switch(self, position, text):
        for i, line in enumerate(self.head):
            words = line.split()
            if words[0] == "switch" and int(words[1]) == position:
                self.head[i] = " ".join(words[:4] + [text])

    def drop(self, value):
        """Switches that the gear does not open, "3,4,5", or all."""
        for position in range(1, 25) if value == "all" else map(int, value.split(",")):
            self.switch(position, "-")

    def open(self, value):
        """Switches that open at another time, "12@1.5,11@3.0"."""
        for part in value.split(","):
            position, at_s = part.split("@")
            self.switch(int(position), "%.9f" % float(at_s))

    def still(self, _):
        """No gear and no movement: nothing lands."""
        self.no_landing = True
        self.drop("all")
        self.rows = [self.rows[0]] * len(self.rows)

    def slide(self, value):
        """Mats move so far (inches, negative upfield) with the pushed model, "INCHES,FROM_S,TO_S"."""
        inches, from_s, to_s = map(float, value.split(","))
        for i, row in enumerate(self.rows):
            part = min(max((i / self.rate_hz - from_s) / (to_s - from_s), 0.0), 1.0)
            self.rows[i] = [round(u + 1e5 * inches * part) for u in row[:8]] + row[8:]

    def shake(self, value):
        """Noise on every displacement, so many inches rms, without a memory from row to row."""
        draw = random.Random(1973)
        self.rows = [[round(u + draw.gauss(0.0, 1e5 * float(value))) for u in row[:8]] + row[8:] for row in self.rows]

    def flood(self, value):
        """Commands without end from arming to the end: "LINK,EVERY_MS"."""
        link, every_ms = value.split(",")
        commands = [(float(line.split()[1]), line) for line in self.head if line.startswith("command ")]
        self.head = [line for line in self.head if not line.startswith("command ")]
        arm_s = next(at for at, line in commands if line.split()[3] == "arm")
        at_s, number = arm_s + LAG_S, 1
        while at_s < self.duration_s() - LAG_S:
            commands.append((at_s, "command %.4f %s mark %d" % (at_s, link, number % 1000)))
            at_s, number = at_s + float(every_ms) / 1000.0, number + 1
        self.head += [line for _, line in sorted(commands, key=lambda command: command[0])]

    def write(self, path):
        out = self.head + ["samples %d %d" % (len(self.rows), self.rate_hz)]
        last, times = None, 0
        for row in self.rows + [None]:
            if row is not None and row == last:
                times += 1
                continue
            if times:
                out.append("x%d" % times)
            last, times = row, 0
            if row is not None:
                out.append(" ".join(map(str, row)))
        text = "\n".join(out) + "\n"
        with open(path, "w") as file:
            file.write(text + "end %08x\n" % (zlib.crc32(text.encode()) & 0xffffffff))
