#!/usr/bin/env bash
# Damaged twins of landings 4 and 5: a switch missing, a switch bouncing, a transducer stuck or open, a bridge open. The speed
# holds, and log, database and page name it.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/campaign.db

twin() { # LANDING [TRIGGER] FAULT: the next RUN of the campaign
    printf 'matrig-faults 1\n%s %s\n' "$([ "$3" ] && echo "$2" || echo at 0.05)" "${3:-$2}" >"$tmp/faults"
    played --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" \
        --rig "tests/runs/landing$1.run" --faults "$tmp/faults" 2>"$tmp/board.err" &&
        $matrig --quiet log --all --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$db" >"$tmp/log.txt"
}
stored() { sqlite3 "$db" "$1"; }
within_1_percent() { # RUN: board's and host's speed against the run file's
    local truth board host
    truth=$(awk '$2 == "touchdown_speed_ft_s" {print $3}' "tests/runs/landing$2.run")
    board=$(stored "select speed_ft_s from results where landing = $1")
    $matrig --quiet report "$db" --run "$1" -o "$tmp/report.html" >/dev/null || return 1
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

# what is told of a channel, in log and page; `at`: time since touchdown of the damage, from which on its readings are missing
told() { # RUN CHANNEL VALIDITY TEXT
    [ "$(stored "select count(distinct detail) from events where kind = 'channel' and landing = $1")" = 1 ] &&
        [ "$(stored "select count(*) from events where kind = 'channel' and landing = $1 and code = $3 and detail = $2")" = 1 ] &&
        [ "$(stored "select count(*) > 0 from events where kind = 'fault' and code = 31 and detail = $2")" = 1 ] &&
        grep -q "$4" "$tmp/report.html" && grep -q "$4" "$tmp/log.txt"
}
# RUN COLUMN SECONDS TOLERANCE: the column has no value from then on, and all others have one wherever the healthy landing has
missing_from() {
    $matrig --quiet export "$db" "$1" --format csv -o "$tmp/twin.csv" || return 1
    awk -F, -v column="$2" -v from="$3" -v within="$4" '
        /^#/ {next}
        /^t_s/ {for (i = 1; i <= NF; i++) {name[i] = $i; if ($i == column) wanted = i}; next}
        {rows++; for (i = 5; i < NF; i++) if ($i == "") {gone[i]++; if (i == wanted && !first++) at = $1} else last[i] = $1}
        END {
            printf "%s missing from %.3f to the end (%.3f) in %d of %d rows, last value at %.3f\n", column, at, $1, gone[wanted], rows, last[wanted]
            for (i = 5; i < NF; i++) if (i != wanted && gone[i]) {print name[i] " is missing too"; exit 1}
            exit !(wanted && gone[wanted] && at > from - within && at < from + within && (last[wanted] == "" || last[wanted] < at))
        }' "$tmp/twin.csv"
}
untouched() { # RUN LANDING PEAK-OF...: peaks of the other transducers are the run file's, within four standard errors
    local run=$1 landing=$2
    shift 2
    for k; do
        awk -v k="$k" -v t="$(awk -v n="peak_displacement_in_$k" '$2 == n {print $3}' "tests/runs/landing$landing.run")" '
            $1 == k && $4 == "+-" {found = 1; bad = ($3 - t) ^ 2 > 16 * $5 ^ 2; print k, $3, $5, t}
            END {exit bad || !found}' "$tmp/log.txt" || return 1
    done
}

check "landing 5, transducer 4 stuck before it comes" twin 5 "transducer 4 stick"
check "its speed is within 1 %" within_1_percent 3 5
check "transducer 4 is named" told 3 3 7 'transducer 4 (70.0 ft): stuck, from'
check "its readings are missing from where it was first watched, half a second after arming" missing_from 3 d4_in -0.31 0.02
check "the other peaks are right" untouched 3 5 1 2 3
check "the zone is warned of all the same" grep -q 'zone  *warned .* after touchdown' "$tmp/log.txt"
check "landing 4, transducer 3 stuck when the gear is at 38 ft" twin 4 "station 38" "transducer 3 stick"
check "its speed is within 1 %" within_1_percent 4 4
check "transducer 3 is named" told 4 2 7 'transducer 3 (60.0 ft): stuck, from'
check "landing 5, the lead of transducer 5 breaks at 30 ft" twin 5 "station 30" "transducer 5 open"
check "its speed is within 1 %" within_1_percent 5 5
check "transducer 5 is named" told 5 4 3 'transducer 5 (80.0 ft): signal lead open, from'
check "its readings are missing from there on" missing_from 5 d5_in 0.80 0.04 # 27 ft at 35.5 ft/s, unbraked to braked
check "landing 4, the bridge of gage 6 opens at 2.5 s" twin 4 "at 2.5" "gage 6 open"
check "its speed is within 1 %" within_1_percent 6 4
check "gage 6 is named" told 6 13 3 'gage 6 (75.0 ft): bridge open, from'
check "its readings are missing from there on" missing_from 6 t6_lb 0.88 0.01
check "the peaks of all transducers are right" untouched 6 4 1 2 3 4 5 6 7 8
check "landing 5, the amplifier of gage 4 holds its value" twin 5 "gage 4 stick"
check "its speed is within 1 %" within_1_percent 7 5
check "gage 4 is named" told 7 11 7 'gage 4 (55.0 ft): stuck, from'
finish
