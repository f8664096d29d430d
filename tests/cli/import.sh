#!/usr/bin/env bash
# matrig import: logs of matrig's boards, and other instruments' data as other programs write them
# (tests/exchange/other_instrument.py). Damage is named by line and column, and what is good is kept.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
db=$tmp/campaign.db
m() { build/matrig --quiet "$@"; }
cell() { sqlite3 "$db" "$1"; }

played --elf build/firmware/matrig.elf --can "file:$tmp/can" --rig tests/runs/landing5.run >/dev/null 2>&1
m log --can "file:$tmp/can" --db "$db" >/dev/null
m export "$db" 1 --format csv -o "$tmp/run1.csv"
lines=$(wc -l <"$tmp/can")

a_log_is_a_landing() {
    build/matrig --json import "$db" "$tmp/can" >"$tmp/json" && cat "$tmp/json" || return 1
    python3 - "$tmp/json" "$lines" "$tmp/can" <<'PYTHON' || return 1
import hashlib, json, sys
r = json.load(open(sys.argv[1]))
assert r["verdict"] == "complete" and r["rows"] == int(sys.argv[2]) and r["runs"] == [2] and r["format"] == "candump", r
assert r["sha256"] == hashlib.sha256(open(sys.argv[3], "rb").read()).hexdigest()
PYTHON
    m export "$db" 2 --format csv -o "$tmp/run2.csv" && cmp <(sed 1,2d "$tmp/run1.csv") <(sed 1,2d "$tmp/run2.csv") &&
        [ "$(cell 'SELECT count(*) FROM frames WHERE landing=1')" = "$(cell 'SELECT count(*) FROM frames WHERE landing=2')" ] &&
        [ "$(cell "SELECT group_concat(can_id || hex(data), '') FROM (SELECT * FROM frames WHERE landing=1 ORDER BY id)")" = \
          "$(cell "SELECT group_concat(can_id || hex(data), '') FROM (SELECT * FROM frames WHERE landing=2 ORDER BY id)")" ]
}
twice_is_refused() {
    fails_with 2 'session 2 of .* already contains this file: .*--again' build/matrig import "$db" "$tmp/can"
}
three_at_once_make_one() { # whoever comes second sees the first one's
    local pids=() pid good=0
    for _ in 1 2 3; do m import "$tmp/once.db" "$tmp/can" >/dev/null 2>>"$tmp/once.err" & pids+=($!); done
    for pid in "${pids[@]}"; do wait "$pid" && good=$((good + 1)); done
    cat "$tmp/once.err"
    [ $good = 1 ] && [ "$(grep -c 'session 1 of .* already contains this file' "$tmp/once.err")" = 2 ] && [ "$(sqlite3 "$tmp/once.db" 'SELECT count(*) FROM landings')" = 1 ]
}
it_stands_in_report_and_summary() {
    m report "$db" -o "$tmp/report.html" && grep -q "imported from</dt><dd>$tmp/can (candump of can0, [0-9]* bytes, SHA-256 $(sha256sum <"$tmp/can" | cut -c1-64))" "$tmp/report.html"
}
a_cut_log_keeps_what_is_whole() {
    head -c 500010 "$tmp/can" >"$tmp/cut.log"
    local whole=$(wc -l <"$tmp/cut.log")
    fails_with 4 "truncated at line $((whole + 1)), column [0-9]*: the log ends within a line" build/matrig --quiet import "$tmp/cut.db" "$tmp/cut.log" &&
        [ "$(sqlite3 "$tmp/cut.db" 'SELECT count(*) FROM frames')" = "$whole" ] &&
        sqlite3 "$tmp/cut.db" 'SELECT verdict FROM imports' | grep -q "^truncated at line $((whole + 1))"
}
a_damaged_line_costs_itself() {
    sed -e '7000s/#../#G0/' -e '9000s/.*/noise/' "$tmp/can" >"$tmp/bad.log"
    local column=$(sed -n 7000p "$tmp/can" | awk '{print index($0, "#") + 1}')
    fails_with 4 "malformed at line 7000, column $column: .*; 2 lines were skipped" build/matrig --quiet import "$tmp/bad.db" "$tmp/bad.log" &&
        [ "$(sqlite3 "$tmp/bad.db" 'SELECT count(*) FROM frames')" = $((lines - 2)) ] &&
        [ "$(sqlite3 "$tmp/bad.db" 'SELECT lost FROM links')" = 2 ] # the board's own counts miss them
}
# The bus on which the board speaks, wherever the first frame is from.
another_bus_is_left_out() {
    awk 'NR == 1 {print "(0.5) can1 123#11"; print "(0.6) can1 1F0#0000"} NR % 2 {print} !(NR % 2) {print; if ($3 !~ /^1F0/) {$2 = "can1"; print}}' "$tmp/can" >"$tmp/two.log"
    local road others=$(grep -c ' can1 ' "$tmp/two.log")
    m --json import "$tmp/two.db" "$tmp/two.log" >"$tmp/json" && grep -q "\"rows\":$lines," "$tmp/json" && grep -q "\"other_interfaces\":$others," "$tmp/json" || return 1
    for road in "file:$tmp/two.log" file:/dev/stdin; do
        rm -f "$tmp/two.db"
        m log --can "$road" --db "$tmp/two.db" <"$tmp/two.log" >"$tmp/out" && grep -q "frames of other buses that were not logged: $others" "$tmp/out" || { cat "$tmp/out"; return 1; }
        [ "$(sqlite3 "$tmp/two.db" 'SELECT count(*) FROM frames')" = "$lines" ] || return 1
    done
}
# Boards on two buses are a question, before there is a campaign; either is taken when it is named.
two_boards_are_a_question() {
    played --elf build/firmware/matrig.elf --can "file:$tmp/other" --rig tests/runs/landing4.run >/dev/null 2>&1
    sort -s -k 1,1 <(sed 's/ can0 / can2 /' "$tmp/other") "$tmp/can" >"$tmp/both.log"
    local asked='several buses in the log have a board .can[02] and can[02].: .*select one bus with .*interface'
    fails_with 2 "$asked" build/matrig import "$tmp/both.db" "$tmp/both.log" && fails_with 2 "$asked" build/matrig log --can "file:$tmp/both.log" --db "$tmp/both.db" &&
        [ ! -e "$tmp/both.db" ] && fails_with 2 'no frame of interface can7: .*give one of its interfaces .can[02] and can[02]' build/matrig log --can "file:$tmp/both.log,interface=can7" --db "$tmp/both.db" || return 1
    m import "$tmp/both.db" "$tmp/both.log" --interface can2 >/dev/null && m log --can "file:$tmp/both.log,interface=can0" --db "$tmp/both.db" >/dev/null &&
        [ "$(sqlite3 "$tmp/both.db" 'SELECT group_concat(n) FROM (SELECT count(*) AS n FROM frames GROUP BY session)')" = "$(wc -l <"$tmp/other"),$lines" ] || return 1
    # the other bus is not the same file twice; each is
    fails_with 2 'already contains this file' build/matrig import "$tmp/both.db" "$tmp/both.log" --interface can2 && m import "$tmp/both.db" "$tmp/both.log" --interface can0 >"$tmp/out" && grep -q '^bus  *can0$' "$tmp/out" &&
        fails_with 2 'already contains this file' build/matrig import "$tmp/both.db" "$tmp/both.log" --interface can0 && [ "$(sqlite3 "$tmp/both.db" 'SELECT group_concat(bus) FROM imports')" = can2,can0 ] &&
        m landing "$tmp/both.db" 3 >/dev/null && m report "$tmp/both.db" -o "$tmp/both.html" && grep -q 'both.log (candump of can2, ' "$tmp/both.html" && grep -q 'both.log (candump of can0, ' "$tmp/both.html"
}
# A mark of UTF-8, and what candump -l -L -s0 of before 2019 says without a newline.
before_the_first_frame() {
    local begin
    for begin in '\357\273\277' 'Warning: console output active while logging!'; do
        printf "$begin" | cat - "$tmp/can" >"$tmp/begun.log"
        rm -f "$tmp/begun.db"
        m import "$tmp/begun.db" "$tmp/begun.log" >/dev/null && m log --can "file:$tmp/begun.log" --db "$tmp/begun.db" >/dev/null &&
            [ "$(sqlite3 "$tmp/begun.db" 'SELECT group_concat(n) FROM (SELECT count(*) AS n FROM frames GROUP BY session)')" = "$lines,$lines" ] || return 1
    done
}
# One log with all that other programs and a bus put into it: padded names, CRLF, another bus, others' frames, bus-off, bus errors, damage.
every_road_gives_the_same_rows() {
    awk 'NR % 3 == 0 {sub(" can0", "   can0")} NR % 7 == 0 {$0 = $0 " R"} NR % 5 == 0 {$0 = $0 "\r"} {print} {t = $1}
        NR % 50 == 0 {print t, "20000080#0000000000000000"} NR == 9000 {print t, "can0 20000040#"; print t, "slcan0 100#00"; print "noise"}
        NR == 9100 {print t, "can0 20000100#"; print t, "can0 18FF50E5#0102"; print t, "can0 124#R4"; print t, "can0 123##0011"}' "$tmp/can" |
        sed 's/) 20000080/)   can0 20000080/' >"$tmp/all.log"
    local road
    fails_with 4 'malformed at line [0-9]*, column 1: .*; 2 lines were skipped' build/matrig --quiet import "$tmp/road0.db" "$tmp/all.log" || return 1
    mkfifo "$tmp/pipe2" && ln -s all.log "$tmp/pipe1" || return 1
    cat "$tmp/all.log" >"$tmp/pipe2" &
    for road in 1 2; do
        fails_with 4 'malformed at line [0-9]*, column 1: .*; 2 lines were skipped' build/matrig --quiet log --db "$tmp/road$road.db" --can "file:$tmp/pipe$road" || return 1
    done
    sqlite3 "$tmp/road0.db" "SELECT code, sum(detail) FROM events WHERE kind='can-link' GROUP BY code" >"$tmp/told"
    [ "$(cat "$tmp/told")" = "$(printf '0|1\n1|1\n8|%d' $((lines / 50)))" ] || { cat "$tmp/told"; return 1; }
    python3 - "$tmp"/road[012].db <<'PYTHON'
import sqlite3, sys
apart = {"sessions": ("started_us", "ended_us", "can_link"), "events": ("id", "host_us"), "imports": None}
def rows(path):
    db = sqlite3.connect(path)
    found = {}
    for (table,) in db.execute("SELECT name FROM sqlite_schema WHERE type='table'").fetchall():
        names = [c[1] for c in db.execute(f"PRAGMA table_info({table})")]
        left = apart.get(table, ())
        if left is not None:
            found[table] = sorted(repr([v for n, v in zip(names, r) if n not in left]) for r in db.execute(f"SELECT * FROM {table}") if "can-link" not in r)
    # What a link tells goes into a row for each transaction, and those end by the clock.
    found["troubles"] = [repr(r) for r in db.execute("SELECT boot, landing, code, sum(detail), max(value) FROM events WHERE kind='can-link' GROUP BY 1, 2, 3")]
    return found
first, *others = map(rows, sys.argv[1:])
assert len(first["frames"]) > 20000 and len(first["events"]) > 3, {t: len(r) for t, r in first.items()}
for path, other in zip(sys.argv[2:], others):
    for table in first:
        apart = set(first[table]) ^ set(other[table])
        assert not apart, (path, table, sorted(apart)[:6])
PYTHON
}
instruments() {
    local t0=$(sed -n 's/.*board time of t_s = 0: \([0-9.]*\) s.*/\1/p' "$tmp/run1.csv")
    local edge=$(cell 'SELECT board_us FROM edges WHERE landing=1 AND position=3')
    switch3=$(awk -v e="$edge" -v t0="$t0" 'BEGIN {printf "%.7f", e / 1e6 - t0}')
    python3 tests/exchange/other_instrument.py "$tmp" "$switch3"
    cat >"$tmp/lvdt.json" <<'J'
{"decimal": ",", "header_lines": 2, "missing": ["---"], "note": "LVDT 12-3",
 "time": {"column": "Zeit", "unit": "ms"},
 "align": {"column": "Trigger", "threshold": 2.5, "edge": "falling", "switch": 3},
 "channels": [{"column": "Weg 2", "channel": "d2", "unit": "mm", "scale": 4, "offset": -10, "error": 0.0254}]}
J
    printf '\357\273\277' | cat - "$tmp/lvdt.json" >"$tmp/marked.json"
    cat >"$tmp/gear.json" <<'J'
{"time": {"column": 1, "unit": "s"}, "touchdown_ft": 3, "switch_error_ft": 0.001,
 "channels": [{"column": "x", "channel": "gear", "unit": "m"}, {"column": 3, "channel": "t1", "unit": "N"}]}
J
    cat >"$tmp/bits.json" <<'J'
{"channels": [{"id": "0x18FF1234", "start_bit": 7, "bits": 16, "signed": true, "byte_order": "big", "scale": 0.0254, "unit": "mm", "channel": "d1"},
              {"id": "0x321", "start_bit": 8, "bits": 32, "float": true, "unit": "lb", "channel": "t3"}]}
J
}
# Against the closed form the data was made of: 500 Hz, straight lines between: (0.002 s)^2 / 8 of the second derivative, 1.3e-5 mm.
a_foreign_table_lies_where_its_trigger_says() {
    build/matrig import "$db" "$tmp/lvdt.csv" --map "$tmp/marked.json" --like 1 >"$tmp/out" || { cat "$tmp/out"; return 1; }
    local run=$(cell 'SELECT max(id) FROM landings')
    m export "$db" "$run" --format csv -o "$tmp/lvdt.out" || return 1
    python3 - "$tmp/lvdt.out" "$switch3" <<'PYTHON' || return 1
import csv, math, sys
rows = list(csv.DictReader(l for l in open(sys.argv[1]) if not l.startswith("#")))
worst, there, missing = 0, 0, 0
for r in rows:
    t = float(r["t_s"])
    if r["d2_in"] == "":
        missing += 1
        continue
    there += 1
    true = 10 * (1 - math.cos(2 * math.pi * t / 4)) / 25.4 if t > 0 else 0
    worst = max(worst, abs(float(r["d2_in"]) - true))
print(len(rows), there, missing, worst)
assert abs(len(rows) - 5999) <= 2 and 100 <= missing <= 103 and worst < 1.2e-5
PYTHON
    m --json landing "$db" "$run" >/dev/null; build/matrig report "$db" -o "$tmp/r.html" 2>/dev/null && grep -q "lvdt.csv (csv," "$tmp/r.html" &&
        cell "SELECT channels || ' ' || cause FROM gaps WHERE landing=$run" | grep -qx 'd2 file' &&
        [ "$(cell "SELECT mapping FROM imports ORDER BY session DESC LIMIT 1" | grep -c 'LVDT 12-3')" = 1 ]
}
a_camera_track_gives_the_gear() {
    m import "$db" "$tmp/gear.csv" --map "$tmp/gear.json" >/dev/null || return 1
    local run=$(cell 'SELECT max(id) FROM landings')
    m export "$db" "$run" --format csv | grep -v '^#' >"$tmp/gear.out"
    python3 - "$tmp/gear.out" <<'PYTHON'
import csv, sys
rows = list(csv.DictReader(open(sys.argv[1])))
first = min((r for r in rows if r["speed_ft_s"]), key=lambda r: float(r["t_s"]))
assert abs(float(first["speed_ft_s"]) - 36) < 0.1 and abs(float(first["gear_ft"]) - 3) < 0.05, first
for r in rows:
    t = float(r["t_s"])
    assert r["t1_lb"] == "" or abs(float(r["t1_lb"]) - (400 + 50 * t) / 4.4482216152605) < 0.02, r
    assert not 0 < t < 4.4 or abs(float(r["gear_ft"]) - (3 + 36 * t - 4 * t * t)) < 0.02, r
PYTHON
}
# By a map written by hand, and by one that the how-to's script makes of the DBC file.
frames_by_their_bits() {
    sed -n "/^cat >dbc_map.py/,/^END/p" docs/howto/own-dbc.md | sed '1d;$d' >"$tmp/dbc_map.py"
    /usr/bin/python3 "$tmp/dbc_map.py" "$tmp/frames.dbc" d1=Path.Way t3=Pull.Force >"$tmp/dbc.json" &&
        m import "$tmp/f.db" "$tmp/frames.log" --map "$tmp/dbc.json" >/dev/null && m import "$tmp/f.db" "$tmp/frames.log" --map "$tmp/bits.json" >/dev/null || return 1
    m export "$tmp/f.db" 1 --format csv | grep -v '^#' >"$tmp/f1" && m export "$tmp/f.db" 2 --format csv | grep -v '^#' >"$tmp/f2" || return 1
    # Without an edge displacement counts from no particular place: from its first here.
    python3 - "$tmp/f1" "$tmp/f2" <<'PYTHON'
import csv, sys
a, b = (list(csv.DictReader(open(f))) for f in sys.argv[1:])
assert len(a) == len(b) > 3990
n = 0
for x, y in zip(a, b):
    t = float(x["t_s"]) - float(a[0]["t_s"])
    for r in (x, y):
        assert r["d1_in"] == "" or abs(float(r["d1_in"]) - float(a[0]["d1_in"]) - 0.5 * t) < 2.1e-5, (t, r)
        assert r["t3_lb"] == "" or abs(float(r["t3_lb"]) - (90 - t)) < 1.5e-3, (t, r)
        n += r["d1_in"] != "" and r["t3_lb"] != ""
assert n > 7900, n
PYTHON
}
damage_in_a_table_is_named() {
    sed -e '1000s/,/,x/4' -e '2000s/^/x/' "$tmp/run1.csv" >"$tmp/bad.csv"
    fails_with 4 'malformed at line 1000, column [0-9]+: no number; 2 lines were skipped' build/matrig --quiet import "$db" "$tmp/bad.csv" --map tests/exchange/exported.json --like 1 || return 1
    local lost=$(grep -c '^[0-9-].*L' "$tmp/run1.csv") # and their two blocks are missing, no more
    [ "$(m export "$db" "$(cell 'SELECT max(id) FROM landings')" --format csv | grep -c '^[0-9-].*L')" = $((lost + 2)) ] || return 1
    head -c 300000 "$tmp/run1.csv" >"$tmp/cut.csv"
    local whole=$(wc -l <"$tmp/cut.csv")
    fails_with 4 "truncated at line $((whole + 1)), column" build/matrig --quiet import "$db" "$tmp/cut.csv" --map tests/exchange/exported.json --like 1 &&
        [ "$(m export "$db" "$(cell 'SELECT max(id) FROM landings')" --format csv | grep -vc '^#')" = "$(grep -vc '^#' <(head -n "$whole" "$tmp/cut.csv"))" ]
}
# Cut at every byte of its last two lines: always "truncated", but at a line's end, where nothing can tell.
every_cut_is_seen() {
    printf 't,d\n0.000,1.00\n0.001,2.00\n0.002,3.00\n' >"$tmp/short.csv"
    echo '{"time": {"column": "t"}, "channels": [{"column": "d", "channel": "d1", "unit": "in"}]}' >"$tmp/short.json"
    local at
    for at in 17 20 26 27 30 35 36; do
        head -c $at "$tmp/short.csv" >"$tmp/part.csv"
        build/matrig --quiet import "$tmp/part.db" "$tmp/part.csv" --map "$tmp/short.json" --again >"$tmp/out" 2>&1
        local code=$? want=4
        case $at in 26) want=0 ;; esac
        [ "$(tail -c 1 "$tmp/part.csv" | od -An -c | tr -d ' ')" = '\n' ] && want=0
        echo "$at: $code"
        [ $code -eq $want ] || return 1
    done
}
silly_input() {
    local bad="$tmp/bad.json" table="$tmp/gear.csv"
    map_fails() { # CODE PATTERN JSON
        echo "$3" >"$bad"
        fails_with "$1" "$2" build/matrig import "$tmp/none.db" "$table" --map "$bad" && [ ! -e "$tmp/none.db" ]
    }
    map_fails 4 'not valid JSON: .*line 1, column' '{"time": }' &&
        map_fails 4 'the mapping: .*chanels' '{"time": {"column": 1}, "chanels": [], "channels": [{"column": 2, "channel": "d1", "unit": "in"}]}' &&
        map_fails 4 'channels\[0\]\.channel: .*give d1 to d8' '{"time": {"column": 1}, "channels": [{"column": 2, "channel": "d9", "unit": "in"}]}' &&
        map_fails 4 'channels\[0\]\.unit: .*give in, mm' '{"time": {"column": 1}, "channels": [{"column": 2, "channel": "d1", "unit": "lb"}]}' &&
        map_fails 4 "no column 'y': .*gear.csv line 1" '{"time": {"column": 1}, "channels": [{"column": "y", "channel": "d1", "unit": "in"}]}' &&
        map_fails 4 'give this channel only once' '{"time": {"column": 1}, "channels": [{"column": 2, "channel": "d1", "unit": "in"}, {"column": 3, "channel": "d1", "unit": "in"}]}' &&
        map_fails 4 'rows are valid and 600 are invalid: .*line 2, column 1.*the mapping fits' '{"decimal": ",", "separator": ";", "time": {"column": 1}, "channels": [{"column": 1, "channel": "d1", "unit": "in"}]}' &&
        fails_with 4 'not a CAN frame: ' build/matrig import "$tmp/none.db" "$table" && [ ! -e "$tmp/none.db" ] &&
        fails_with 2 '--like works only with readings of other instruments' build/matrig import "$db" "$tmp/can" --like 1 &&
        fails_with 2 'no landing 99|RUN 99|no RUN 99' build/matrig import "$db" "$table" --map "$tmp/gear.json" --like 99 --again &&
        fails_with 3 'cannot open' build/matrig import "$db" /nonexistent
}

check "a candump log becomes the landing that logging made of it" a_log_is_a_landing
check "the same file twice is refused" twice_is_refused
check "three imports of one log at once make one landing" three_at_once_make_one
check "file and hash stand in the report" it_stands_in_report_and_summary
check "a log that was cut keeps what is whole" a_cut_log_keeps_what_is_whole
check "a damaged line costs itself alone, and is counted as lost" a_damaged_line_costs_itself
check "frames of another bus are left out" another_bus_is_left_out
check "boards on two buses are a question" two_boards_are_a_question
check "what stands before the first frame costs none" before_the_first_frame
check "import and log of a file or a pipe give the same rows" every_road_gives_the_same_rows
instruments
check "another logger's table lies where its trigger says, its gap kept" a_foreign_table_lies_where_its_trigger_says
check "a camera's track gives touchdown speed and gear" a_camera_track_gives_the_gear
check "foreign frames by their bits, also as a DBC file has them" frames_by_their_bits
check "damage in a table is named by line and column" damage_in_a_table_is_named
check "every cut inside a line is seen" every_cut_is_seen
check "what cannot be imported is said, and no campaign made" silly_input
finish
