"""Decodes a candump log by a DBC file with a parser that is not ours (canmatrix) and holds it against a table of matrig export.
usage: dbc_read.py DBC LOG CSV: prints what was compared; exit 1 when anything differs.
       dbc_read.py DBC: name and identifier of each message."""
import logging
import re
import sys

import canmatrix
import canmatrix.formats

complaints = []
heard = logging.Handler(logging.WARNING)
heard.emit = complaints.append
logging.getLogger("canmatrix").addHandler(heard)
matrix = canmatrix.formats.loadp_flat(sys.argv[1])
if complaints:  # a line that it does not understand
    sys.exit(complaints[0].getMessage())
if len(sys.argv) == 2:
    for frame in matrix.frames:
        print(frame.name, frame.arbitration_id.id)
    sys.exit()
log, table = sys.argv[2:]

lines = [line.rstrip("\n").split(",") for line in open(table) if not line.startswith("#")]
names, rows = lines[0], {int(cells[1]): cells for cells in lines[1:]}
newest = first = min(rows)
compared = wrong = missing = frames = 0
offset = {}  # displacement in the table counts from the baseline: the same for all of a channel
for line in open(log):
    found = re.match(r"^\(\d+\.\d+\) \S+ ([0-9A-F]{3})#((?:[0-9A-F]{2})*)$", line)
    message = int(found[1], 16) if found else 0
    if not (0x100 <= message <= 0x102 or 0x110 <= message <= 0x114):
        continue
    frame = matrix.frame_by_id(canmatrix.ArbitrationId(message, extended=False))
    if not frame:
        wrong += 1
        continue
    signals = frame.decode(bytes.fromhex(found[2]))
    step = (signals["block16"].raw_value - newest) & 0xFFFF  # the block whose low 16 bits are given, near the one before
    newest += step - 0x10000 if step >= 0x8000 else step
    frames += 1
    for name, signal in signals.items():
        if not re.match(r"^[dt]\d+_(in|lb)$", name):
            continue
        value, empty, moves = float(signal.phys_value), signal.raw_value == -32768, name.startswith("d")
        for block in range(newest - (2 if message < 0x110 else 4) + 1, newest + 1):
            cell = rows[block][names.index(name)] if block in rows else None
            if cell is None:
                continue
            if empty or cell == "":
                missing += 1
                wrong += empty != (cell == "")
                continue
            if moves:
                value_here = value - offset.setdefault(name, value - float(cell))
            else:
                value_here = value
            compared += 1
            wrong += abs(value_here - float(cell)) > (1.01e-5 if moves else 0.501e-3)
cyclic = [(f.arbitration_id.id, int(f.cycle_time)) for f in matrix.frames if f.cycle_time]
print(f"{len(matrix.frames)} messages, {frames} frames, {compared} values compared, {missing} missing, {wrong} wrong, {len(cyclic)} cycle times")
for identifier, ms in cyclic:
    print(f"cycle {identifier:03X} {ms}")
states = matrix.frame_by_name("landing").signal_by_name("state").values
print("state", *[states[k] for k in sorted(states)])
sys.exit(1 if wrong or compared == 0 or max(rows) <= first else 0)
