#!/usr/bin/env bash
# What goes out of matrig is read by programs that are not ours, to the same values: the DBC file by canmatrix, the CSV export by
# SQLite, the candump export by its own grammar.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
db=$tmp/campaign.db

played --elf build/firmware/matrig.elf --can "file:$tmp/can" --rig tests/runs/landing5.run >/dev/null 2>&1
build/matrig --quiet log --can "file:$tmp/can" --db "$db" >/dev/null
build/matrig export "$db" 1 --format csv -o "$tmp/run.csv"
build/matrig export "$db" 1 --format candump -o "$tmp/run.log"
build/matrig export --format dbc -o "$tmp/matrig.dbc"

# Over 100,000 values, none further off than a digit of the CSV; no line of the DBC that the parser does not understand.
foreign_parser() {
    /usr/bin/python3 tests/exchange/dbc_read.py "$1" "$tmp/run.log" "$tmp/run.csv" >"$tmp/foreign" || { cat "$tmp/foreign"; return 1; }
    head -n 1 "$tmp/foreign"
    awk 'NR == 1 {exit !($5 > 100000 && $10 == 0)}' "$tmp/foreign" && grep -qx 'state idle armed landing settling done' "$tmp/foreign"
}
foreign_parser_can_fail() { # one factor, one place
    sed 's/d4_in : 0|16@1- (0.0001,0)/d4_in : 0|16@1- (0.00011,0)/' "$tmp/matrig.dbc" >"$tmp/factor.dbc"
    sed 's/t2_lb : 16|16/t2_lb : 24|16/' "$tmp/matrig.dbc" >"$tmp/place.dbc"
    ! cmp -s "$tmp/matrig.dbc" "$tmp/factor.dbc" && ! cmp -s "$tmp/matrig.dbc" "$tmp/place.dbc" &&
        ! foreign_parser "$tmp/factor.dbc" && ! foreign_parser "$tmp/place.dbc"
}
# Of a board with base 0x190 on its bus: what names an identifier is 400 more, and nothing else is another.
shift_dbc() { # BASE: the DBC of base 0 on stdin
    awk -v base="$1" '
        /^(BO_|VAL_|SIG_VALTYPE_) / { $2 += base }
        /^CM_ (BO_|SG_) / { sub($3, $3 + base) }
        /^BA_ "GenMsgCycleTime" BO_ / { sub($4, $4 + base) }
        { print }' FS=' ' OFS=' '
}
dbc_of_a_base() {
    build/matrig export --format dbc --base 0x190 -o "$tmp/second.dbc" && build/matrig export --format dbc --base 400 | cmp - "$tmp/second.dbc" &&
        build/matrig export --format dbc --base 0 | cmp - "$tmp/matrig.dbc" || return 1
    # a foreign parser has the same messages in it, 400 further
    /usr/bin/python3 tests/exchange/dbc_read.py "$tmp/second.dbc" >"$tmp/second.ids" || return 1
    grep -E '^BO_ ' "$tmp/matrig.dbc" | awk '{ sub(":", "", $3); print $3, $2 + 400 }' | diff - "$tmp/second.ids" &&
        [ "$(wc -l <"$tmp/second.ids")" -gt 80 ] && grep -qx 'command 1424' "$tmp/second.ids" || return 1
    # every line, but for the comment at the head
    shift_dbc 400 <"$tmp/matrig.dbc" | sed 's/\(for missing data\.\)";$/\1 All identifiers include base 0x190 of the board.";/' | diff - "$tmp/second.dbc"
}
dbc_refuses() {
    fails_with 2 "^matrig: base 0x3ff is too large: --base; give at most 0x3fe, so that no identifier exceeds 0x7ff$" build/matrig export --format dbc --base 0x3ff &&
        fails_with 2 "^matrig: base 0x3ff is too large: --base" build/matrig export --format dbc --base 1023 && fails_with 2 "'19g' of --base; write a number such as 0x190" build/matrig export --format dbc --base 19g &&
        fails_with 2 "'-1'" build/matrig export --format dbc --base=-1 && fails_with 2 "'0x'" build/matrig export --format dbc --base 0x && fails_with 2 "''" build/matrig export --format dbc --base '' &&
        build/matrig export --format dbc --base 0x3fe | grep -qx 'BO_ 2047 config_word: 8 HOST'
}
# The median time between two frames of a message, as the board sent them, is its cycle time.
cycle_times() {
    python3 - "$tmp/cycles" "$tmp/can" <<'PYTHON'
import statistics, sys
cycles = {w[1]: int(w[2]) for w in map(str.split, open(sys.argv[1])) if w and w[0] == "cycle"}
times = {}
for line in open(sys.argv[2]):
    time, _, frame = line.split()
    times.setdefault(frame.split("#")[0], []).append(float(time[1:-1]))
checked = 0
for name, ms in cycles.items():
    seen = times.get(name, [])
    if len(seen) < 6:
        continue
    median = 1000 * statistics.median(b - a for a, b in zip(seen, seen[1:]))
    if abs(median - ms) > 0.1 * ms:
        sys.exit(f"{name}: {ms} ms said, {median:.1f} ms sent")
    checked += 1
print(checked, "messages")
sys.exit(checked < 30)
PYTHON
}
in_sqlite() {
    grep -v '^#' "$tmp/run.csv" >"$tmp/plain.csv"
    sqlite3 :memory: '.mode csv' ".import $tmp/plain.csv run" '.mode list' \
        "SELECT count(*), round(sum(t5_lb), 3), round(max(CAST(d2_in AS REAL)), 5) FROM run WHERE t5_lb <> ''" >"$tmp/sqlite" || return 1
    awk -F, 'NR == 1 {for (i = 1; i <= NF; i++) c[$i] = i; next}
        $c["t5_lb"] != "" {n++; sum += $c["t5_lb"]; if ($c["d2_in"] > most) most = $c["d2_in"]}
        END {printf "%d|%.3f|%.5f\n", n, sum, most}' "$tmp/plain.csv" >"$tmp/awk"
    cat "$tmp/sqlite" "$tmp/awk"
    awk -F'|' 'NR == 1 {split($0, a, "|")} NR == 2 {exit !(a[1] == $1 && $1 > 5000 && (a[2] - $2) ^ 2 < 1e-4 && (a[3] - $3) ^ 2 < 1e-12)}' "$tmp/sqlite" "$tmp/awk"
}
# Times of day, where the campaign knows the board's clock (here: that it does is written into a copy). Expected by integers: a board
# 25 ppm fast, at 4 s of its time it was 1764000000.123456.
times_of_day() {
    sqlite3 "$db" "vacuum into '$tmp/dated.db'" && sqlite3 "$tmp/dated.db" "delete from time_maps; insert into time_maps(session, boot, link, landing, refusal, pairs,
        from_us, to_us, spread_us, fast_ppm, fast_half_ppm, board_us, host_us, host_half_us) select session, boot, 0, 1, 0, 60, 0, 9000000, 50, 25, 0.1, 4000000,
        1764000000123456, 30 from landings where id = 1" || return 1
    build/matrig export "$tmp/dated.db" 1 --format candump -o "$tmp/dated.log" 2>"$tmp/err" && [ ! -s "$tmp/err" ] || { cat "$tmp/err"; return 1; }
    paste -d' ' "$tmp/run.log" "$tmp/dated.log" | python3 -c '
import sys
n = 0
for line in sys.stdin:
    board, _, frame, day, _, same = line.split()
    us = lambda stamp: int(stamp[1:-1].replace(".", ""))
    since = us(board) - 1000000000000000 - 4000000
    want = 1764000000123456 + since * 1000000 / 1000025
    assert frame == same and abs(us(day) - want) <= 0.51, (line, want)
    n += 1
assert n > 20000, n'
}
no_date_is_told() {
    build/matrig export "$db" 1 --format candump -o "$tmp/again.log" 2>"$tmp/err" && cmp "$tmp/run.log" "$tmp/again.log" &&
        grep -q 'times of day unknown: time stamps are board time after 2001-09-09 01:46:40 UTC; [a-z]' "$tmp/err"
}
exactly_six_decimals() {
    [ "$(wc -l <"$tmp/run.log")" -gt 20000 ] && ! grep -Evn '^\([0-9]{10}\.[0-9]{6}\) can0 [0-9A-F]{3}#([0-9A-F]{2}){0,8}$' "$tmp/run.log"
}

check "a foreign parser decodes the logged frames by the DBC to the CSV's values" foreign_parser "$tmp/matrig.dbc"
cp "$tmp/foreign" "$tmp/cycles"
check "a wrong factor or place in the DBC would be found" foreign_parser_can_fail
check "the DBC of a board with a base has every identifier so much further" dbc_of_a_base
check "a base that is none is refused" dbc_refuses
check "cycle times are those of the board" cycle_times
check "SQLite takes in the CSV" in_sqlite
check "candump export has times of day where the board's clock is known" times_of_day
check "where the clock is not known, that is said" no_date_is_told
check "candump export has exactly six decimals" exactly_six_decimals
finish
