#!/usr/bin/env python3
"""check_page.py PAGE DB CSV RUN-FILE: what the report's page says and draws of RUN 1 (and of copies of it, RUN 2 and 3) against the exported readings, the
database and the run file's truth, computed here. Prints what is wrong; exit 1 then."""
import hashlib
import re
import sqlite3
import sys
import xml.etree.ElementTree as ET

page, csv = open(sys.argv[1]).read(), open(sys.argv[3]).read()
db = sqlite3.connect(sys.argv[2])
truth = {line.split()[1]: float(line.split()[2]) for line in open(sys.argv[4]) if line.startswith("truth ")}
LANDINGS = 3
COLUMN_PX, THINNED_PX, DIGIT_PX = 5.0, 0.3, 0.051
wrong = 0


def check(what, ok, *told):
    global wrong
    if not ok:
        wrong += 1
    print("%s: %s %s" % ("right" if ok else "WRONG", what, " ".join(str(t) for t in told)))


def near(what, is_, should, within):
    check(what, abs(is_ - should) <= within, is_, "should be", should, "within", within)


# ---- the export ----
t0_s = float(re.search(r"board time of t_s = 0: ([0-9.]+) s", csv).group(1))
lines = [line for line in csv.splitlines() if not line.startswith("#")]
names = lines[0].split(",")
rows = [line.split(",") for line in lines[1:]]
time_s = [float(row[0]) for row in rows]


def column(name):
    at = names.index(name)
    return [float(row[at]) if row[at] else None for row in rows]


gear_ft = column("gear_ft")
moved_in = [column("d%d_in" % (i + 1)) for i in range(8)]
tension_lb = [column("t%d_lb" % (i + 1)) for i in range(14)]
station_ft = dict(db.execute("select number, station_ft from channels where landing = 1 and kind = 1"))
band = dict(db.execute("select number, band from channels where landing = 1 and kind = 2"))
first_edge_s = db.execute("select min(board_us) / 1e6 from edges where landing = 1").fetchone()[0] - t0_s


def moving_mean(values, half=5):
    sums = [0.0]
    for v in values:
        sums.append(sums[-1] + v)
    return [(sums[i + half + 1] - sums[i - half]) / (2 * half + 1) for i in range(half, len(values) - half)]


# ---- the page ----
def section(name):
    return re.search(r'<section id="%s".*?</section>' % name, page, re.S).group(0)


def picture(text, label):
    for found in re.finditer(r"<svg[^>]*aria-label=\"([^\"]*)\".*?</svg>", text, re.S):
        if found.group(1).startswith(label):
            return ET.fromstring(found.group(0))
    raise SystemExit("no picture: " + label)


def table(text, first_head):
    for found in re.finditer(r"<table>.*?</table>", text, re.S):
        heads = re.findall(r"<th>(.*?)</th>", found.group(0))
        if heads[0] == first_head or first_head in heads:
            return heads, [re.findall(r"<td[^>]*>(.*?)</td>", row, re.S) for row in re.findall(r"<tr>(.*?)</tr>", found.group(0), re.S)[1:]]
    raise SystemExit("no table: " + first_head)


def number(cell):
    return float(re.match(r"-?[0-9.]+", cell).group(0))


class Axes:
    """What pixels stand for, from the numbers that are printed beside the ticks."""

    def __init__(self, svg, panel=0):
        groups = [g for g in svg if g.tag == "g" and g.get("class") == "tick"]
        x = [g for g in groups if g.get("text-anchor") == "middle"]
        y = [g for g in groups if g.get("text-anchor") == "end"]
        self.x = [(float(t.get("x")), float(t.text)) for t in x[min(panel, len(x) - 1)]]
        self.y = [(float(t.get("y")) - 4.0, float(t.text)) for t in y[min(panel, len(y) - 1)]]

    @staticmethod
    def pixel(ticks, value):
        (p, a), (q, b) = ticks[0], ticks[-1]
        return p + (q - p) * (value - a) / (b - a)

    def at(self, x, y):
        return self.pixel(self.x, x), self.pixel(self.y, y)


def points(path):
    """Corners of a path of M and l, and of h0 (dots)."""
    out, at, step = [], (0.0, 0.0), False
    for command, numbers in re.findall(r"([Mlh])([^Mlh]*)", path.get("d")):
        values = [float(v) for v in re.findall(r"-?(?:[0-9]+\.?[0-9]*|\.[0-9]+)", numbers)]
        if command == "h":
            continue
        for i in range(0, len(values), 2):
            at = (values[i], values[i + 1]) if command == "M" and i == 0 else (at[0] + values[i], at[1] + values[i + 1])
            out.append(at)
    return out


def of_class(svg, name):
    return [e for e in svg.iter() if e.get("class") == name]


def line_at(corners, px):
    for (x0, y0), (x1, y1) in zip(corners, corners[1:]):
        if x0 - 0.06 <= px <= x1 + 0.06 and x1 > x0:
            return y0 + (y1 - y0) * (px - x0) / (x1 - x0)
    return corners[-1][1]


def cumulative():
    end_in = [sum(d[-201:]) / 201 for d in moved_in]
    heads, cells = table(section("cumulative"), "after")
    svg = picture(section("cumulative"), "cumulative displacement against station, after each")
    axes = Axes(svg)
    for k in range(LANDINGS):
        corners = points(of_class(svg, "line s%d" % k)[0])
        for i in range(8):
            should = (k + 1) * end_in[i]
            near("cumulative displacement of transducer %d after RUN %d" % (i + 1, k + 1), number(cells[k][i + 1]), should, 2e-4 * (k + 1))
            px, py = axes.at(station_ft[i + 1], should)
            near("  as drawn, px", line_at(corners, px), py, THINNED_PX + 0.15)
    check("every column is a station", heads[1:] == ["%.0f ft" % station_ft[i + 1] for i in range(8)], heads)


def peaks():
    svg = picture(section("cumulative"), "peak movement")
    axes, corners = Axes(svg), points(of_class(svg, "line s0")[0])
    for i in range(8):
        means = moving_mean(moved_in[i])
        px, low = axes.at(station_ft[i + 1], max(means, key=abs) - 0.006)
        high = axes.at(0, max(means, key=abs) + 0.006)[1]
        y = line_at(corners, px)
        check("peak of transducer %d" % (i + 1), high - 0.5 <= y <= low + 0.5, y, "between", high, low)


def against_the_wheel():
    svg = picture(section("run1"), "displacement against distance")
    axes, ys = Axes(svg), []
    corners = points(of_class(svg, "line s4")[0])
    given = [axes.at(station_ft[5] - gear_ft[k], moved_in[4][k]) for k in range(len(rows)) if gear_ft[k] is not None]
    given = [p for p in given if axes.at(-30, 0)[0] <= p[0] <= axes.at(50, 0)[0]]
    by_tenth = {}
    for p in given:
        by_tenth.setdefault(round(p[0]), []).append(p)
    stray = 0
    for x, y in corners:
        close = [p for k in (-1, 0, 1) for p in by_tenth.get(round(x) + k, []) if abs(p[0] - x) < 0.1 and abs(p[1] - y) < 0.1]
        stray += not close
    check("every corner of the line of transducer 5 is a reading (%d of %d)" % (len(corners) - stray, len(corners)), stray == 0 and len(corners) > 40)
    near("its highest point is the highest reading, px", min(y for _, y in corners), min(p[1] for p in given), THINNED_PX + DIGIT_PX)
    near("and its lowest the lowest", max(y for _, y in corners), max(p[1] for p in given), THINNED_PX + DIGIT_PX)


def tension():
    before = [k for k, t in enumerate(time_s) if first_edge_s - 0.5 <= t < first_edge_s]
    after = next(k for k, t in enumerate(time_s) if t >= first_edge_s)
    heads, cells = table(section("tension"), "RUN")
    svg = picture(section("tension"), "average change")
    axes = Axes(svg)
    x = number(cells[0][1])
    for b in (1, 2):
        fell, rose = [], []
        for number_ in [n for n in band if band[n] == b]:
            values = tension_lb[number_ - 1]
            base = sum(values[k] for k in before) / len(before)
            means = moving_mean(values[after:])
            fell.append(min(means) - base)
            rose.append(max(means) - base)
        for told, should in ((cells[0][2 * b], sum(fell) / len(fell)), (cells[0][2 * b + 1], sum(rose) / len(rose))):
            near("average change of band %d, lb" % b, number(told), should, 0.25)
            px, py = axes.at(x, number(told))
            marks = [e for e in svg.iter() if (e.get("class") or "") in ("dot s%d" % (b - 1), "ring s%d" % (b - 1))]
            centres = [(float(e.get("cx")), float(e.get("cy"))) if e.tag == "circle" else centre(e) for e in marks]
            if b == 1: # drawn first: it has to show around that of band 2, 3.75 px from its middle
                check("  and shows around another band's", all(e.get("class") == "ring s0" and float(e.get("r")) > 4.5 for e in marks if float(e.get("cy")) > 20.0))
            check("  a mark is there", any(abs(c[0] - px) < 0.6 and abs(c[1] - py) < 0.2 for c in centres), px, py, centres)
    near("mean deceleration against the truth, ft/s2", x, truth["mean_deceleration_ft_s2"], 3 * float(cells[0][1].split("&plusmn;&thinsp;")[1]))


def centre(path):
    corners = [tuple(float(v) for v in pair.split()) for pair in re.findall(r"[ML]([-0-9. ]+)", path.get("d"))]
    return sum(c[0] for c in corners) / len(corners), sum(c[1] for c in corners) / len(corners)


def along():
    svg = picture(section("run1"), "change of tension along")
    axes = Axes(svg)
    after = next(k for k, t in enumerate(time_s) if t >= first_edge_s)
    before = [k for k, t in enumerate(time_s) if first_edge_s - 0.5 <= t < first_edge_s]
    corners = points(of_class(svg, "line s0")[0])
    for n, station in db.execute("select number, station_ft from channels where landing = 1 and kind = 2 and band = 1").fetchall():
        values = tension_lb[n - 1]
        fell = min(moving_mean(values[after:])) - sum(values[k] for k in before) / len(before)
        px, py = axes.at(station, fell)
        near("fall of gage %d as drawn, px" % n, line_at(corners, px), py, 2.0)


def residuals():
    caption = re.search(r"polynomial of order (\d+) through (\d+) of \d+ switches, residual standard deviation ([0-9.]+) in", section("run1"))
    order, count, told = int(caption.group(1)), int(caption.group(2)), float(caption.group(3))
    gates = db.execute("select e.board_us / 1e6, s.station_ft from edges e join switches s using (landing, position) where e.landing = 1 and e.position > 0 "
                       "order by e.board_us").fetchall()[-count:]
    half, mid = (gates[-1][0] - gates[0][0]) / 2, (gates[-1][0] + gates[0][0]) / 2
    x = [(t - mid) / half for t, _ in gates]
    size = order + 1
    m = [[sum(v ** (i + j) for v in x) for j in range(size)] + [sum(s * v ** i for v, (_, s) in zip(x, gates))] for i in range(size)]
    for i in range(size):  # Gauss and Jordan
        pivot = max(range(i, size), key=lambda r: abs(m[r][i]))
        m[i], m[pivot] = m[pivot], m[i]
        for r in range(size):
            if r != i:
                f = m[r][i] / m[i][i]
                m[r] = [a - f * b for a, b in zip(m[r], m[i])]
    c = [m[i][size] / m[i][i] for i in range(size)]
    residual_in = [12 * (s - sum(c[k] * v ** k for k in range(size))) for v, (_, s) in zip(x, gates)]
    near("residual standard deviation, in", told, (sum(r * r for r in residual_in) / (count - size)) ** 0.5, 0.001)
    svg = picture(section("run1"), "speed and deceleration")
    axes = Axes(svg)
    axes.y = Axes(svg, 2).y
    marks = [centre(e) for e in svg.iter() if e.get("class") == "dot b" and e.tag == "path"]
    for (t, _), r in zip(gates, residual_in):
        px, py = axes.at(t - t0_s, r)
        check("residual at %.3f s is drawn" % (t - t0_s), any(abs(c[0] - px) < 0.4 and abs(c[1] - py) < 0.6 for c in marks), px, py)


def predictor():
    block, mats, start, end = db.execute("select block, mats, start_ft, end_ft from zones where landing = 1 and warning = 1 order by block limit 1").fetchone()
    heads, cells = table(section("predictor"), "RUN")
    row = dict(zip(heads, cells[0]))
    warned_s = block / 1000 - t0_s
    near("first warning, s", number(row["first warning, s"]), warned_s, 0.0011)
    check("zone then", row["zone then, ft"] == "%.1f to %.1f" % (start, end), row)
    if number(row["wheel there after, s"]) > 0:
        k = next(k for k, g in enumerate(gear_ft) if g is not None and g >= start)
        near("the wheel there after, s", number(row["wheel there after, s"]), time_s[k] - warned_s, 0.003)
    check("and in words", re.search(r">warned %.3f s after touchdown, decided in block %d<.*?<dt>closed mats</dt><dd>%d</dd>" % (warned_s, block, mats), section("run1"), re.S))


def film():
    _, cells = table(section("run1"), "frame")
    check("frames every ten feet", len(cells) >= 8, len(cells))
    for cell in cells:
        t = number(cell[1])
        k = min(range(len(rows)), key=lambda i: abs(time_s[i] - t))
        if gear_ft[k] is not None:  # the export knows no position before touchdown
            near("gear on frame %s, ft" % cell[0], number(cell[2]), gear_ft[k], 0.08)


def provenance():
    text = section("provenance")
    drawn = page[page.index("<main>"):page.index("</main>") + 7]
    check("hash of what was drawn", hashlib.sha256(drawn.encode("utf-8", "surrogateescape")).hexdigest() in text)
    records = hashlib.sha256(b"".join(r for (r,) in db.execute("select record from blocks where landing = 1 order by idx"))).hexdigest()
    check("hash of the block records", text.count(records) == LANDINGS, records)
    crc, firmware = db.execute("select image_crc, firmware from landings where id = 1").fetchone()
    check("firmware", "%s, %08x," % (firmware, crc) in text)
    check("calibrations", len(table(text, "channel")[1]) == 22 and "not read" in text)


for part in (cumulative, peaks, against_the_wheel, tension, along, residuals, predictor, film, provenance):
    part()
sys.exit(1 if wrong else 0)
