"""The schematics as parts and nets, as lepton-netlist reads them."""
import os
import re
import subprocess

HERE = os.path.dirname(os.path.abspath(__file__))
# Pages; the blocks that stand on them several times (transducer, bridge, switch, input) follow from them.
PAGES = ["mcu", "power", "transducers", "bridges", "staircase", "lamp", "memory", "links", "inputs"]
BLOCKS = ["transducer", "bridge", "switch", "input"]
LIMIT_S = 1200  # 10 s of one processor, half a minute the first time; many times that where others use the processors

cache = os.path.join(HERE, "..", "..", "build", "circuits", "cache")  # circuits.py sets another

SCALE = {"p": 1e-12, "n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "": 1.0}


class Part:
    def __init__(self, refdes):
        self.refdes = refdes
        self.attribute = {}
        self.pins = []  # (number, label, net)

    def __getitem__(self, name):
        return self.attribute.get(name, "")

    def net(self, label):
        nets = {net for _, name, net in self.pins if name == label}
        return nets.pop() if len(nets) == 1 else f"none at {self.refdes} {label}"

    def value(self):
        """Of "4.7k", "100n", "8 MHz": the number in its base unit."""
        match = re.match(r"([0-9.]+) ?([pnumkM]?)", self["value"])
        if not match:
            raise ValueError(f"{self.refdes} has the value \"{self['value']}\", which is not a number")
        return float(match.group(1)) * SCALE[match.group(2)]

    def tolerance(self):
        match = re.fullmatch(r"([0-9.]+)%", self["tol"])
        if not match:
            raise ValueError(f"{self.refdes} has the tolerance \"{self['tol']}\": give it as 1%")
        return float(match.group(1)) / 100


def environment():
    """Environment of lepton's programs: their compiled files go into the cache, not into the home folder."""
    return {**os.environ, "LC_ALL": "C.UTF-8", "XDG_CACHE_HOME": cache}


def lepton(folder, backend, pages=PAGES):
    """Output of a backend for the pages in a folder."""
    command = ["lepton-netlist", "-q", *backend, "-o", "-", *[page + ".sch" for page in pages]]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LIMIT_S,
                          env=environment())
    return done.stdout, done.stderr, done.returncode


def read(folder=HERE, pages=PAGES):
    """Parts by their refdes: "T1/R5" is R5 of block T1."""
    text, errors, status = lepton(folder, ["-f", "gnet-circuits.scm"], pages)
    if status or not text:
        raise SystemExit(f"circuits: lepton-netlist failed in {folder}: {errors.strip() or text.strip()}")
    parts = {}
    for line in text.splitlines():
        kind, *rest = line.split("\t")
        if kind == "part":
            part = parts.setdefault(rest[0], Part(rest[0]))
        elif kind == "attribute":
            part.attribute[rest[0]] = rest[1]
        elif kind == "pin":
            part.pins.append(tuple(rest))
    return parts


def nets(parts):
    """Net: [(part, number, label)]."""
    found = {}
    for part in parts.values():
        for number, label, net in part.pins:
            found.setdefault(net, []).append((part, number, label))
    return found
