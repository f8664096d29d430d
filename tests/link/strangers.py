#!/usr/bin/env python3
"""Frames of a stranger in a landing: every message of the catalogue, with payloads that are not the board's, among those that the board sent.

    strangers.py BEFORE.can BEFORE.serial FOLDER MATRIG

Serial is the record, so no number that matrig states may change. A frame of another length is counted as none of the catalogue's. Four messages in
a log; `make long` (MATRIG_LONG) tries all payloads of each message, one by one. A catalogue is read from common/catalogue.def, moments and random
payloads from a fixed seed."""

import json
import os
import random
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor


LONG = bool(os.environ.get("MATRIG_LONG"))


def catalogue(matrig):
    """(name, identifier, bytes) of each message that the board sends."""
    text = subprocess.run([matrig, "export", "--format", "dbc"], capture_output=True, text=True, check=True).stdout
    for identifier, name, size in re.findall(r"^BO_ (\d+) (\w+): (\d+) BOARD$", text, re.M):
        yield name, int(identifier), int(size)


def payloads(size, dice):
    yield "zeros", bytes(size)
    yield "ones", b"\xff" * size
    yield "random", bytes(dice.randrange(256) for _ in range(size))
    yield "short", bytes(dice.randrange(256) for _ in range(size - 1))


def inject(lines, frames, moments):
    """A copy of the log; each frame follows the line of its moment, stamped like that."""
    made = list(lines)
    for at, (identifier, payload) in sorted(zip(moments, frames), reverse=True):
        stamp, interface = made[at].split()[:2]
        made.insert(at + 1, f"{stamp} {interface} {identifier:03X}#{payload.hex().upper()}\n")
    return made


def stated(result):
    """What is stated of landings, without what counts the frames that were received."""
    landings = json.loads(json.dumps(result["landings"]))
    for landing in landings:
        for link in landing["links"].values():
            link.pop("received")
    return landings


def joined(cases):
    """One of several: no number may change, so it does not matter which of them would change it."""
    return "+".join(name for name, _, _ in cases), [frame for _, frames, _ in cases for frame in frames], cases[0][2]


class Study:
    def __init__(self, can, serial, folder, matrig):
        self.lines = open(can).readlines()
        self.serial, self.folder, self.matrig = serial, folder, matrig
        landing = [i for i, line in enumerate(self.lines) if " 0A0#" in line]
        armed = next(i for i in landing if " 0A0#01" in self.lines[i])
        done = next(i for i in landing if " 0A0#04" in self.lines[i])
        self.moments = range(armed + 100, done - 100)
        self.messages, self.size = 0, {}
        self.truth = self.log("truth", self.lines)

    def log(self, name, lines):
        path = os.path.join(self.folder, name)
        with open(path + ".can", "w") as out:
            out.writelines(lines)
        command = [self.matrig, "--json", "--quiet", "log", "--can", f"file:{path}.can", "--db", path + ".db",
            "--serial", f"file:{self.serial}"]
        run = subprocess.run(command, capture_output=True, text=True, timeout=120)
        for end in (".can", ".db", ".db-wal", ".db-shm"):
            if os.path.exists(path + end):
                os.remove(path + end)
        if run.returncode:
            raise AssertionError(f"{name}: exit {run.returncode}: {run.stderr.strip()}")
        return json.loads(run.stdout)

    def case(self, name, frames, dice):
        moments = [dice.randrange(self.moments.start, self.moments.stop) for _ in frames]
        result = self.log(name, inject(self.lines, frames, moments))
        short = sum(len(payload) < self.size[identifier] for identifier, payload in frames)
        if result["links"]["can"]["foreign"] != short:
            return f"{name}: {result['links']['can']['foreign']} of {short} frames of another length counted"
        return None if stated(result) == stated(self.truth) else f"{name}: another number than without it"

    def cases(self):
        """(name, frames, dice) of each log"""
        together = []
        for name, identifier, size in catalogue(self.matrig):
            dice = random.Random(identifier)
            self.size[identifier] = size
            self.messages += 1
            together.append((name, [(identifier, payload) for _, payload in payloads(size, dice)], dice))
            if LONG or len(together) == 4:
                yield joined(together)
                together = []
        if together:
            yield joined(together)


def main():
    study = Study(*sys.argv[1:5])
    assert len(study.truth["landings"]) == 1, "the landing itself"
    with ThreadPoolExecutor(2) as pool:
        answers = list(pool.map(lambda case: study.case(*case), study.cases()))
    wrong = [answer for answer in answers if answer]
    print("\n".join(wrong))
    print(f"{study.messages} messages, {len(answers)} logs, {len(wrong)} wrong")
    return 1 if wrong or study.messages < 80 else 0


sys.exit(main())
