"""Compares the schematics with the pin table, the package, the reference rules and themselves."""
import os
import re

from netlist import lepton, nets

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
TABLE = os.path.join(ROOT, "firmware", "boards", "zg.def")
PLACES = os.path.join(ROOT, "tests", "conformance", "pins-413.txt")  # of ST's pin database
CHIP = "U1"
# The chip's own pins, which are no signals of the firmware: their nets.
OWN = {"PA13": "SWDIO", "PA14": "SWCLK", "PH0": "OSC_IN", "PH1": "OSC_OUT", "NRST": "NRST", "BOOT0": "BOOT0", "PB2": None}
# Supply pins of the LQFP144 (STM32F407 data sheet, pins and ball definitions), and the rail of each.
SUPPLY = {"3V3": "17 30 39 52 62 72 84 95 108 121 131 144 6 143", "VDDA": "33 32", "GND": "16 38 51 61 83 94 107 120 130 31"}
# What floats until the firmware runs and has nobody who says so in the table.
PULLED = {"EXCITATION_PLUS": "down", "EXCITATION_MINUS": "down", "MEMORY_IN": "up"}
RAILS = {"up": ("3V3",), "down": ("GND",)}


def table_rows(path=TABLE):
    """(kind, pin, SIGNAL, text) of each row; a row may go on in the next line."""
    text = open(path).read()
    kinds = "ANALOGUE|FUNCTION|OUTPUT|INPUT"
    found = re.findall(rf'^({kinds})\((\w), (\d+),[^;]*?(\w+),\s*"([^"]*)"\)$', text, re.M)
    if len(found) != len(re.findall(rf"^(?:{kinds})\(", text, re.M)):
        raise SystemExit(f"circuits: {path} has rows that cannot be parsed")
    return [(kind, f"P{port}{number}", signal, words) for kind, port, number, signal, words in found]


def reaches(signal):
    """What must stand on a signal's net besides the chip: (refdes, pin label), or the beginning of a block's."""
    numbered = re.fullmatch(r"(TRANSDUCER|GAGE)_(\d+)", signal)
    if numbered:
        block, part = {"TRANSDUCER": ("T", "R9"), "GAGE": ("G", "R6")}[numbered.group(1)]
        return [(f"{block}{numbered.group(2)}/{part}", "2")]
    return {
        "STAIRCASE": [("C301", "2"), *[(f"R{330 + n}", "2") for n in range(1, 25)]],
        "REFERENCE": [("R801", "2"), ("C808", "2")],
        "EXCITATION_PLUS": [(f"T{n}/U1", "1A") for n in range(1, 9)],
        "EXCITATION_MINUS": [(f"T{n}/U1", "2A") for n in range(1, 9)],
        "EDGE": [("R367", "2")], "CAMERA_FRAME": [("X701/U1", "Y")], "CAMERA_TRIGGER": [("U701", "A")],
        "SERIAL_OUT": [("R604", "1")], "SERIAL_IN": [("R605", "1")], "CAN_IN": [("U601", "R")], "CAN_OUT": [("U601", "D")],
        "MEMORY_SELECT": [("U501", "/CS")], "MEMORY_CLOCK": [("U501", "CLK")], "MEMORY_IN": [("U501", "DO")],
        "MEMORY_OUT": [("U501", "DI")], "THERMOMETER_CLOCK": [("R609", "1")], "THERMOMETER_DATA": [("R610", "1")],
        "WARNING": [("R401", "1")], "LAMP": [("U401", "OUT")], "SHUNTS": [("R201", "1")],
        "MAINTENANCE": [("R705", "1")], "BRAKE_APPLIED": [("X702/U1", "Y")], "WHEEL_SPEED": [("X703/U1", "Y")],
    }.get(signal, [("nothing that check.py knows", "")])


def drc(folder):
    """Lines of lepton's design rule check that report a problem; its exit code is always 0."""
    text, errors, _ = lepton(folder, ["-g", "drc2"])
    lines = [line for line in text.splitlines() if re.match(r"ERROR|WARNING", line)]
    if "No errors found." not in text and not lines:
        lines.append(f"ERROR: drc2 printed nothing: {errors.strip()}")
    return ["rules: " + line for line in lines]


def table_against_chip(parts, rows):
    said = []
    place = {line.split()[0]: line.split()[1] for line in open(PLACES) if re.match(r"P[A-I]\d", line)}
    at = {label: (number, net) for number, label, net in parts[CHIP].pins}
    on_net = {net: {(part.refdes, label) for part, _, label in pins} for net, pins in nets(parts).items()}
    for kind, pin, signal, _ in rows:
        number, net = at.get(pin, (None, None))
        if number is None:
            said.append(f"pins: zg.def has {signal} at {pin}, a pin that the chip's symbol lacks")
            continue
        if number != place.get(pin):
            said.append(f"pins: {pin} is pin {place.get(pin)} of the LQFP144, but {number} in the symbol")
        if net != signal:
            said.append(f"pins: {pin} is on net {net}, but zg.def names it {signal}")
        for end in reaches(signal):
            if end not in on_net.get(signal, set()):
                said.append(f"pins: {signal} does not reach pin {end[1]} of {end[0]}")
    named = {pin for _, pin, _, _ in rows}
    for label, (_, net) in at.items():
        if label in OWN and OWN[label] not in (None, net):
            said.append(f"pins: {label} is on net {net}, not {OWN[label]}")
        if re.fullmatch(r"P[A-I]\d+", label) and label not in named and label not in OWN:
            said.append(f"pins: {label} ({net}) has no row in zg.def")
    for rail, numbers in SUPPLY.items():
        for number in numbers.split():
            net = next((n for num, _, n in parts[CHIP].pins if num == number), "nothing")
            if net != rail:
                said.append(f"pins: supply pin {number} is on {net}, not {rail}")
    return said


def pulls(parts, rows):
    said, wanted = [], dict(PULLED)
    for _, _, signal, text in rows:
        found = re.search(r"external pull-(up|down)", text)
        if found:
            wanted[signal] = found.group(1)
    if len(wanted) == len(PULLED):
        said.append("pulls: no row of zg.def mentions external pull-up or external pull-down")
    for signal, way in wanted.items():
        ends = [{net for _, _, net in p.pins} for p in parts.values() if p["device"] == "RESISTOR"]
        if not any({signal, rail} == pair for pair in ends for rail in RAILS[way]):
            said.append(f"pulls: no resistor pulls {signal} {way}")
    return said


def rules(parts):
    """The three reference rules, and the order of the switches."""
    said = []

    def holds(refdes, label, net, why):
        part = parts.get(refdes)
        found = part.net(label) if part else "nothing"
        if found != net:
            said.append(f"reference: pin {label} of {refdes} is on {found}, not {net}: {why}")
    for n in range(1, 15):
        holds(f"G{n}/J1", "1", "2V5G", "rule 1, a bridge is excited from 2.5 V")
    for n in range(1, 9):
        holds(f"T{n}/U1", "VCC", "2V5T", "rule 2, a transducer's drive is supplied by 2.5 V")
    for refdes in ("U805", "U806"):
        holds(refdes, "IN+", "2V5", "rules 1 and 2, both supplies follow the reference")
    for n in range(1, 25):
        holds(f"S{n}/U1", "VCC", "VDDA", "rule 3, a step is relative to VDDA")
        holds(f"R{300 + n}", "1", parts[f"S{n}/U1"].net("Y"), f"step {n} belongs to switch {n}")
    holds("R801", "1", "2V5", "PC5 reads the reference")
    holds("R362", "2", "VDDA", "rule 3, so is the zero")
    return said


def whole(parts):
    """Every pin is connected, and every part can be bought."""
    said = []
    for net, pins in nets(parts).items():
        unused = {("U601", "VREF"), ("U602", "ALERT"), ("J602", "4")}
        if len(pins) < 2 and (pins[0][0].refdes, pins[0][2]) not in unused:
            part, number, _ = pins[0]
            said.append(f"wires: pin {number} of {part.refdes} is not connected")
    for part in parts.values():
        if not part["footprint"]:
            said.append(f"parts: {part.refdes} has no footprint")
        if part["device"] in ("RESISTOR", "CAPACITOR"):
            try:
                part.value()
                part.tolerance()
            except ValueError as error:
                said.append(f"parts: {error}")
        elif not part["part"] and not part["value"]:
            said.append(f"parts: {part.refdes} has neither a part number nor a value")
    return said


def everything(parts):
    rows = table_rows()
    if len(rows) < 40:
        return [f"pins: only {len(rows)} rows found in {TABLE}"]
    return table_against_chip(parts, rows) + pulls(parts, rows) + rules(parts) + whole(parts)
