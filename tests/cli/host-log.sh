#!/usr/bin/env bash
# matrig log: killed in mid-landing, stopped, timed; and what comes out again through can-utils, csv, JSON and the report.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
trap 'kill $(jobs -p) 2>/dev/null' EXIT

played --elf build/firmware/matrig.elf --can "file:$tmp/all.can" --serial "file:$tmp/all.serial" \
    --rig tests/runs/landing5.run 2>"$tmp/board.err"
frames_in() { sqlite3 "$1" 'select count(*) from frames where link = 0 and direction = 0'; }
blocks_in() { sqlite3 "$1" 'select count(*) from blocks'; }
stored_can() { sqlite3 "$1" "select printf('%03X#', can_id) || hex(data) from frames where link = 0 order by id"; }

# The first 3.5 s of the landing arrive, then nothing more; a little later the logger is killed.
kill_after_silence() {
    local lines=12000 bytes=250000 logger
    mkfifo "$tmp/can.fifo" "$tmp/serial.fifo"
    (head -n $lines "$tmp/all.can"; sleep 60) >"$tmp/can.fifo" &
    (head -c $bytes "$tmp/all.serial"; sleep 60) >"$tmp/serial.fifo" &
    $matrig --quiet log --can "file:$tmp/can.fifo" --serial "file:$tmp/serial.fifo" --db "$tmp/kill.db" >/dev/null 2>&1 &
    logger=$!
    all_stored() { [ "$(frames_in "$tmp/kill.db")" = $lines ] && [ "$(blocks_in "$tmp/kill.db")" -gt 2000 ]; }
    await all_stored
    kill -9 $logger
    wait $logger 2>/dev/null
    echo "frames $(frames_in "$tmp/kill.db") of $lines"
    [ "$(sqlite3 "$tmp/kill.db" 'pragma integrity_check')" = ok ] && [ "$(frames_in "$tmp/kill.db")" = $lines ] &&
        [ "$(sqlite3 "$tmp/kill.db" 'select state from landings')" = 2 ] && [ "$(blocks_in "$tmp/kill.db")" -gt 2000 ]
}
killed_database_works_on() {
    $matrig --quiet report "$tmp/kill.db" -o "$tmp/kill.html" && grep -q 'RUN 1: landing 5' "$tmp/kill.html" &&
        $matrig --quiet log --can "file:$tmp/all.can" --serial "file:$tmp/all.serial" --db "$tmp/kill.db" | grep -q '^RUN 2: landing 5, done'
}
# Killed while everything flows: what is stored is a beginning of what was sent, without a hole.
kill_in_the_flow() {
    local logger
    mkfifo "$tmp/flow.fifo"
    (while read -r line; do printf '%s\n' "$line"; done <"$tmp/all.can"; sleep 20) >"$tmp/flow.fifo" &
    $matrig --quiet log --can "file:$tmp/flow.fifo" --db "$tmp/flow.db" >/dev/null 2>&1 &
    logger=$!
    flows() { [ -e "$tmp/flow.db" ] && [ "$(frames_in "$tmp/flow.db")" -gt 500 ]; }
    await flows
    kill -9 $logger
    wait $logger 2>/dev/null
    local kept
    kept=$(frames_in "$tmp/flow.db")
    echo "kept $kept"
    [ "$kept" -gt 500 ] && [ "$kept" -lt "$(wc -l <"$tmp/all.can")" ] &&
        cmp <(stored_can "$tmp/flow.db") <(head -n "$kept" "$tmp/all.can" | awk '{print $3}')
}
stops_on() { # SIGNAL
    local logger status
    mkfifo "$tmp/stop$1.fifo"
    (cat "$tmp/all.can"; sleep 20) >"$tmp/stop$1.fifo" &
    $matrig --json --quiet log --can "file:$tmp/stop$1.fifo" --db "$tmp/stop$1.db" >"$tmp/stop$1.json" &
    logger=$!
    comes() { [ -e "$tmp/stop$1.db" ] && [ "$(frames_in "$tmp/stop$1.db")" -gt 0 ]; }
    await comes "$1"
    kill -"$1" $logger
    wait $logger
    status=$?
    echo "exit $status"
    [ $status = 0 ] && grep -q '"ended_by":"signal"' "$tmp/stop$1.json" &&
        [ "$(sqlite3 "$tmp/stop$1.db" 'select ended_by from sessions')" = signal ]
}
stops_after_its_time() {
    mkfifo "$tmp/time.fifo"
    (cat "$tmp/all.can"; sleep 20) >"$tmp/time.fifo" &
    $matrig --json --quiet log --can "file:$tmp/time.fifo" --db "$tmp/time.db" --for 2 >"$tmp/time.json" &&
        grep -q '"ended_by":"time"' "$tmp/time.json" && [ "$(frames_in "$tmp/time.db")" = "$(wc -l <"$tmp/all.can")" ]
}

log_both() { $matrig --json log --can "file:$tmp/all.can" --serial "file:$tmp/all.serial" --db "$tmp/all.db" >"$tmp/all.json" 2>"$tmp/all.err"; }
nothing_but_json() { [ "$(wc -l <"$tmp/all.json")" = 1 ] && [ "$(cat "$tmp/all.err")" = "matrig: a new campaign: $tmp/all.db" ] && grep -q '^{"db":.*}$' "$tmp/all.json"; }
summary_says() { # each figure as the run file's truth has it
    $matrig report "$tmp/all.db" -o "$tmp/all.html" 2>/dev/null && $matrig --quiet log --all --can "file:$tmp/all.can" \
        --serial "file:$tmp/all.serial" --db "$tmp/text.db" >"$tmp/summary.txt" || return 1
    cat "$tmp/summary.txt"
    grep -q '^RUN 1: landing 5, done' "$tmp/summary.txt" && grep -q 'switches  *[0-9]* of 24 seen; switches 20 to 24 not reached' "$tmp/summary.txt" &&
        grep -Eq 'CAN  *[0-9]+ frames received, 0 lost' "$tmp/summary.txt" &&
        grep -Eq 'serial  *[0-9]+ frames received, 0 lost' "$tmp/summary.txt"
}
# figure LABEL: the first number after the label of the summary
figure() { sed -n "s/^ *$1 *\([0-9.]*\) .*/\1/p" "$tmp/summary.txt" | head -n 1; }
truth() { sed -n "s/^truth $1 //p" tests/runs/landing5.run; }
near() { awk -v a="$1" -v b="$2" -v t="$3" 'BEGIN { d = a - b; if (d < 0) d = -d; print a, b, t; exit !(a != "" && b != "" && d <= t) }'; }
speed_is_true() { near "$(figure touchdown)" "$(truth touchdown_speed_ft_s)" 0.071; }
deceleration_is_true() { near "$(figure deceleration)" "$(truth mean_deceleration_ft_s2)" 0.155; }
movements_are_true() {
    local n station
    for n in 1 2 3 4 5 6 7 8; do
        station=$((30 + 10 * n)).0
        near "$(sed -n "s/^ *$n  *$station  *\([-0-9.]*\) +- .*/\1/p" "$tmp/summary.txt" | head -n 1)" "$(truth peak_displacement_in_$n)" 0.005 || return 1
    done
}
tension_changes_are_true() { # the larger of rise and fall, from the JSON object
    local n change
    for n in $(seq 14); do
        change=$(sqlite3 :memory: "with t as (select json_extract(cast(readfile('$tmp/all.json') as text), '\$.landings[0].tensions[$((n - 1))]') as g)
            select max(json_extract(g, '\$.most_lb') - json_extract(g, '\$.before_lb'), json_extract(g, '\$.before_lb') - json_extract(g, '\$.least_lb')) from t")
        near "$change" "$(truth peak_tension_change_lb_$n)" 1 || return 1
    done
}

candump_through_can_utils() {
    $matrig export "$tmp/all.db" 1 --format candump -o "$tmp/run.log" || return 1
    (cd "$tmp" && log2asc -I run.log -O run.asc can0 && asc2log -I run.asc -O back.log) 2>/dev/null
    [ "$(wc -l <"$tmp/run.log")" -gt 10000 ] || return 1
    cmp <(awk '{print $3}' "$tmp/run.log") <(awk '{print $3}' "$tmp/back.log") || return 1
    # time since the first frame, in microseconds
    since() { awk '{gsub(/[()]/, "", $1); split($1, t, "."); if (NR == 1) { s = t[1]; u = t[2] } printf "%d\n", (t[1] - s) * 1000000 + t[2] - u}' "$1"; }
    cmp <(since "$tmp/run.log") <(since "$tmp/back.log")
}
candump_comes_back() { # what was exported can be logged again, frame for frame
    $matrig --quiet log --can "file:$tmp/run.log" --db "$tmp/again.db" >/dev/null &&
        cmp <(stored_can "$tmp/again.db") <(awk '{print $3}' "$tmp/run.log")
}
csv_has_every_millisecond() {
    $matrig export "$tmp/all.db" 1 --format csv -o "$tmp/run.csv" || return 1
    grep -v '^#' "$tmp/run.csv" | awk -F, 'NR == 1 { if (NF != 28 || $5 != "d1_in" || $26 != "t14_lb") exit 1; next }
        { if (NF != 28 || length($27) != 22 || $28 != "SSSSSSSSSSSSSSSSSSSSSS" || (NR > 2 && $2 != last + 1)) { print; exit 1 } last = $2; rows++ }
        END { if (rows < 5000) exit 1 }' && grep -q '^# readings from serial block records' "$tmp/run.csv"
}
csv_in_si() { # millimetres are 25.4 times inches, row by row
    $matrig --si export "$tmp/all.db" 1 --format csv -o "$tmp/si.csv" && grep -q ',d1_mm,' "$tmp/si.csv" &&
        paste -d, <(grep -v '^[#t]' "$tmp/run.csv" | cut -d, -f6) <(grep -v '^[#t]' "$tmp/si.csv" | cut -d, -f6) |
        awk -F, '{ d = $1 * 25.4 - $2; if (d > 0.0002 || d < -0.0002) { print; exit 1 } }'
}
serial_alone_has_no_candump() {
    $matrig --quiet log --serial "file:$tmp/all.serial" --db "$tmp/serial.db" >/dev/null &&
        fails_with 2 "logged without a CAN link; use --format csv" $matrig export "$tmp/serial.db" 1 --format candump
}
links_agree() { # each link alone gives the same edges and zones as both
    $matrig --quiet log --can "file:$tmp/all.can" --db "$tmp/can.db" >/dev/null || return 1
    local query='select count, position, tick, printf("%.3f", board_us) from edges union all select block, mats, start_ft, lead_s from zones order by 1, 2'
    [ "$(sqlite3 "$tmp/all.db" "$query" | wc -l)" -gt 50 ] &&
        cmp <(sqlite3 "$tmp/all.db" "$query") <(sqlite3 "$tmp/can.db" "$query") &&
        cmp <(sqlite3 "$tmp/all.db" "$query") <(sqlite3 "$tmp/serial.db" "$query")
}
compare_stores_and_limits() {
    $matrig compare --all "$tmp/all.db" 1 | grep -Eq '^ +8 +110' && [ "$(sqlite3 "$tmp/all.db" 'select count(*) from simulation_channels')" = 8 ] &&
        $matrig compare "$tmp/all.db" 1 --limit 10 >/dev/null && fails_with 1 "rms_in of RUN 1 is .*; the limit 0.0001 is exceeded by" $matrig compare "$tmp/all.db" 1 --limit 0.0001
}
report_is_self_contained() {
    $matrig --quiet report "$tmp/all.db" -o "$tmp/all.html" && [ "$(grep -o '<figure class="chart"' "$tmp/all.html" | wc -l)" -ge 4 ] &&
        ! sed '/^<script>/,$d' "$tmp/all.html" | grep -Eqi -e 'https?:|src=|@import|url\([^#]' -e '[^a-z](nan|inf)[^a-z]' &&
        [ "$(stat -c %s "$tmp/all.html")" -lt 500000 ]
}

check "killed with -9 after the last frame, every frame is there" kill_after_silence
check "the database of a killed logger can be reported and logged into" killed_database_works_on
check "killed with -9 in the flow, what is there has no hole" kill_in_the_flow
check "SIGINT ends the log cleanly" stops_on INT
check "SIGTERM ends the log cleanly" stops_on TERM
check "--for ends the log cleanly" stops_after_its_time
check "log --json gives an object" log_both
check "and nothing else" nothing_but_json
check "the summary says what was seen" summary_says
check "touchdown speed within 0.2 % of truth" speed_is_true
check "mean deceleration within 2 % of truth" deceleration_is_true
check "peak movements within 0.005 in of truth" movements_are_true
check "tension changes within 1 lb of truth" tension_changes_are_true
check "candump goes through log2asc and asc2log" candump_through_can_utils
check "an exported candump can be logged again" candump_comes_back
check "csv has every millisecond" csv_has_every_millisecond
check "csv in SI units" csv_in_si
check "a landing logged over serial alone has no candump" serial_alone_has_no_candump
check "each link alone gives the same edges and zones" links_agree
check "compare stores its result and keeps to its limit" compare_stores_and_limits
check "the report is one self-contained page" report_is_self_contained
finish
