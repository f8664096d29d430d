#!/usr/bin/env bash
# A logged landing as its users meet it: exports that other tools read, a log that is killed, comparison, report.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
elf=build/firmware/matrig.elf
run=tests/runs/landing5.run
db=$tmp/campaign.db
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

logs_a_landing() {
    played --elf $elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig $run &&
        build/matrig --json log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >"$tmp/log.json" &&
        grep -q "\"lost\":0" "$tmp/log.json"
}

# can-utils: candump log -> Vector ASC -> candump log. ASC is decimal and relative; ids, data and time differences must stay.
through_can_utils() {
    build/matrig export "$db" 1 --format candump -o "$tmp/export.log" || return 1
    log2asc -I "$tmp/export.log" -O "$tmp/export.asc" can0 && asc2log -I "$tmp/export.asc" -O "$tmp/back.log" || return 1
    [ "$(wc -l <"$tmp/export.log")" -gt 20000 ] || return 1
    cmp <(awk '{print $3}' "$tmp/export.log") <(awk '{print $3}' "$tmp/back.log") || return 1
    # time since the first frame, in the ASC's resolution of 0.1 ms (log2asc writes four decimals)
    paste <(awk '{print $1}' "$tmp/export.log") <(awk '{print $1}' "$tmp/back.log") | tr -d '()' |
        awk 'NR == 1 {a = $1; b = $2} {d = ($1 - a) - ($2 - b); if (d < 0) d = -d; if (d > worst) worst = d}
             END {printf "worst time difference %.6f s\n", worst; exit worst > 0.000101}'
}
candump_export_is_what_came() {
    cmp <(awk '{print $3}' "$tmp/export.log") \
        <(sqlite3 "$db" "select printf('%03X#', can_id) || hex(data) from frames where link = 0 and landing = 1 order by id")
}
csv_has_every_millisecond() {
    build/matrig export "$db" 1 --format csv -o "$tmp/run.csv" || return 1
    head -n 30 "$tmp/run.csv" | cut -c1-150
    local rows blocks
    rows=$(grep -c '^[-0-9]' "$tmp/run.csv")
    blocks=$(sqlite3 "$db" 'select count(*) from blocks where landing = 1')
    echo "$rows rows, $blocks blocks"
    [ "$rows" -eq "$blocks" ] && [ "$blocks" -gt 7000 ]
}
page_stands_alone() {
    build/matrig compare "$db" 1 >/dev/null && build/matrig report "$db" -o "$tmp/report.html" || return 1
    [ "$(grep -o '<figure class="chart"' "$tmp/report.html" | wc -l)" -ge 4 ] && ! sed '/^<script>/,$d' "$tmp/report.html" | grep -Eo '(src|href)="[^#"][^"]*"|@import|url\([^#)]' && [ "$(stat -c %s "$tmp/report.html")" -lt 1500000 ]
}
compare_limit_decides() {
    build/matrig compare "$db" 1 --limit 5 >/dev/null || return 1
    build/matrig compare "$db" 1 --limit 0.001 >/dev/null
    [ $? -eq 1 ]
}

# kill -9 in mid-landing: the database opens and has no hole; that all but the last 100 ms is there: tests/cli/log-faults.sh.
frames_come() { [ "$(sqlite3 "$tmp/killed.db" 'select count(*) from frames where link = 0 and landing = 1')" -ge 4000 ]; }
killed_log_opens() {
    local board log
    timeout 600 build/matrig-board --elf $elf --can "unix:$sockets/can" --serial "unix:$sockets/serial" --rig $run >/dev/null 2>&1 &
    board=$!
    build/matrig --quiet log --can "unix:$sockets/can" --serial "unix:$sockets/serial" --db "$tmp/killed.db" >/dev/null 2>&1 &
    log=$!
    await frames_come || return 1
    kill -9 $log
    kill $board
    wait $log $board
    [ "$(sqlite3 "$tmp/killed.db" 'pragma integrity_check')" = ok ] && frames_come || return 1
    # displacements step by 2 blocks without a gap, and it still reports and exports
    sqlite3 "$tmp/killed.db" "select count(*) - 1 - (max(board_us) - min(board_us)) / 2000 from frames where can_id = 0x100 and landing = 1" |
        grep -qx 0 || return 1
    build/matrig report "$tmp/killed.db" -o "$tmp/killed.html" && build/matrig export "$tmp/killed.db" 1 --format csv -o "$tmp/killed.csv"
}

# A log that ends while the gear moves knows the touchdown, but no stop: an extrapolated one would look measured.
cut_landing_has_no_stop() {
    played --elf $elf --can "file:$tmp/cut.can" --serial "file:$tmp/cut.serial" --rig $run --for 3.5 || return 1
    # the run may end in the middle of a frame
    build/matrig log --all --can "file:$tmp/cut.can" --serial "file:$tmp/cut.serial" --db "$tmp/cut.db" >"$tmp/cut.txt" 2>"$tmp/cut.err" ||
        grep -q 'the link ended inside a frame' "$tmp/cut.err" || return 1
    cat "$tmp/cut.txt"
    grep -Eq 'touchdown +35\.[45]' "$tmp/cut.txt" && grep -q 'stop  *not known: the record ends while the gear moves' "$tmp/cut.txt" &&
        ! grep -q deceleration "$tmp/cut.txt" && fails_with 4 "record ends while the gear moves" build/matrig --quiet compare "$tmp/cut.db" 1
}
# The same before there are switches enough for a fit, and about where the gear stands: 4.69 s after touchdown, of which the stop at 4.58 s
# is known to some tenths.
cut_peaks_are_marked() {
    local for how
    while read -r for how; do
        played --elf $elf --serial "file:$tmp/cut2.serial" --rig $run --for "$for" || return 1
        rm -f "$tmp/cut2.db"
        build/matrig log --all --serial "file:$tmp/cut2.serial" --db "$tmp/cut2.db" >"$tmp/cut2.txt" 2>"$tmp/cut.err" || grep -q 'the link ended inside a frame' "$tmp/cut.err" || return 1
        cat "$tmp/cut2.txt"
        [ "$(grep -Ec "The record ends .*, while the gear $how: peaks" "$tmp/cut2.txt")" = 2 ] && ! grep -q '^  stop  *[0-9]\|not reached' "$tmp/cut2.txt" || return 1
    done <<'L'
1.74 moves
6.30 may still move
L
}
two_logs_begin_a_new_database() { # at once: it is one's alone, or one was done before the other began; never half a schema
    local first good=0
    build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/two.db" >/dev/null 2>"$tmp/two1.err" &
    first=$!
    build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/two.db" >/dev/null 2>"$tmp/two2.err" && good=1
    wait $first && good=$((good + 1))
    cat "$tmp/two1.err" "$tmp/two2.err"
    [ $good -ge 1 ] && [ "$(cat "$tmp/two1.err" "$tmp/two2.err" | grep -c "another program writes to this campaign (matrig log)")" = $((2 - good)) ] &&
        [ "$(sqlite3 "$tmp/two.db" 'select count(*) from landings where state = 4')" = $good ] &&
        [ "$(sqlite3 "$tmp/two.db" 'pragma integrity_check')" = ok ]
}

an_output_never_replaces_a_campaign() {
    local before
    before=$(md5sum <"$db")
    fails_with 2 "would overwrite a database: $db" build/matrig report "$db" -o "$db" || return 1
    fails_with 2 "would overwrite a database: $db" build/matrig export "$db" 1 --format csv -o "$db" || return 1
    fails_with 2 "would overwrite a database: $db" build/matrig export --format dbc -o "$db" || return 1
    fails_with 2 "would overwrite a database" build/matrig-board --elf $elf --can "file:$db" --for 1 || return 1
    [ "$(md5sum <"$db")" = "$before" ]
}
a_closed_pipe_does_not_end_the_log() { # two landings; nobody reads the summaries
    cat "$tmp/serial" "$tmp/serial" >"$tmp/twice.serial"
    build/matrig log --serial "file:$tmp/twice.serial" --db "$tmp/pipe.db" 2>/dev/null | true
    [ "$(sqlite3 "$tmp/pipe.db" 'select count(*) from landings where state = 4')" = 2 ]
}
printing_nowhere_is_an_error() { fails_with 3 "cannot write" bash -c 'build/matrig compare "$1" 1 >/dev/full' - "$db"; }

truncated_run_is_refused() {
    head -c 200000 $run >"$tmp/short.run"
    fails_with 4 "short.run" build/matrig-board --elf $elf --can "file:$tmp/x" --serial "file:$tmp/y" --rig "$tmp/short.run"
}
foreign_run_is_refused() {
    fails_with 4 "Makefile" build/matrig-board --elf $elf --can "file:$tmp/x" --serial "file:$tmp/y" --rig Makefile
}
host_elf_is_refused() {
    fails_with 4 "matrig" build/matrig-board --elf build/matrig --can "file:$tmp/x" --serial "file:$tmp/y" --rig $run
}

check "a landing is logged from files, nothing lost" logs_a_landing
check "the candump export survives log2asc and asc2log" through_can_utils
check "the candump export is what came on CAN" candump_export_is_what_came
check "the CSV export has a row for every block" csv_has_every_millisecond
check "the report stands alone and is small" page_stands_alone
check "compare --limit decides the exit code" compare_limit_decides
check "a log killed in mid-landing opens, without a hole" killed_log_opens
check "a landing cut short has a touchdown and no stop" cut_landing_has_no_stop
check "the peaks of one that ends too soon for a fit, or about the stop, are marked as cut" cut_peaks_are_marked
check "of two logs that begin a new database at once, one has it" two_logs_begin_a_new_database
check "an output never replaces a campaign" an_output_never_replaces_a_campaign
check "a closed pipe does not end the log" a_closed_pipe_does_not_end_the_log
check "text that cannot be printed is an error" printing_nowhere_is_an_error
check "a truncated run file is refused" truncated_run_is_refused
check "a foreign run file is refused" foreign_run_is_refused
check "a program for another processor is refused" host_elf_is_refused
finish
