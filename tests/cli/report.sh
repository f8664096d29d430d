#!/usr/bin/env bash
# The report's page: what it says and draws against the exported readings, the database and the run file; its options and errors.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
run=tests/runs/landing5.run
db=$tmp/c.db

# Landing 5 from the emulated board, twice copied.
campaign() {
    played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig $run &&
        $matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >/dev/null || return 1
    python3 tests/report/grow.py "$db" 3
}
values() {
    $matrig --quiet report "$db" -o "$tmp/page.html" && $matrig --quiet export "$db" 1 --format csv -o "$tmp/run.csv" &&
        python3 tests/report/check_page.py "$tmp/page.html" "$db" "$tmp/run.csv" $run >"$tmp/values.txt"
    local status=$?
    grep -v '^right' "$tmp/values.txt"
    [ $status = 0 ] && [ "$(grep -c '^right' "$tmp/values.txt")" -gt 100 ]
}
# The contents list leads to every section, and to nothing else.
contents() {
    diff <(grep -o 'href="#[a-z0-9]*"' "$tmp/page.html" | sed 's/.*#//; s/"//' | sort -u) \
        <(grep -o '<section id="[a-z0-9]*"' "$tmp/page.html" | sed 's/.*id="//; s/"//' | sort -u) &&
        [ "$(grep -c '<section' "$tmp/page.html")" = 11 ]
}
added_up() { # as matrig show has it; a page of one landing adds nothing up
    $matrig --json show "$db" >"$tmp/show.json" && python3 - "$tmp/show.json" "$tmp/page.html" <<'EOP' && ! grep -q 'id="record"' "$tmp/one.html"
import json, re, sys
w = json.load(open(sys.argv[1]))["record"]["warnings"]
section = open(sys.argv[2]).read().split('<section id="record">')[1].split("</section>")[0]
rows = re.findall(r"<tr><td[^>]*>(?:<a [^>]*>)?(\d+)(?:</a>)?</td>(.*?)</tr>", section)
said = [re.sub("<[^>]*>", "|", cells) for _, cells in rows]
print(w, *said, sep="\n")
assert "Warnings and their outcome" in section and len(rows) == 3
assert sum("|missed|" in s for s in said) == w["misses"] and sum("|correctly quiet|" in s for s in said) == w["silences"]
assert sum("|not known|" in s for s in said) >= w["unknown"] and sum(w.values()) == 3
EOP
}
one_landing() {
    $matrig --quiet report "$db" --run 2 -o "$tmp/one.html" && [ "$(grep -c 'class="landing"' "$tmp/one.html")" = 1 ] &&
        grep -q 'id="run2"' "$tmp/one.html" && ! grep -q 'id="cumulative"' "$tmp/one.html" && grep -q 'Landing report' "$tmp/one.html"
}
# What a reader looks for first: from the tables, as people said it; what nobody said says how it is said.
cover() {
    cp "$db" "$tmp/said.db" && $matrig --quiet report "$db" -o "$tmp/unsaid.html" &&
        sqlite3 "$tmp/said.db" "insert into series(made_us, who, name, runway, pattern, modification) select min(armed_us) - 1, 'J. Kay', 'standard', 'relaid <1973>', 'herringbone', 'cleats' from landings;
            update landings set armed_us = armed_us + 172800000000 where id = 3; update landings set armed_us = armed_us + 1772600000000000; update series set made_us = made_us + 1772600000000000" &&
        $matrig landing "$tmp/said.db" 1 --correct weight_lb=935 --reason weighed >/dev/null && $matrig landing "$tmp/said.db" 2 --correct weight_lb=1010 --reason weighed >/dev/null &&
        $matrig landing "$tmp/said.db" 2 --observe wave --station 88 --panels 2 >/dev/null && fails_with 2 'out of range: 50 s for --at; the record of RUN 2 ends [0-9.]+ s after touchdown' $matrig landing "$tmp/said.db" 2 --observe wave --station 88 --at 50 && TZ=Asia/Kathmandu $matrig --quiet report "$tmp/said.db" -o "$tmp/said.html" &&
        $matrig --quiet --si report "$tmp/said.db" --run 2 -o "$tmp/two.html" && $matrig --json show "$tmp/said.db" 2 >"$tmp/two.json" &&
        python3 - "$tmp" "$tmp/said.db" <<'EOP'
import html, json, re, sqlite3, sys
tmp, db = sys.argv[1], sqlite3.connect(sys.argv[2])
def cover(name):
    text = open("%s/%s.html" % (tmp, name)).read()
    head = re.search(r'<main><header class="cover">.*?</header>', text, re.S).group(0) # nothing stands before it
    return {re.sub("<.*?>", "", t): html.unescape(re.sub("<.*?>", " ", d)) for t, d in re.findall(r"<dt>(.*?)</dt><dd>(.*?)</dd>", head, re.S)}
unsaid, said, two = cover("unsaid"), cover("said"), cover("two")
assert ["panels with" in open("%s/%s.html" % (tmp, name)).read() for name in ("unsaid", "said")] == [False, True], "keys of the zone map"
print(unsaid, said, two, sep="\n")
first, last = db.execute("select date(min(armed_us) / 1e6, 'unixepoch'), date(max(armed_us) / 1e6, 'unixepoch') from landings").fetchone()
assert said["date (UTC)"].startswith(first + " to " + last + "  armed, local time: ") and two["date (UTC)"].startswith(first + "  armed") and first == "2026-03-04" != last and unsaid["date (UTC)"].startswith("not known")
for term, how, is_ in (("runway", "--runway", "relaid <1973>"), ("series", "matrig landing DB --series NAME", "standard"), ("pattern", "--pattern", "herringbone"),
                       ("modification", "--modification", "cleats"), ("operator", "--who", "J. Kay")):
    assert unsaid[term].startswith("not entered") and how in unsaid[term] and said[term] == two[term] == is_, term
assert unsaid["gear weight"].startswith("not entered") and "weight_lb" in unsaid["gear weight"]
assert said["gear weight"].startswith("935.0 to 1010.0 lb") and "unknown for 1" in said["gear weight"] and two["gear weight"].strip() == "4492.7 N" # 1010 lbf
assert unsaid["sensor serial numbers"].startswith("not entered") and "(UTC+0545)" in said["date (UTC)"]
assert unsaid["place"].startswith("not entered") # the configuration was not read: played over files
assert said["landings"] == "3: RUN 1 to 3" and two["landings"] == "1: RUN 2"
show = json.load(open(tmp + "/two.json"))
for term, key in (("touchdown speed", "touchdown_speed"), ("mean deceleration", "mean_deceleration"), ("stop", "stop_station")):
    unit = "_ft" if term == "stop" else "_ft_s" if "speed" in key else "_ft_s2"
    value, error = (float(v) for v in re.match(r"([0-9.]+) ± ([0-9.]+) m", html.unescape(two[term])).groups())
    assert abs(value - 0.3048 * show[key + unit]) < 0.06 and abs(error - 0.3048 * show[key + "_error" + unit]) < 0.06, (term, value, error)
peaks = [(abs(c["peak_in"]), c["station_ft"]) for c in show["displacements"]]
assert re.match(r"%.3f ± 0\.\d+\sin at\s%.0f ft" % max(peaks), said["largest movement"]), (said["largest movement"], max(peaks))
assert "in 3 of 3 landings" in said["zone warned of"] and "%d mats" % db.execute("select max(mats) from zones where landing = 1 and warning = 1").fetchone() in said["zone warned of"]
assert re.search(r"a wave was seen: +RUN +2 *($|[a-z])", said["what went wrong"]) and "wave" in two["what went wrong"] and "wave" not in unsaid["what went wrong"]
EOP
}
si_units() { # 25.4 mm to the inch, in the table and beside every axis
    $matrig --quiet --si report "$db" -o "$tmp/si.html" || return 1
    python3 - "$tmp/page.html" "$tmp/si.html" <<'EOP'
import re, sys
def row(text):
    found = re.search(r"<tr><td>RUN 2</td>(.*?)</tr>", text).group(1)
    return [float(v) for v in re.findall(r'"n">(-?[0-9.]+)', found)]
inch, mm = (open(f).read() for f in sys.argv[1:])
assert len(row(inch)) == 8 and all(abs(25.4 * a - b) < 0.007 for a, b in zip(row(inch), row(mm))), (row(inch), row(mm))
labels = re.findall(r'"[xy]":"([^"]* \([^"]*)"', mm)
assert len(labels) > 60 and not [l for l in labels if re.search(r"\((ft|in|lb|ft/s2?)\)$", l)], set(labels)
EOP
}
voided() {
    cp "$db" "$tmp/v.db" && $matrig --quiet landing "$tmp/v.db" 2 --void --reason 'a dog' --who jk >/dev/null || return 1
    $matrig --quiet report "$tmp/v.db" -o "$tmp/v.html" && grep -q '1 void landing left out' "$tmp/v.html" && ! grep -q 'id="run2"' "$tmp/v.html" &&
        fails_with 2 'RUN 2 is void' $matrig report "$tmp/v.db" --run 2 -o "$tmp/v.html"
}
silly() {
    fails_with 2 'not a RUN: .x. for --run' $matrig report "$db" --run x && fails_with 2 'not a RUN: .1.5. for --run' $matrig report "$db" --run 1.5 &&
        fails_with 2 '\-\-run' $matrig report "$db" --run 0 && fails_with 2 'RUN 9' $matrig report "$db" --run 9
}
# Nothing in a page depends on when it was made, but for what says so.
made_again() {
    local at
    for at in 1 2; do SOURCE_DATE_EPOCH=1000000000 $matrig --quiet report "$db" -o "$tmp/again$at.html" || return 1; done
    cmp "$tmp/again1.html" "$tmp/again2.html" && grep -q '2001-09-09' "$tmp/again1.html" && grep -q "$(sha256sum <"$db" | cut -c 1-64)" "$tmp/again1.html" &&
        grep -q 'coverage factor k = 1); 95 % intervals have k = 1\.96\. Units: feet' "$tmp/again1.html"
}

check "a campaign of three landings" campaign
check "what is said and drawn is what was measured" values
check "contents and sections" contents
check "one landing" one_landing
check "the cover" cover
check "warnings and what came of them" added_up
check "SI units" si_units
check "a voided landing is left out, and that is said" voided
check "the same page again" made_again
check "silly input" silly
finish
