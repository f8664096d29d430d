"""The figures: measured by the simulations, kept in figures.def, held against the kept ones and against what others assume; and what is
made of them and of the schematics for people: drawings, parts, connectors, tables."""
import csv
import math
import os
import re
import subprocess

import sim_bridge
import sim_lamp
import sim_power
import sim_staircase
import sim_transducer
from netlist import BLOCKS as SHEETS, PAGES, environment

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "..", ".."))
KEPT = os.path.join(HERE, "figures.def")
BLOCKS = {"power": sim_power, "transducer": sim_transducer, "bridge": sim_bridge, "staircase": sim_staircase, "lamp": sim_lamp}
ROW = re.compile(r'FIGURE\((\w+), (-?[\d.]+(?:e[-+]?\d+)?), "([^"]*)", "([^"]*)", "([^"]*)"\)')

HEAD = """/* What the reference electronics do: simulated from the schematics of this folder. Made by
 * `make circuits-figures`; `make circuits` fails when a simulation says something else. Do not edit.
 *
 *     FIGURE(name, value, "unit", "block", "what, and how it was found")
 *
 * `sd`: standard deviation over copies with drawn tolerances. `rel`: relative; `part`: of all.
 * Include after defining FIGURE; it is undefined at the end. */
"""


def measure(parts, work, block):
    """{name: (value, unit, block, what)} of a block."""
    return {name: (value, unit, "converter" if name.startswith("adc_") else block, what)
            for name, value, unit, what in BLOCKS[block].figures(parts, work)}


def number(value):
    """Four digits, as a C constant of type double."""
    text = f"{value:.4g}"
    return text if re.search(r"[.en]", text) else text + ".0"


def as_text(figures):
    rows = [f'FIGURE({name}, {number(value)}, "{unit}", "{block}",\n       "{what}")\n' for name, (value, unit, block, what) in figures.items()]
    return HEAD + "".join(rows) + "#undef FIGURE\n"


def kept(path=KEPT):
    text = re.sub(r",\n\s+", ", ", open(path).read())
    return {m[1]: (float(m[2]), m[3], m[4], m[5]) for m in ROW.finditer(text)}


def slack(name):
    """How far a figure may lie from the kept one: (relative, absolute). Draws have their seeds; what is left is that a part
    more or less makes other draws: a standard deviation of 40 copies is good to 11 %, twice that and more is a change."""
    if re.search(r"_sd_|_left_|drift|error|_most_|_least_|noise|spread", name):
        return 0.3, 1e-12
    if "_part" in name:
        return 0.0, 0.08
    if name.endswith(("_reference_rel", "_vdda_rel")):
        return 0.0, 1e-4
    if "late" in name:
        return 0.5, 1e-9
    return 0.02, 1e-12


def differences(measured, known):
    said = []
    for name, (value, unit, _, _) in measured.items():
        if name not in known:
            said.append(f"figures: {name} is not in figures.def; run: make circuits-figures")
            continue
        relative, absolute = slack(name)
        was = known[name][0]
        if not abs(value - was) <= relative * abs(was) + absolute:
            said.append(f"figures: {name} is {number(value)} {unit} by the simulation, {number(was)} in figures.def")
    return said


# What must hold whatever is kept: (figure, least, most, why).
LIMITS = [
    ("gage_reference_rel", -3e-4, 3e-4, "rule 1"), ("gage_vdda_rel", -3e-4, 3e-4, "rule 1"),
    ("transducer_reference_rel", -3e-4, 3e-4, "rule 2"), ("transducer_vdda_rel", -3e-4, 3e-4, "rule 2"),
    ("staircase_vdda_rel", -1e-4, 1e-4, "rule 3"),
    ("gage_v_per_lb", 0.00495, 0.00505, "5 mV/lb within 1 %, as config.c and the rig have it"),
    ("gage_zero_v", 0.396, 0.404, "the 0.4 V that stands for no tension"),
    ("gage_trim_beyond_part", 0, 0, "every bridge can be balanced"),
    ("gage_trim_left_lb", 0, 1, "config.c says 1 lb"),
    ("gage_shunt_lb", 39.2, 40.8, "the shunt stands for 40 lb"),
    ("transducer_mid_v", 1.32, 1.98, "channels.h calls a common mode beyond a fifth open or shorted"),
    ("transducer_settle_us", 0, 4, "28 us are 7 time constants"),
    ("transducer_late_rel", -0.001, 0.001, "eight channels read alike"),
    ("staircase_opened_right", 1, 1, "switches name themselves"),
    ("staircase_step_most_codes", 0, 2, "half of the 4 codes are left to the converter"),
    ("staircase_top_codes", 0, 4080, "all switches open stay inside the converter"),
    ("one_shot_least_us", 10, 30, "an edge that TIM2 sees, and no two in one"),
    ("one_shot_most_us", 10, 30, "an edge that TIM2 sees, and no two in one"),
    ("gage_supply_short_a", 0, 0.6, "R813 limits what a shorted lead takes from 5 V"),
    ("lamp_undriven_a", 0.35, 0.5, "a dead board warns"),
    ("lamp_told_right", 1, 1, "PE3 says whether the lamp draws current"),
    ("lamp_sense_threshold_a", 0.1, 0.3, "between nothing and a hot lamp"),
]


def beyond(measured):
    return [f"limits: {name} is {number(measured[name][0])}, wanted {least:g} to {most:g}: {why}"
            for name, least, most, why in LIMITS if name in measured and not least <= measured[name][0] <= most]


# What firmware and emulator assume: figure, file, pattern of the number, factor to the figure's unit, relation, what.
# "near x": within x of it; "below": no more than it; "above": no less.
ASSUMED = [
    ("transducer_settle_us", "hil/rig/rig.c", r"TRANSDUCER_TAU_S +([\d.e-]+)", 1e6, "below", "time constant of the emulated transducer"),
    ("transducer_mid_v", "hil/rig/rig.c", r"TRANSDUCER_MID_V +([\d.]+)", 1, 0.02, "common mode voltage of the emulated transducer"),
    ("transducer_top_in", "firmware/config.c", r"\.low = -0\.5f, \.high = ([\d.]+)f", 1, "above", "upper limit of the range in the firmware"),
    ("transducer_gain_sd_rel", "firmware/config.c", r"TRANSDUCER_ERRORS[\s\\]+\.gain_error = ([\d.]+)", 1, "below", "stated gain error without calibration"),
    ("gage_v_per_lb", "hil/rig/rig.c", r"GAGE_V_PER_LB +([\d.]+)", 1, 0.01, "sensitivity of the emulated gage"),
    ("gage_v_per_lb", "firmware/config.c", r"LB_PER_CODE +\(3\.3f / 4096\.0f / ([\d.]+)f", 1, 0.01, "sensitivity in the firmware"),
    ("gage_zero_v", "hil/rig/rig.c", r"GAGE_ZERO_V +([\d.]+)", 1, 0.005, "emulated gage at zero tension"),
    ("gage_zero_v", "firmware/config.c", r"TENSION_ZERO_CODE +\(([\d.]+)f", 1, 0.005, "voltage at zero tension in the firmware"),
    ("gage_zero_sd_lb", "firmware/config.c", r"BRIDGE_ERRORS[\s\\]+\.gain_error = [\d.]+f, \.zero_error = ([\d.]+)", 1, "below",
     "stated zero error, before trimming"),
    ("gage_trim_left_lb", "firmware/config.c", r"BRIDGE_ERRORS[\s\\]+\.gain_error = [\d.]+f, \.zero_error = ([\d.]+)", 1, "below", "stated zero error, after trimming"),
    ("gage_gain_sd_rel", "firmware/config.c", r"BRIDGE_ERRORS[\s\\]+\.gain_error = ([\d.]+)", 1, "below", "stated gain error"),
    ("gage_drift_lb_k", "firmware/config.c", r"BRIDGE_ERRORS.*[\s\\]+\.gain_error.*drift_error_per_h = ([\d.]+)", 0.2, "below", "stated drift per hour, divided by 5 K per hour"),
    ("gage_shunt_lb", "hil/rig/rig.h", r"HIL_RIG_SHUNT_LB +([\d.]+)", 1, 0.01, "emulated shunt"),
    ("gage_shunt_lb", "firmware/config.c", r"\.shunt_lb = ([\d.]+)", 1, 0.01, "shunt in the firmware"),
    ("staircase_settle_us", "hil/rig/rig.c", r"STAIRCASE_TAU_S +([\d.e-]+)", 1e6, 0.05, "time constant of the emulated staircase"),
    ("staircase_settle_us", "common/staircase.h", r"SETTLE_TICKS +(\d+)u", 1 / 84 / 8, "below", "settling time in the firmware, divided by 8 (time constants)"),
    ("staircase_step_most_codes", "common/staircase.h", r"TOLERANCE_CODES +([\d.]+)", 0.5, "below", "half of the step tolerance in the firmware"),
    ("one_shot_least_us", "hil/rig/electronics.h", r"HIL_PULSE_PS +(\d+)ull", 1e-6, 0.15, "pulse width of the emulated edge"),
    ("one_shot_most_us", "hil/rig/electronics.h", r"HIL_PULSE_PS +(\d+)ull", 1e-6, 0.15, "pulse width of the emulated edge"),
    ("edge_delay_spread_us", "firmware/config.c", r"switch_error_ft = ([\d.]+)f / 12", 1e6 / 240, "below", "stated error of a switch station, divided by 20 ft/s"),
    ("reference_read_sd_rel", "firmware/config.c", r"REFERENCE_GAIN_ERROR +([\d.]+)", 1.1, "below", "stated error of the reference, times 1.1"),
    ("gage_noise_lsb", "common/staircase.h", r"noise of (\d+) codes", 1, "below", "noise assumed by the estimators"),
]


def beside(figures):
    """Rows of (figure, value, unit, file, what, assumed or None, holds)."""
    rows = []
    for name, path, pattern, factor, relation, what in ASSUMED:
        value, unit = figures[name][:2]
        found = re.search(pattern, open(os.path.join(ROOT, path)).read())
        assumed = float(found.group(1)) * factor if found else None
        holds = assumed is None or (value <= assumed if relation == "below" else value >= assumed if relation == "above"
                                    else abs(value / assumed - 1) <= relation)
        rows.append((name, value, unit, path, what, assumed, holds and not math.isnan(value)))
    return rows


# ---- for people ----

PICTURES = os.path.join(ROOT, "docs", "pictures")
PAGE = os.path.join(ROOT, "hil", "circuits", "FIGURES.md")
PARTS_PAGE = os.path.join(ROOT, "docs", "electronics", "parts.md")


def slimmer(svg):
    """The same picture with places to a hundredth of a point and each style written once, half the size. Scales (transform)
    stay as they are."""
    def rounded(m):
        return f"{float(m[0]):.2f}".rstrip("0").rstrip(".")
    svg = re.sub(r' (?:d|x|y)="[^"]*"', lambda m: re.sub(r"\d+\.\d{3,}", rounded, m[0]), svg)
    styles = {}
    svg = re.sub(r' style="([^"]*)"', lambda m: f' class="{styles.setdefault(m[1], "s" + str(len(styles)))}"', svg)
    sheet = "".join(f".{name}{{{style}}}" for style, name in styles.items())
    return svg.replace("<defs>", f"<style>{sheet}</style>\n<defs>", 1)


def draw(folder, work):
    """An SVG of each sheet."""
    made = []
    for sheet in PAGES + SHEETS:
        out = os.path.join(work, f"circuit-{sheet}.svg")
        done = subprocess.run(["lepton-cli", "export", "--color", "-o", out, sheet + ".sch"], cwd=folder, capture_output=True,
                              text=True, timeout=120, env=environment())
        if done.returncode or not os.path.exists(out):
            raise SystemExit(f"circuits: {sheet}.sch is not drawn: {done.stderr.strip()}")
        text = slimmer(open(out).read())
        with open(out, "w") as file:
            file.write(text)
        made.append(out)
    return made


def natural(text):
    return [int(t) if t.isdigit() else t for t in re.split(r"(\d+)", text)]


def bill(parts):
    """(count, device, value, tolerance, footprint, maker's number, refdes...) of each kind."""
    kinds = {}
    for part in parts.values():
        key = (part["device"], part["value"], part["tol"], part["footprint"], part["part"])
        kinds.setdefault(key, []).append(part.refdes)
    rows = [(len(refs), *key, sorted(refs, key=natural)) for key, refs in kinds.items()]
    return sorted(rows, key=lambda r: (r[1], natural(r[2])))


def short(refs):
    """"G1/R5 G2/R5 ..." as "G1..14/R5"."""
    blocks, rest = {}, []
    for ref in refs:
        match = re.fullmatch(r"([A-Z]+)(\d+)/(\w+)", ref)
        if match:
            blocks.setdefault((match[1], match[3]), []).append(int(match[2]))
        else:
            rest.append(ref)
    return " ".join([f"{b}{min(n)}..{max(n)}/{p}" for (b, p), n in blocks.items()] + rest)


def write_bill(parts, path):
    with open(path, "w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["count", "kind", "value", "tolerance", "footprint", "maker's number", "parts"])
        for row in bill(parts):
            out.writerow([*row[:-1], " ".join(row[-1])])


def connectors(parts):
    return sorted(((p.refdes, p["value"], p["footprint"], p["part"], sorted(((n, net) for n, _, net in p.pins), key=lambda x: natural(x[0])))
                   for p in parts.values() if p["device"] == "CONNECTOR"), key=lambda row: natural(row[0]))


def meaning(net):
    return "-" if re.search(r"unnamed_net", net) else re.sub(r"^\w+/", "", net)


def passives(kinds):
    """Resistors and capacitors, which have no part number: a row of all values of a tolerance and footprint."""
    groups = {}
    for n, kind, value, tol, foot, part, _ in kinds:
        if kind in ("RESISTOR", "CAPACITOR") and not part:
            groups.setdefault((kind, tol, foot), []).append(f"{value} ({n})" if n > 1 else value)
    return [f"| {kind.lower()} | {tol} | {foot} | {', '.join(values)} |" for (kind, tol, foot), values in groups.items()]


def parts_page(parts):
    kinds = bill(parts)
    lines = ["# Parts and connectors of the reference electronics", "",
             "<!-- Made by `make circuits-figures` from the schematics in hil/circuits. Do not edit. -->", "",
             f"{sum(row[0] for row in kinds)} parts of {len(kinds)} kinds. `G1..14/R5` is R5 in each of the fourteen blocks G. Sensors are not counted. "
             "`make circuits` writes a list with all references, `build/circuits/parts.csv`.", "",
             "## Resistors and capacitors", "",
             "| Kind | Tolerance | Footprint | Values (count, if more than one) |", "|---|---|---|---|", *passives(kinds), "",
             "## Other parts", "", "| Count | Kind | Footprint | Part number | References |", "|--:|---|---|---|---|"]
    lines += [f"| {n} | {' '.join(filter(None, [kind.lower().replace('_', ' '), value, tol]))} | {foot} | {part} | {short(refs)} |"
              for n, kind, value, tol, foot, part, refs in kinds if kind != "CONNECTOR" and (part or kind not in ("RESISTOR", "CAPACITOR"))]
    lines += ["", "## Connectors", "", "`-`: the pin connects only to parts within its block; see the drawing.", "",
              "| Connector | Purpose | Footprint | Part number | Pins |", "|---|---|---|---|---|"]
    seen = set()
    for ref, what, foot, number, pins in connectors(parts):
        block = re.fullmatch(r"([A-Z]+)\d+/(\w+)", ref)
        if block and (block[1], block[2]) in seen:
            continue
        if block:
            seen.add((block[1], block[2]))
            ref = short([r for r in parts if re.fullmatch(rf"{block[1]}\d+/{block[2]}", r)])
        lines.append(f"| {ref} | {what} | {foot} | {number} | " + ", ".join(f"{n} {meaning(net)}" for n, net in pins) + " |")
    return "\n".join(lines) + "\n"


def figures_page(figures):
    lines = ["# Figures of the reference electronics", "",
             "<!-- Made by `make circuits-figures` from the simulations in hil/circuits. Do not edit. -->", "",
             "The table compares the values that firmware and emulated board assume with the simulated values. *Included*: the code uses the simulated value. `hil/circuits/figures.def` has all",
             "simulated figures with their meaning and source.", "",
             "| Figure | Simulated | Assumed | Meaning of the assumed value | Holds |", "|---|--:|--:|---|---|"]
    for name, value, unit, _, what, assumed, holds in beside(figures):
        unit = "" if unit == "1" else " " + unit
        told = "*included*" if assumed is None else number(assumed) + unit
        lines.append(f"| {name} | {number(value)}{unit} | {told} | {what} | {'yes' if holds else '**no**'} |")
    return "\n".join(lines) + "\n"
