#!/usr/bin/env bash
# Damaged twins of landings 4 and 5: a switch missing, a switch bouncing. The speed holds, and log, database and page name it.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
db=$tmp/campaign.db

twin() { # LANDING FAULT: the next RUN of the campaign
    printf 'matrig-faults 1\nat 0.05 %s\n' "$2" >"$tmp/faults"
    build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" \
        --rig "tests/runs/landing$1.run" --faults "$tmp/faults" 2>"$tmp/board.err" &&
        $matrig --quiet log --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$db" >"$tmp/log.txt"
}
stored() { sqlite3 "$db" "$1"; }
within_1_percent() { # RUN: board's and host's speed against the run file's
    local truth board host
    truth=$(awk '$2 == "touchdown_speed_ft_s" {print $3}' "tests/runs/landing$2.run")
    board=$(stored "select speed_ft_s from results where landing = $1")
    $matrig --quiet report "$db" -o "$tmp/report.html" >/dev/null || return 1
    host=$(awk '$1 == "touchdown" {print $2}' "$tmp/log.txt")
    echo "truth $truth, board $board, host $host"
    awk -v t="$truth" -v b="$board" -v h="${host:-0}" 'BEGIN {exit !(b > 0.99 * t && b < 1.01 * t && h > 0.99 * t && h < 1.01 * t)}'
}
named() { # RUN REASON SWITCH TIMES TEXT: once for each, however many links told it
    [ "$(stored "select count(*) from events where kind = 'switch' and landing = $1 and code = $2 and detail = $3")" = "$4" ] &&
        [ "$(stored "select count(*) from events where kind = 'switch' and landing = $1")" = "$4" ] && grep -q "$5" "$tmp/report.html" && grep -q "$5" "$tmp/log.txt"
}

check "landing 4 without switch 7" twin 4 "switch 7 skip"
check "its speed is within 1 %" within_1_percent 1 4
check "switch 7 is named" named 1 9 7 1 "switch 7: did not open though the gear passed it"
check "landing 5, switch 12 bounces three times" twin 5 "switch 12 bounce 3 700"
check "its speed is within 1 %" within_1_percent 2 5
check "switch 12 is named" named 2 1 12 3 "switch 12: bounced: the first edge counts, 3 times"
finish
