"""Decks for ngspice: copies of a block, each with its own drawn values, side by side in one circuit."""
import math
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
        """Runs the commands; `save` lists the vectors to keep. Vectors of each plot: {name: [numbers]}, complex ones as complex."""
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
            raise SystemExit(f"circuits: ngspice gave no complete result; see {self.path}.log")
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


# ---- what is measured of any channel in the same way: what the converter sees, and what its neighbour leaves ----

VDDA = 3.3
LSB_V = VDDA / 4096
# Converter: sampling capacitor 4 pF, switch 6 kOhm most (STM32F407 data sheet, ADC characteristics); 112 of 124 cycles of
# 21 MHz sample, each channel once in 125 us (firmware/f407/scan.c).
SAMPLE_F, SAMPLE_OHM = 4e-12, 6e3
SAMPLE_S, CONVERT_S, SCAN_S = 112 / 21e6, 124 / 21e6, 125e-6
TRIGGER_S = (2352 - 2) / 84e6  # after the excitation's reversal


def mean(values):
    return sum(values) / len(values)


def deviation(values):
    middle = mean(values)
    return math.sqrt(sum((v - middle) ** 2 for v in values) / (len(values) - 1))


def rails(deck, copy, volts):
    """The supplies of a copy, as ideal sources."""
    for net, volt in volts.items():
        node = deck.node(copy, net)
        deck.add(f"Vrail_{node} {node} 0 {volt}")


def source_ohm(work, name, parts, net, surround):
    """Resistance that the converter sees at direct current. surround(deck, copy) adds supplies and sensor."""
    deck = Deck(work, name + "-source")
    deck.place(0, parts, Draw(0, 0))
    surround(deck, 0)
    node = deck.node(0, net)
    deck.add(f"Iprobe 0 {node} dc 0 ac 1")
    plot = deck.run(["ac lin 1 0.01 0.01", "WRITE"], [f"v({node})"])[0]
    return abs(plot[f"v({node})"][0])


def kick(work, name, parts, net, surround, scans=24):
    """Part of the difference to the channel converted before that is left in a reading, once it is steady: two copies,
    whose capacitors come with 0 V and with 1 V more."""
    deck = Deck(work, name + "-kick")
    for copy in (0, 1):
        deck.place(copy, parts, Draw(0, 0))
        surround(deck, copy)
        node = deck.node(copy, net)
        deck.add(f"Bprevious p{copy} 0 v=v({node})+{copy}", f"Sload p{copy} s{copy} load 0 take", f"Ssample {node} t{copy} sample 0 take",
                 f"Rswitch{copy} t{copy} s{copy} {SAMPLE_OHM}", f"Csample{copy} s{copy} 0 {SAMPLE_F}")
        deck.lines[-5:] = [line.replace("Bprevious", f"Bprevious{copy}").replace("Sload", f"Sload{copy}").replace("Ssample", f"Ssample{copy}")
                           for line in deck.lines[-5:]]
    # The capacitor takes its neighbour's voltage for 1 us, lets go, and samples.
    deck.add(".model take sw vt=0.5 vh=0.01 ron=10 roff=1e13",
             f"Vload load 0 pulse(0 1 10u 1n 1n 1u {SCAN_S})", f"Vsample sample 0 pulse(0 1 11.1u 1n 1n {SAMPLE_S} {SCAN_S})")
    end = (scans - 1) * SCAN_S + 11.1e-6 + SAMPLE_S
    plot = deck.run([f"tran 50n {end + 1e-6} {end - 1e-6} 0.2u", "WRITE"], ["v(s0)", "v(s1)"])[0]
    return at(plot["time"], plot["v(s1)"], end - 5e-9) - at(plot["time"], plot["v(s0)"], end - 5e-9)


def corner_hz(frequencies, gains):
    """Where the gain has fallen by 3 dB from its first value."""
    limit = abs(gains[0]) / math.sqrt(2)
    for i in range(1, len(gains)):
        if abs(gains[i]) < limit:
            a, b = math.log(abs(gains[i - 1])), math.log(abs(gains[i]))
            share = (a - math.log(limit)) / (a - b)
            return frequencies[i - 1] * (frequencies[i] / frequencies[i - 1]) ** share
    return math.nan


def noise_lsb(plot):
    """Standard deviation at the output of a noise analysis, in codes of the converter."""
    total = next(v for k, v in plot.items() if k.startswith("v(onoise_total") or k == "onoise_total")
    return abs(total[0]) / LSB_V
