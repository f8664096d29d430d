#!/usr/bin/env python3
"""The reference electronics: checked, drawn, simulated.

usage: circuits.py [--folder FOLDER] [--blocks NAME,...] [--cache FOLDER] [--keep] WORK

Reads the schematics in FOLDER (default: this one), checks them, writes parts and drawings to the folder WORK, simulates
the blocks and holds the figures against figures.def. --keep writes figures.def, the pages and the drawings of the sources. Lepton's compiled programs
are kept in the cache, WORK/cache if no other is named.

Exit: 0 all is well, 1 something is not (a line each on stdout), 2 usage or a tool that failed."""
import argparse
import concurrent.futures
import os
import shutil
import sys
import time

sys.dont_write_bytecode = True  # nothing is left in the sources

import check
import figures
import netlist


def put(path, text):
    with open(path, "w") as file:
        file.write(text)


def stale(path, text, names_only=False):
    """Generated pages that differ from what would be generated. Figures may differ within their slack: of their tables only the names count."""
    def words(lines):
        return [line.split("|")[1] if names_only and line.startswith("|") else line for line in lines]
    if os.path.exists(path) and words(open(path).read().splitlines()) == words(text.splitlines()):
        return []
    return [f"pages: {os.path.relpath(path, check.ROOT)} differs from what the schematics give; run: make circuits-figures"]


def keep(parts, measured, drawings):
    put(figures.KEPT, figures.as_text(measured))
    put(figures.PAGE, figures.figures_page(measured))
    put(figures.PARTS_PAGE, figures.parts_page(parts))
    for drawing in drawings:
        shutil.copy(drawing, figures.PICTURES)


def main():
    options = argparse.ArgumentParser(add_help=False)
    options.add_argument("--folder", default=netlist.HERE)
    options.add_argument("--blocks")
    options.add_argument("--cache")
    options.add_argument("--keep", action="store_true")
    options.add_argument("work")
    given = options.parse_args()
    work = os.path.abspath(given.work)
    os.makedirs(work, exist_ok=True)
    netlist.cache = os.path.abspath(given.cache or os.path.join(work, "cache"))
    os.makedirs(netlist.cache, exist_ok=True)
    blocks = given.blocks.split(",") if given.blocks else None

    begin = time.monotonic()

    def tell(what):
        print(f"{time.monotonic() - begin:6.1f} s  {what}", flush=True)
    # The first time one of them compiles what both need.
    with concurrent.futures.ThreadPoolExecutor(2 if os.listdir(netlist.cache) else 1) as pool:
        rules = pool.submit(check.drc, given.folder)
        reading = pool.submit(netlist.read, given.folder)
        parts = reading.result()
        said = rules.result() + check.everything(parts)
    tell(f"{len(parts)} parts, {len(netlist.nets(parts))} nets; rules, pins, pulls, references: {len(said) or 'nothing'} wrong")
    figures.write_bill(parts, os.path.join(work, "parts.csv"))
    drawings = [] if blocks is not None else figures.draw(given.folder, work)
    tell(f"parts.csv, {len(drawings)} drawings")
    measured = {}
    if not said:  # a circuit that is not whole has no figures
        wanted = [block for block in figures.BLOCKS if blocks is None or block in blocks]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            for block, found in zip(wanted, pool.map(lambda b: figures.measure(parts, work, b), wanted)):
                measured.update(found)
                tell(f"{block} simulated")
        said += figures.beyond(measured)
        if given.keep and not said:
            keep(parts, measured, drawings)
        said += figures.differences(measured, figures.kept())
        if blocks is None and given.folder == netlist.HERE:
            said += stale(figures.PARTS_PAGE, figures.parts_page(parts)) + stale(figures.PAGE, figures.figures_page(measured), names_only=True)
            for name, value, unit, path, what, assumed, holds in figures.beside(measured):
                if not holds:
                    print(f"          {name} is {figures.number(value)} {unit}; {path} assumes {figures.number(assumed)}: {what}")
    for line in said:
        print(line)
    tell(f"{len(measured)} figures; {len(said) or 'nothing'} wrong")
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main())
