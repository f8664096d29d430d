#!/usr/bin/env python3
"""How soon may the machine code of an image move a pin again? A second opinion beside the emulated board, without running anything.

    pulse.py ELF PORT PIN high|low [--taken N]

Prints the least number of cycles between a store that makes the pin so and a store that ends that, over all ways through the code, and the way:

    1 0x0802a49c nor_begin_erase 0x0802a49e nor_begin_erase

What it does: reads the disassembly (arm-none-eabi-objdump), finds by constant propagation the stores to the port's BSRR and ODR whose address and value
are known, and looks for the cheapest way (Dijkstra) from each that begins a pulse to one that ends it: through branches, calls and returns (to any caller).
A store that ends no pulse and begins one anew (high to a pin that is high) begins it anew: the later one counts.

An instruction takes one cycle, the best case of the Cortex-M4 (technical reference manual r0p1, 3.3.1); a taken branch N, by default 2 (1 + P, P at least 1);
IT may be folded and takes none. A loop that only counts down (`subs`, `bne` to it, its count known) takes its rounds. With --taken 1 cycles are counted as the
emulated board counts them.

What it does not see: an interrupt that moves the pin while other code is about to; stores whose port comes from memory (the number of stores that could be
such is told). Calls through pointers go to every function whose address is somewhere in the image.
"""

import argparse
import heapq
import re
import struct
import subprocess
import sys

GPIO_A, PORT_BYTES = 0x40020000, 0x400  # RM0090 2.3
ODR, BSRR = 0x14, 0x18  # RM0090 8.4
OBJDUMP = "arm-none-eabi-objdump"


class Instruction:
    def __init__(self, address, size, name, operands):
        self.address, self.size, self.operands = address, size, operands
        self.name = re.sub(r"\.[nw]$", "", name)
        self.next = address + size
        target = re.match(r"(?:r\d+, |ip, |lr, )?([0-9a-f]{6,8}) <", operands)
        self.target = int(target.group(1), 16) if target and self.name[0] in "bc" else None

    def is_call(self):
        return self.name in ("bl", "blx")

    def is_return(self):
        return (self.name == "bx" and self.operands.startswith("lr")) or (
            self.name in ("pop", "ldmia", "ldmfd", "ldm") and "pc" in self.operands) or (
            self.name == "ldr" and self.operands.startswith("pc, [sp]"))

    def is_jump(self):  # never goes on to the next
        return self.name == "b" or self.is_return() or self.name in ("tbb", "tbh", "udf") or (
            self.name in ("bx", "mov", "ldr") and (self.name == "bx" or self.operands.startswith("pc,")))

    def is_branch(self):  # conditional
        return self.target is not None and not self.is_call() and self.name != "b"


class Image:
    def __init__(self, elf):
        self.code, self.word, self.function_of, self.entry = {}, {}, {}, {}
        self.read(subprocess.run([OBJDUMP, "-d", elf], check=True, capture_output=True, text=True).stdout)
        self.bytes = self.read_flash(elf)
        self.functions = sorted(self.entry.values())
        self.addresses = sorted(self.code)
        self.taken = {int.from_bytes(self.bytes[i:i + 4], "little") & ~1 for i in range(0, len(self.bytes) - 3, 4)}
        self.find_callers()

    def read(self, text):
        function = 0
        for line in text.splitlines():
            head = re.match(r"([0-9a-f]{8}) <(.*)>:$", line)
            row = re.match(r" *([0-9a-f]+):\t((?:[0-9a-f]{4} ?)+|[0-9a-f]{8}) *\t(\S+)\t?(.*)$", line)
            if head:
                function = int(head.group(1), 16)
                self.entry[head.group(2)] = function
            elif row:
                address, raw, name = int(row.group(1), 16), row.group(2).replace(" ", ""), row.group(3)
                operands = re.split(r"\s*[;@]", row.group(4))[0].strip()
                if name == ".word":
                    self.word[address] = int(row.group(4).split()[0], 16)
                elif not name.startswith("."):
                    self.code[address] = Instruction(address, len(raw) // 2, name, operands)
                    self.function_of[address] = function

    @staticmethod
    def read_flash(elf):  # the loaded bytes, whatever they are: for addresses of functions and for literals
        with open(elf, "rb") as file:
            data = file.read()
        offset, size, count = struct.unpack_from("<I", data, 28)[0], *struct.unpack_from("<HH", data, 42)
        parts = b""
        for i in range(count):
            kind, at, _, _, length = struct.unpack_from("<IIIII", data, offset + i * size)
            if kind == 1:
                parts += data[at:at + length] + b"\0" * (-length % 4)
        return parts

    def name(self, address):
        function = self.function_of[address]
        return next(n for n, a in self.entry.items() if a == function)

    def find_callers(self):
        """Where each function returns to: behind its calls, and where those return that end in it."""
        self.returns = {f: set() for f in self.functions}
        ends_in = {f: set() for f in self.functions}
        pointed = [f for f in self.functions if f in self.taken]
        self.pointed = pointed
        for at, i in self.code.items():
            callees = [i.target] if i.target in self.returns else []
            if i.is_call() and i.target is None:
                callees = pointed
            for callee in callees:
                if i.is_call():
                    self.returns[callee].add(i.next)
                elif callee != self.function_of[at]:
                    ends_in[callee].add(self.function_of[at])
            if i.name == "bx" and not i.operands.startswith("lr"):
                for callee in pointed:
                    ends_in[callee].add(self.function_of[at])
        changed = True
        while changed:
            changed = False
            for callee, callers in ends_in.items():
                for caller in callers:
                    new = self.returns[caller] - self.returns[callee]
                    self.returns[callee] |= new
                    changed |= bool(new)

    def within(self, i):
        """Where the same function goes on, with the registers that it has."""
        on = [] if i.is_jump() else [i.next]
        if i.target is not None and not i.is_call() and self.function_of.get(i.target) == self.function_of[i.address]:
            on.append(i.target)
        if i.name in ("tbb", "tbh"):  # a table of branches: to anywhere behind it in the function
            on += [a for a in self.addresses if a > i.address and self.function_of[a] == self.function_of[i.address]]
        return [a for a in on if a in self.code]


# --- which constants are in which registers ---

def number(text):
    return int(text.lstrip("#"), 0) & 0xffffffff


def step(image, i, known):
    """The registers that are known behind an instruction: a new dict."""
    parts = [p.strip() for p in i.operands.split(",")]
    name = i.name
    after = dict(known)
    if i.is_call():
        for r in ("r0", "r1", "r2", "r3", "ip", "lr"):
            after.pop(r, None)
        return after
    if name in ("str", "strb", "strh", "strd", "cmp", "cmn", "tst", "teq", "push", "nop", "dsb", "dmb", "isb", "it") or i.target is not None or \
            name.startswith(("vstr", "vcmp", "it", "stm", "cps")):
        base = re.search(r"\[(\w+)", i.operands)
        if base and ("]!" in i.operands or re.search(r"\], #", i.operands)):
            after.pop(base.group(1), None)
        return after
    into = re.findall(r"\w+", i.operands)
    value = None
    literal = re.search(r"\[pc, #-?\d+\]", i.operands)
    comment = (i.address + 4 & ~3)
    if name == "ldr" and literal:
        value = image.word.get(comment + int(re.search(r"#(-?\d+)", literal.group()).group(1)))
    elif name in ("mov", "movs", "movw", "mvn") and len(parts) == 2:
        value = number(parts[1]) if parts[1].startswith("#") else known.get(parts[1])
        value = value if name != "mvn" or value is None else ~value & 0xffffffff
    elif name == "movt" and parts[0] in known:
        value = known[parts[0]] & 0xffff | number(parts[1]) << 16
    elif name in ("add", "adds", "sub", "subs", "addw", "orr", "orrs", "lsl", "lsls", "and", "ands", "bic", "bics") and len(parts) in (2, 3):
        a, b = (parts[0], parts[1]) if len(parts) == 2 else (parts[1], parts[2])
        left, right = known.get(a), number(b) if b.startswith("#") else known.get(b)
        if left is not None and right is not None:
            value = {"add": left + right, "sub": left - right, "orr": left | right, "lsl": left << (right & 31), "and": left & right,
                     "bic": left & ~right}[name.rstrip("sw")] & 0xffffffff
    targets = into[:1] if not name.startswith(("ldrd", "pop", "ldm", "smull", "umull", "umlal", "smlal")) else into
    for register in targets:
        after.pop(register, None)
    if value is not None:
        after[parts[0]] = value
    return after


def in_it_block(image):
    """Instructions that may not be carried out: what they write is not known."""
    inside = set()
    for address, i in image.code.items():
        if i.name.startswith("it"):
            at = i.next
            for _ in i.name[1:]:
                inside.add(at)
                at = image.code[at].next if at in image.code else at
    return inside


def constants(image):
    before = {}
    conditional = in_it_block(image)
    work = [(entry, {}) for entry in image.functions if entry in image.code]
    while work:
        at, known = work.pop()
        old = before.get(at)
        new = known if old is None else {r: v for r, v in old.items() if known.get(r) == v}
        if new == old:
            continue
        before[at] = new
        i = image.code[at]
        after = step(image, i, new)
        if at in conditional:  # carried out or not
            after = {r: v for r, v in after.items() if new.get(r) == v}
        work += [(on, after) for on in image.within(i)]
    return before


# --- stores to the pin ---

def stores(image, before, port, pin):
    """{address: set of levels that it may give the pin}; and how many stores could be to anywhere."""
    base_of_port, levels, unknown = GPIO_A + PORT_BYTES * port, {}, 0
    for at, known in before.items():
        i = image.code[at]
        if i.name not in ("str", "strh"):
            continue
        form = re.match(r"(\w+), \[(\w+)(?:, #(-?\d+))?\]$", i.operands)
        if not form or form.group(2) in ("sp", "pc"):
            continue
        value, base = known.get(form.group(1)), known.get(form.group(2))
        if base is None:
            unknown += 1
            continue
        place = base + int(form.group(3) or 0) - base_of_port
        if place in (BSRR, BSRR + 2):
            shift = 16 if place == BSRR + 2 else 0
            if value is None:
                levels[at] = {True, False}
            elif value << shift >> pin & 1:
                levels[at] = {True}
            elif value << shift >> (pin + 16) & 1:
                levels[at] = {False}
        elif place == ODR:
            levels[at] = {True, False} if value is None else {bool(value >> pin & 1)}
    return levels, unknown


# --- the cheapest way ---

def rounds_of(image, before, i):
    """Of a branch back: how often its loop runs, when it only counts down a known number; else 1."""
    if i.name != "bne" or i.target is None or not 0 < i.address - i.target <= 16:
        return 1
    body = [image.code[a] for a in range(i.target, i.address, 2) if a in image.code]
    counts = [b for b in body if b.name == "subs" and b.operands.endswith("#1")]
    if len(counts) != 1 or any(b.name not in ("subs", "nop") for b in body):
        return 1
    register = re.match(r"\w+", counts[0].operands).group()
    entered = []
    for at, known in before.items():
        if at != i.address and i.target in image.within(image.code[at]):
            entered.append(step(image, image.code[at], known).get(register))
    return entered[0] if entered and all(e is not None and e == entered[0] for e in entered) else 1


def ways(image, i, taken, loops):
    """(address, cycles) that may come next, of the whole program."""
    own = 0 if i.name.startswith("it") else 1
    on = []
    if i.is_call():
        callees = [i.target] if i.target in image.returns else image.pointed
        return [(c, taken) for c in callees]
    if i.is_return() or (i.name == "bx"):
        function = image.function_of[i.address]
        on = [(a, taken) for a in image.returns[function]]
        if not i.is_return():
            on += [(c, taken) for c in image.pointed]
        return on
    if i.target is not None:
        on.append((i.target, taken))
    if not i.is_jump():
        rounds = loops.get(i.address)
        if rounds:  # the way out has all rounds behind it; the way back is not one
            body, n = rounds
            return [(i.next, own + (n - 1) * (body + taken))]
        on.append((i.next, own))
    elif i.name in ("tbb", "tbh"):
        on += [(a, taken) for a in image.within(i)]
    return on


def cheapest(image, before, levels, level, taken):
    loops = {}
    for at in before:
        n = rounds_of(image, before, image.code[at])
        if n > 1:
            body = sum(a in image.code for a in range(image.code[at].target, at, 2))
            loops[at] = (body, n)
    best = None
    for begin in sorted(a for a, may in levels.items() if level in may):
        queue, done = [(0, begin, True)], set()
        while queue:
            cycles, at, first = heapq.heappop(queue)
            if best and cycles >= best[0]:
                break
            if not first and at in levels:
                if (not level) in levels[at]:
                    best = (cycles, begin, at)
                    break
                if levels[at] == {level}:
                    continue
            if at in done or at not in image.code:
                continue
            if not first:
                done.add(at)
            for on, cost in ways(image, image.code[at], taken, loops):
                heapq.heappush(queue, (cycles + cost, on, False))
    return best


def main():
    parser = argparse.ArgumentParser(description="least cycles between two stores to a pin")
    parser.add_argument("elf")
    parser.add_argument("port", choices=list("ABCDEFGHI"))
    parser.add_argument("pin", type=int)
    parser.add_argument("level", choices=("high", "low"))
    parser.add_argument("--taken", type=int, default=2)
    given = parser.parse_args()
    image = Image(given.elf)
    before = constants(image)
    levels, unknown = stores(image, before, ord(given.port) - ord("A"), given.pin)
    best = cheapest(image, before, levels, given.level == "high", given.taken)
    print(f"{len(levels)} stores to P{given.port}{given.pin} in " + ", ".join(sorted({image.name(a) for a in levels})) +
          f"; {unknown} stores whose address is not known", file=sys.stderr)
    if not best:
        print("no way from one such store to another", file=sys.stderr)
        return 1
    print(best[0], f"0x{best[1]:08x}", image.name(best[1]), f"0x{best[2]:08x}", image.name(best[2]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
