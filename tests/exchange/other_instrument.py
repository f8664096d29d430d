#!/usr/bin/env python3
"""What other programs' data look like, from closed forms alone: nothing of matrig's is used or read.

usage: other_instrument.py FOLDER SWITCH3_S

lvdt.csv    a German logger at 500 Hz: semicolons, decimal commas, ms, two header lines, comments, '---' for what is missing.
            Displacement 2 of 10 mm (1 - cos(2 pi t / 4 s)) from t = 0 on, as volts of 4 mm/V about 2.5 V; a trigger that falls through
            2.5 V at its time 4321 ms, which is when switch 3 opened: SWITCH3_S of the landing's time since touchdown.
gear.csv    a camera's track at 100 Hz: station of the gear in m, x = 3 ft + 36 ft/s t - 4 ft/s2 t^2, and tension 1 in N, 400 + 50 t.
frames.log  two instruments on a CAN bus, extended and big-endian, with frames.dbc; displacement 1 is 0.5 in t, tension 3 is 90 lb - t.
"""
import math
import struct
import sys

folder, switch3_s = sys.argv[1], float(sys.argv[2])


def displacement_mm(t):
    return 10.0 * (1.0 - math.cos(2.0 * math.pi * t / 4.0)) if t > 0.0 else 0.0


def comma(x, digits):
    return f"{x:.{digits}f}".replace(".", ",")


with open(f"{folder}/lvdt.csv", "w", encoding="utf-8-sig", newline="") as out:
    out.write("# Messung 7\r\nLogger;LVDT 12-3;;\r\n\"Zeit\";\"Weg 2\";\"Trigger\";\"Bemerkung; frei\"\r\n")
    for i in range(3000):
        ms = 2.0 * i + 3000.0
        t = (ms - 4321.0) / 1000.0 + switch3_s  # of the landing, since touchdown
        weg = "---" if 5000 <= ms < 5100 else comma(2.5 + displacement_mm(t) / 4.0, 6)
        trigger = 5.0 if ms < 4320.0 else 2.5 if ms == 4321.0 else 5.0 - 5.0 * (ms - 4320.0) / 2.0 if ms <= 4322.0 else 0.0
        out.write(f"{comma(ms, 1)};{weg};{comma(trigger, 3)};\"a;b\"\r\n")

with open(f"{folder}/gear.csv", "w") as out:
    out.write("t,x,pull\n")
    for i in range(600):
        t = i / 100.0 - 1.0
        x = 3.0 + 36.0 * t - 4.0 * t * t if t < 4.5 else 3.0 + 36.0 * 4.5 - 4.0 * 4.5 ** 2
        out.write(f"{t + 50:.4f},{x * 0.3048:.6f},{400 + 50 * t:.4f}\n")

with open(f"{folder}/frames.log", "w") as out:
    for i in range(2000):
        stamp = 1700000000.0 + i * 0.002
        out.write(f"({stamp:.6f}) can1 18FF1234#{struct.pack('>hHI', i, 7, 0).hex().upper()}\n")
        if i % 2 == 0:
            out.write(f"({stamp + 0.0003:.6f}) can1 321#{struct.pack('<Bf', 1, 90.0 - i * 0.002).hex().upper()}\n")
with open(f"{folder}/frames.dbc", "w") as out:
    out.write('VERSION "x"\n\nBU_: LOG\n\nBO_ 2566853172 Path: 8 LOG\n SG_ Way : 7|16@0- (0.001,0) [0|0] "in" Vector__XXX\n\n'
              'BO_ 801 Pull: 5 LOG\n SG_ Force : 8|32@1- (1,0) [0|0] "lb" Vector__XXX\n\nSIG_VALTYPE_ 801 Force : 1;\n')
