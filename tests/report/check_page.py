#!/usr/bin/env python3
"""check_page.py PAGE DB CSV RUN-FILE: what the report's page says and draws of RUN 1 (and of copies of it, RUN 2 and 3) against the exported readings, the
database and the run file's truth, computed here. Prints what is wrong; exit 1 then."""
import json
import math
import re
import sqlite3
import sys

page, csv = open(sys.argv[1]).read(), open(sys.argv[3]).read()
db = sqlite3.connect(sys.argv[2])
truth = {line.split()[1]: float(line.split()[2]) for line in open(sys.argv[4]) if line.startswith("truth ")}
LANDINGS = 3
STEPS = 2500.0  # of a range in the page's data
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


def plots(text, label):
    """The plots of a figure: what charts.js draws, decoded. Series: name, look, kind, x, y, half (or None); shapes: kind, x0, x1, y0, y1, text."""
    for found in re.finditer(r'<figure class="chart"[^>]*aria-label="([^"]*)"><script type="application/json">(.*?)</script>', text, re.S):
        if found.group(1).startswith(label):
            return [Plot(p) for p in json.loads(found.group(2))["p"]]
    raise SystemExit("no figure: " + label)


def decoded(values):
    if values is None:
        return None
    out, total = [], 0
    for v in values[1:]:
        total += v or 0
        out.append(None if v is None else total / 10 ** values[0])
    return out


class Plot:
    def __init__(self, given):
        self.title, self.x_label, self.y_label = given["t"], given["x"], given["y"]
        self.series = [{"name": i.get("n"), "look": i["l"], "kind": i["k"], "x": decoded(i["x"]), "y": decoded(i["y"]), "half": decoded(i.get("e"))}
                       for i in given["i"] if isinstance(i, dict)]
        self.shapes = [i for i in given["i"] if isinstance(i, list)]
        y = [v for s in self.series for v in s["y"] if v is not None]
        self.step = (max(y) - min(y)) / STEPS if y else 0.0  # of the widest of its series

    def named(self, name):
        return next(s for s in self.series if s["name"] == name)


def table(text, first_head):
    for found in re.finditer(r"<table>.*?</table>", text, re.S):
        heads = re.findall(r"<th(?: [^>]*)?>(.*?)</th>", found.group(0))
        if heads[0] == first_head or first_head in heads:
            return heads, [re.findall(r"<td[^>]*>(.*?)</td>", row, re.S) for row in re.findall(r"<tr>(.*?)</tr>", found.group(0), re.S)[1:]]
    raise SystemExit("no table: " + first_head)


def number(cell):
    return float(re.match(r"-?[0-9.]+", cell).group(0))


def cumulative():
    end_in = [sum(d[-201:]) / 201 for d in moved_in]
    heads, cells = table(section("cumulative"), "after")
    plot, = plots(section("cumulative"), "cumulative displacement against station, after each")
    for k in range(LANDINGS):
        line = plot.named("RUN %d" % (k + 1))
        for i in range(8):
            should = (k + 1) * end_in[i]
            near("cumulative displacement of transducer %d after RUN %d" % (i + 1, k + 1), number(cells[k][i + 1]), should, 2e-4 * (k + 1))
            near("  as drawn", line["y"][i], number(cells[k][i + 1]), plot.step)
            near("  where", line["x"][i], station_ft[i + 1], 0.05)
    check("every column is a station", heads[1:] == ["at %.0f ft (in)" % station_ft[i + 1] for i in range(8)], heads)


def peaks():
    for heads, cells in (table(section("run1"), name) for name in ("transducer", "gage")):
        rows_ = [dict(zip((h.split(" (")[0] for h in heads), row)) for row in cells]
        past = [r for r in rows_ if not number(r.get("least", "-99999")) <= number(r["at the end"]) <= number(r.get("most", "99999")) or
                "peak" in r and abs(number(r["at the end"])) > abs(number(r["peak"]))]
        check("no value at the end lies beyond the extremes", not past, past)
    plot, = plots(section("cumulative"), "peak movement")
    for i in range(8):
        near("peak of transducer %d" % (i + 1), plot.named("RUN 1")["y"][i], max(moving_mean(moved_in[i]), key=abs), 0.006)


def against_the_wheel():
    plot, = plots(section("run1"), "displacement against distance")
    line = plot.named("%.0f ft" % station_ft[5])
    given = [(station_ft[5] - gear_ft[k], moved_in[4][k]) for k in range(len(rows)) if gear_ft[k] is not None]
    given = [p for p in given if -30 <= p[0] <= 50]
    by_tenth = {}
    for q in given:
        by_tenth.setdefault(round(10 * q[0]), []).append(q)
    stray = 0
    for x, y in zip(line["x"], line["y"]):
        close = [q for k in (-1, 0, 1) for q in by_tenth.get(round(10 * x) + k, []) if abs(q[0] - x) < 0.05 and abs(q[1] - y) <= plot.step + 1e-5]
        stray += not close
    drawn = len(line["x"])
    check("every point of the line of transducer 5 is a reading (%d of %d)" % (drawn - stray, drawn), stray == 0 and drawn > 100)
    near("its highest point is the highest reading", max(line["y"]), max(q[1] for q in given), plot.step + 1e-5)
    near("and its lowest the lowest", min(line["y"]), min(q[1] for q in given), plot.step + 1e-5)


def traces():
    """Of every plot of a transducer or gage the extremes are those that were read."""
    for n, plot in enumerate(plots(section("run1"), "displacement of eight")):
        line, seen = plot.named("measured"), [v for k, v in enumerate(moved_in[n]) if v is not None and gear_ft[k] is not None]
        near("greatest displacement %d" % (n + 1), max(line["y"]), max(seen), 2 * plot.step + 1e-5)
    stations = dict(db.execute("select number, station_ft from channels where landing = 1 and kind = 2"))
    for plot in plots(section("run1"), "band tensions"):
        for line in plot.series:
            n = next(n for n in stations if plot.title == "Station %.0f ft" % stations[n] and line["name"] == "band %d" % band[n])
            shown = [v for v, t in zip(tension_lb[n - 1], time_s) if v is not None and -0.3 <= t <= time_s[0] + line["x"][-1] - time_s[0]]
            near("least tension %d" % n, min(line["y"]), min(shown), 2 * plot.step + 1e-3)


def tension():
    before = [k for k, t in enumerate(time_s) if first_edge_s - 0.5 <= t < first_edge_s]
    after = next(k for k, t in enumerate(time_s) if t >= first_edge_s)
    heads, cells = table(section("tension"), "RUN")
    plot, = plots(section("tension"), "average change")
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
            drawn = [q for line in plot.series if line["name"] == "band %d" % b for q in zip(line["x"], line["y"])]
            check("  a mark is there", any(abs(q[0] - x) < 0.002 and abs(q[1] - number(told)) < 0.02 for q in drawn), x, told, drawn)
    near("mean deceleration against the truth, ft/s2", x, truth["mean_deceleration_ft_s2"], 3 * float(cells[0][1].split("±")[1]))


def along():
    plot = next(p for p in plots(section("run1"), "change of tension along") if p.title == "Band 1")
    after = next(k for k, t in enumerate(time_s) if t >= first_edge_s)
    before = [k for k, t in enumerate(time_s) if first_edge_s - 0.5 <= t < first_edge_s]
    line = plot.named("least")
    for n, station in db.execute("select number, station_ft from channels where landing = 1 and kind = 2 and band = 1").fetchall():
        values = tension_lb[n - 1]
        fell = min(moving_mean(values[after:])) - sum(values[k] for k in before) / len(before)
        at = min(range(len(line["x"])), key=lambda i: abs(line["x"][i] - station))
        near("fall of gage %d as drawn" % n, line["y"][at], fell, 0.3)
        check("with its interval", 0.0 < line["half"][at] < 5.0, line["half"][at])


def residuals():
    """From the other switches a place is predicted: here by the cubic through the two before and the two after it."""
    gates = db.execute("select e.board_us / 1e6, s.station_ft from edges e join switches s using (landing, position) where e.landing = 1 and e.position > 0 "
                       "and s.station_ft > 3 order by e.board_us").fetchall()
    drawn = plots(section("run1"), "speed and deceleration")[2].series[0]
    check("a residual for each switch beyond touchdown", len(drawn["x"]) == len(gates) > 10, len(drawn["x"]), len(gates))
    for (t, station), x in zip(gates, drawn["x"]):
        near("time of the residual of %.1f ft" % station, x, t - t0_s, 0.01)
    for k in range(2, len(gates) - 2):
        others, t = [gates[k + d] for d in (-2, -1, 1, 2)], gates[k][0]
        cubic = sum(s * math.prod((t - b) / (a - b) for b, _ in others if b != a) for a, s in others)
        near("residual of %.1f ft" % gates[k][1], drawn["y"][k], 12 * (gates[k][1] - cubic), drawn["half"][k])
    check("most are within their intervals", sum(abs(y) <= h for y, h in zip(drawn["y"], drawn["half"])) >= 0.8 * len(gates), drawn)


def predictor():
    block, mats, start, end = db.execute("select block, mats, start_ft, end_ft from zones where landing = 1 and warning = 1 order by block limit 1").fetchone()
    heads, cells = table(section("predictor"), "RUN")
    row = dict(zip(heads, cells[0]))
    warned_s = block / 1000 - t0_s
    near("first warning, s", number(row["first warning (s)"]), warned_s, 0.0011)
    error = dict((b, (s, e)) for b, s, e in db.execute("select block, start_error_ft, end_error_ft from predictions where landing = 1"))

    def ends(block, start, end):
        return tuple("%.1f ± %.1f" % pair for pair in zip((start, end), error[block]))
    check("the first zone", (row["start of first zone (ft)"], row["end of first zone (ft)"]) == ends(block, start, end), row)
    longest = ends(*db.execute("select block, start_ft, end_ft from zones where landing = 1 and warning = 1 order by mats desc, block limit 1").fetchone())
    summed = dict(zip(*(r[0] if n else r for n, r in enumerate(table(section("summary"), "RUN")))))
    told = summed["start of zone (ft)"], summed["end of zone (ft)"]
    check("the summary has the zone warned of", told == longest, told, longest)
    check("so has the front", ", %s to %s ft" % longest in re.search(r"<dt>zone warned of</dt><dd>(.*?)</dd>", page, re.S).group(1).replace("&plusmn;", "±").replace("&nbsp;", " "))
    check("and in words", re.search(r">warned %.3f s after touchdown, decided in block %d<.*?<dt>closed zone, mats</dt><dd>%d</dd>" % (warned_s, block, mats), section("run1"), re.S))


def provenance():
    text = section("provenance")
    crc, firmware = db.execute("select image_crc, firmware from landings where id = 1").fetchone()
    check("firmware", "%s, %08x," % (firmware, crc) in text)
    check("calibrations", len(table(text, "channel")[1]) == 22 and "not read" in page)


for part in (cumulative, peaks, against_the_wheel, traces, tension, along, residuals, predictor, provenance):
    part()
sys.exit(1 if wrong else 0)
