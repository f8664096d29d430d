"""Decks for ngspice: copies of a block, each with its own drawn values, side by side in one circuit."""
import os
import random
import re
import subprocess

import devices


class Draw:
    """Errors of one copy. `spread` 0 draws nothing: the nominal circuit."""

    def __init__(self, seed, spread=1.0):
        self.random, self.spread = random.Random(seed), spread
        self.turned, self.closed = 0.5, False  # trimmers, relays
        self.warmer_k = 0.0

    def within(self, most):
        return self.spread * self.random.uniform(-most, most)

    def between(self, least, most):
        return (least + most) / 2 + self.within((most - least) / 2)


def clean(net):
    return "0" if net == "GND" else re.sub(r"[^a-z0-9]", "_", net.lower())


class Deck:
    def __init__(self, work, name):
        self.path = os.path.join(work, name)
        self.lines = []

    def add(self, *lines):
        self.lines += lines

    def node(self, copy, net):
        """The node of a net in a copy."""
        name = clean(net)
        return name if name == "0" else f"c{copy}_{name}"

    def place(self, copy, parts, draw):
        """A copy of these parts."""
        for part in parts:
            if part["device"] in devices.SILENT and part["device"] != "TVS":
                continue
            model = devices.MODELS.get(part["device"])
            if not model:
                raise SystemExit(f"circuits: {part.refdes} is a {part['device']}, of which devices.py has no model")
            self.add(*model(f"{copy}_{clean(part.refdes)}", part, lambda pin: self.node(copy, part.net(pin)), draw))

    def run(self, control, save, limit_s=60, options=""):
        """Runs the commands; `save` lists what is kept. Vectors of each plot: {name: [numbers]}, complex ones as complex."""
        out = self.path + ".raw"
        if os.path.exists(out):
            os.remove(out)
        with open(self.path + ".cir", "w") as file:
            file.write("* made from the schematics\n" + devices.LIBRARY + "\n".join(self.lines) + f"\n.options {options}\n.save " +
                       "\n+ ".join(save) + f"\n.control\nset filetype=ascii\nset appendwrite\n" +
                       "\n".join(c.replace("WRITE", f"write {out}") for c in control) + "\nquit\n.endc\n.end\n")
        try:
            done = subprocess.run(["ngspice", "-b", self.path + ".cir"], capture_output=True, text=True, timeout=limit_s,
                                  stdin=subprocess.DEVNULL)
        except subprocess.TimeoutExpired:
            raise SystemExit(f"circuits: ngspice took more than {limit_s} s; the deck is {self.path}.cir")
        with open(self.path + ".log", "w") as file:
            file.write(done.stdout + done.stderr)
        if not os.path.exists(out) or "aborted" in done.stdout + done.stderr:
            raise SystemExit(f"circuits: ngspice gave nothing whole; see {self.path}.log")
        return read_raw(out)


def read_raw(path):
    plots = []
    with open(path) as file:
        lines = iter(file.read().split("\n"))
    for line in lines:
        if line.startswith("Flags:"):
            is_complex = "complex" in line
        elif line.startswith("No. Variables:"):
            count = int(line.split(":")[1])
        elif line.startswith("No. Points:"):
            points = int(line.split(":")[1])
        elif line.startswith("Variables:"):
            names = []
            for i in range(count):
                names.append((line if i < 0 else next(lines)).split("\t")[2].lower())
        elif line.startswith("Values:"):
            columns = [[] for _ in names]
            for _ in range(points):
                for column in columns:
                    text = next(lines)
                    while not text.strip():
                        text = next(lines)
                    text = text.split("\t")[-1]
                    column.append(complex(*map(float, text.split(","))) if is_complex else float(text))
            plots.append(dict(zip(names, columns)))
    return plots


def at(times, values, t):
    """Value at time t, between its neighbours. `times` rise."""
    low, high = 0, len(times) - 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if times[middle] <= t else (low, middle)
    share = (t - times[low]) / (times[high] - times[low])
    return values[low] + share * (values[high] - values[low])
