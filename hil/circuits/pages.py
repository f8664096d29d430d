"""What is made of the schematics for people: drawings, parts, connectors, tables of figures."""
import csv
import os
import re
import subprocess

from figures import beside, number
from netlist import BLOCKS, HERE, PAGES, environment

ROOT = os.path.normpath(os.path.join(HERE, "..", ".."))
PICTURES = os.path.join(ROOT, "docs", "pictures")
PAGE = os.path.join(ROOT, "docs", "electronics", "figures.md")
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
    for sheet in PAGES + BLOCKS:
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
    return sorted(((p.refdes, p["value"], sorted(((n, net) for n, _, net in p.pins), key=lambda x: natural(x[0])))
                   for p in parts.values() if p["device"] == "CONNECTOR"), key=lambda row: natural(row[0]))


def meaning(net):
    return "-" if re.search(r"unnamed_net", net) else re.sub(r"^\w+/", "", net)


def parts_page(parts):
    kinds = bill(parts)
    lines = ["# Parts and connectors of the reference electronics", "",
             "<!-- Made by `make circuits-figures` from the schematics in hil/circuits. Do not edit. -->", "",
             f"{sum(row[0] for row in kinds)} parts of {len(kinds)} kinds. `G1..14/R5` is R5 of each of the fourteen blocks G; the sensors are not counted.", "",
             "| count | kind | value | tolerance | footprint | maker's number | parts |", "|---|---|---|---|---|---|---|"]
    lines += [f"| {n} | {kind.lower().replace('_', ' ')} | {value} | {tol} | {foot} | {part} | {short(refs)} |" for n, kind, value, tol, foot, part, refs in kinds]
    lines += ["", "## Connectors", "", "A pin without a name leads to a part of its block alone: see the drawing.", "",
              "| connector | for | pins |", "|---|---|---|"]
    seen = set()
    for ref, what, pins in connectors(parts):
        block = re.fullmatch(r"([A-Z]+)\d+/(\w+)", ref)
        if block and (block[1], block[2]) in seen:
            continue
        if block:
            seen.add((block[1], block[2]))
            ref = short([r for r in parts if re.fullmatch(rf"{block[1]}\d+/{block[2]}", r)])
        lines.append(f"| {ref} | {what} | " + ", ".join(f"{n} {meaning(net)}" for n, net in pins) + " |")
    return "\n".join(lines) + "\n"


def figures_page(figures):
    lines = ["# Figures of the reference electronics", "",
             "<!-- Made by `make circuits-figures` from the simulations in hil/circuits. Do not edit. -->", "",
             "What firmware and emulated board assume, beside what the circuits do. \"taken from here\": the file includes `hil/circuits/figures.def`.", "",
             "| figure | circuit | assumed | by | what | holds |", "|---|---|---|---|---|---|"]
    for name, value, unit, path, what, assumed, holds in beside(figures):
        unit = "" if unit == "1" else " " + unit
        told = "taken from here" if assumed is None else number(assumed) + unit
        lines.append(f"| {name} | {number(value)}{unit} | {told} | `{path}` | {what} | {'yes' if holds else '**no**'} |")
    block = None
    for name, (value, unit, here, what) in figures.items():
        if here != block:
            lines += ["", f"## {here.capitalize()}", "", "| figure | value | what, and how it was found |", "|---|---|---|"]
            block = here
        lines.append(f"| {name} | {number(value)}{'' if unit == '1' else ' ' + unit} | {what} |")
    return "\n".join(lines) + "\n"
