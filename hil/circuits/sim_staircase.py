"""The staircase: its steps over many boards, how it settles, and the one-shot."""
import math

from deck import Deck, Draw, LSB_V, VDDA, at, kick, rails, source_ohm

BOARDS = 1000
ONE_SHOTS = 60


def steps_codes():
    """As common/config.def's built-in gates have them (firmware/config.c)."""
    return [64 + 8 * (7 * p % 24) for p in range(24)]


def summing(parts):
    """The resistors and the capacitor at the staircase, without the switches' inputs."""
    return [p for p in parts.values() if p.refdes.split("/")[0] in {f"R{n}" for n in range(301, 365)} | {"C301"}]


def drives(deck, copy, parts, draw):
    """Each inverter as its output's resistance to a source that all boards share: open is 3.3 V, closed 0 V."""
    for p in range(1, 25):
        step = parts[f"S{p}/U1"].net("Y")
        deck.add(f"Rdrive{copy}_{p} drive{p} {deck.node(copy, step)} {draw.between(8, 16):.9g}")


def chunk_steps(parts, work, boards):
    deck = Deck(work, "staircase-steps")
    deck.add(*[f"Vdrive{p} drive{p} 0 0" for p in range(1, 25)], f"Vdda vdda 0 {VDDA}")
    for board in boards:
        draw = Draw(f"staircase {board}")
        deck.place(board, summing(parts), draw)
        drives(deck, board, parts, draw)
        deck.add(f"Rsupply{board} vdda {deck.node(board, 'VDDA')} 1m")
    control = ["op", "WRITE"]
    for p in range(1, 25):
        control += [f"alter Vdrive{p} = {VDDA}", "op", "WRITE", f"alter Vdrive{p} = 0"]
    nodes = [f"v({deck.node(b, 'STAIRCASE')})" for b in boards]
    plots = deck.run(control, nodes, 120)
    zero = [plots[0][n][0] / LSB_V for n in nodes]
    return zero, [[plots[p][n][0] / LSB_V - z for p in range(1, 25)] for n, z in zip(nodes, zero)]


def board_steps(parts, work, boards=BOARDS, chunk=50):
    """Zero and steps of each board, codes; 25 operating points each. In parts: ngspice's time grows with the square."""
    zero, steps = [], []
    for first in range(0, boards, chunk):
        more = chunk_steps(parts, work, range(first, min(first + chunk, boards)))
        zero += more[0]
        steps += more[1]
    return zero, steps


def line_of(parts, p):
    return parts[f"S{p}/J1"].net("2")


def opening(parts, work):
    """The whole circuit of one board: switches 1 to 4 open 300 us apart. Staircase, edge and their times."""
    deck = Deck(work, "staircase-opening")
    mine = [p for r, p in parts.items() if r.split("/")[0] in {f"S{n}" for n in range(1, 25)} or
            r in {f"R{n}" for n in range(301, 368)} | {"C301", "C302", "U301"}]
    deck.place(0, mine, Draw(0, 0))
    rails(deck, 0, {"VDDA": VDDA, "3V3": 3.3, "VSW": 3.3})
    vsw = deck.node(0, "VSW")
    for p in range(1, 25):
        opens = 200e-6 + (p - 1) * 300e-6 if p <= 4 else 1
        deck.add(f"Sswitch{p} {vsw} {deck.node(0, line_of(parts, p))} closed{p} 0 contact",
                 f"Vclosed{p} closed{p} 0 pwl(0 1 {opens} 1 {opens + 1e-7} 0)", f"Ccable{p} {deck.node(0, line_of(parts, p))} 0 3.5n")
    deck.add(".model contact sw vt=0.5 vh=0.1 ron=0.1 roff=1g")
    stair, edge = f"v({deck.node(0, 'STAIRCASE')})", f"v({deck.node(0, 'EDGE')})"
    deck.add(f"Redge {deck.node(0, 'EDGE')} 0 1meg")
    plot = deck.run(["tran 0.3u 1.4m 0 0.3u", "WRITE"], [stair, edge], 90)[0]
    return plot["time"], plot[stair], plot[edge]


def crossings(times, values, level, rising=True):
    found = []
    for i in range(1, len(values)):
        a, b = values[i - 1], values[i]
        if (a < level <= b) if rising else (a >= level > b):
            found.append(times[i - 1] + (level - a) / (b - a) * (times[i] - times[i - 1]))
    return found


def one_shots(parts, work, copies=ONE_SHOTS):
    """Widths of the pulse and delays after the contact opens, of switch 1, over tolerances; microseconds."""
    deck = Deck(work, "staircase-one-shot")
    mine = [p for r, p in parts.items() if r.startswith("S1/") or r.endswith(("/D2", "/R3")) and r.startswith("S") or
            r in {"R365", "R366", "R367", "C302", "U301"}]
    for copy in range(copies):
        deck.place(copy, mine, Draw(f"one-shot {copy}"))
        rails(deck, copy, {"VDDA": VDDA, "3V3": 3.3, "VSW": 3.3})
        line = deck.node(copy, line_of(parts, 1))
        deck.add(f"Sswitch{copy} {deck.node(copy, 'VSW')} {line} closed 0 contact", f"Ccable{copy} {line} 0 3.5n",
                 f"Redge{copy} {deck.node(copy, 'EDGE')} 0 1meg")
    deck.add(".model contact sw vt=0.5 vh=0.1 ron=0.1 roff=1g", "Vclosed closed 0 pwl(0 1 50u 1 50.1u 0)")
    names = [f"v({deck.node(c, 'EDGE')})" for c in range(copies)]
    plot = deck.run(["tran 0.2u 120u 0 0.2u", "WRITE"], names, 90)[0]
    widths, delays = [], []
    for name in names:
        up = crossings(plot["time"], plot[name], 1.65)
        down = crossings(plot["time"], plot[name], 1.65, False)
        if len(up) != 1 or len(down) != 1:
            return [], []
        widths.append((down[0] - up[0]) * 1e6)
        delays.append((up[0] - 50e-6) * 1e6)
    return widths, delays


def surround(parts):
    def add(deck, copy):
        rails(deck, copy, {"VDDA": VDDA})
        drives_at = Draw(0, 0)
        drives(deck, copy, parts, drives_at)
        if copy == 0:
            deck.add(*[f"Vdrive{p} drive{p} 0 {VDDA if p % 2 else 0}" for p in range(1, 25)])
    return add


def reference_rule(parts, work):
    """Rule 3: the voltage follows VDDA alone. Relative deviation with VDDA 2 % low."""
    deck = Deck(work, "staircase-rule")
    for copy, volt in ((0, VDDA), (1, VDDA * 0.98)):
        deck.place(copy, summing(parts), Draw(0, 0))
        rails(deck, copy, {"VDDA": volt})
        for p in range(1, 25):
            drive = f"own{copy}_{p}"
            deck.add(f"V{drive} {drive} 0 {volt if p % 2 else 0}", f"R{drive} {drive} {deck.node(copy, parts[f'S{p}/U1'].net('Y'))} 12")
    names = [f"v({deck.node(copy, 'STAIRCASE')})" for copy in (0, 1)]
    plot = deck.run(["op", "WRITE"], names)[0]
    return plot[names[1]][0] / plot[names[0]][0] / 0.98 - 1


def figures(parts, work):
    zero, steps = board_steps(parts, work)
    wanted = steps_codes()
    errors = [board[p] - wanted[p] for board in steps for p in range(24)]
    times, stair, edge = opening(parts, work)
    rises = crossings(times, edge, 1.65)
    settle_us = math.nan
    found = [round((at(times, stair, 200e-6 + n * 300e-6 + 280e-6) - at(times, stair, 200e-6 + n * 300e-6)) / LSB_V) for n in range(4)]
    if len(rises) == 4:
        # the inverter switches within 0.1 us of the edge; the step is 63 % there a time constant later
        before, after = at(times, stair, 190e-6), at(times, stair, 480e-6)
        whole = crossings(times, stair, before + (after - before) * (1 - math.exp(-1)))
        start = crossings(times, stair, before + (after - before) * 0.01)
        settle_us = (whole[0] - start[0]) / (1 + math.log(0.99)) * 1e6
    widths, delays = one_shots(parts, work)
    part = summing(parts)
    around = surround(parts)
    largest = max(zero) + 3744 + max(sum(b) - 3744 for b in steps)
    tolerance = max(parts[f"R{n}"].tolerance() for n in [*range(301, 325), *range(331, 355)])
    return [
        ("staircase_resistor_tol_rel", tolerance, "1", "tolerance of a step's two resistors, from the parts list"),
        ("staircase_step_error_max_codes", max(abs(e) for e in errors), "codes", f"largest deviation of a step from its code, {BOARDS} boards"),
        ("staircase_top_codes", largest, "codes", "highest code with all switches open; the converter ends at 4095"),
        ("staircase_vdda_rel", reference_rule(parts, work), "1", "rule 3: residual error of the raw code with VDDA 2 % low"),
        ("are_staircase_steps_right", float(found == wanted[:4] and len(rises) == 4), "1",
         f"1: switches 1 to 4, opened one after the other, gave their steps ({' '.join(map(str, found))}) and one edge each"),
        ("staircase_settle_us", settle_us, "us", "time constant of a step"),
        ("staircase_source_ohm", source_ohm(work, "staircase", part, "STAIRCASE", around), "Ohm", "source resistance at the converter"),
        ("staircase_kick_rel", kick(work, "staircase", part, "STAIRCASE", around), "1",
         "share of the previous channel's voltage that remains in a reading"),
        ("edge_delay_us", sum(delays) / len(delays) if delays else math.nan, "us", "mean time from the opening of the contact to the edge"),
        ("edge_delay_spread_us", (max(delays) - min(delays)) / 2 if delays else math.nan, "us", "half the range of the edge delay over all tolerances"),
        ("one_shot_min_us", min(widths, default=math.nan), "us", f"minimum width of the edge pulse, {ONE_SHOTS} simulated circuits"),
        ("one_shot_max_us", max(widths, default=math.nan), "us", "maximum width of the edge pulse, 60 simulated circuits"),
    ]
