#!/usr/bin/env bash
# matrig day: a test day by its checklist, on the emulated board, with the log in a process of its own.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
board= log=
trap 'kill $board $log 2>/dev/null' EXIT

day() { # KEYS DB WORDS...: its output for these lines
    local keys=$1
    shift
    printf "$keys" | timeout 600 $matrig day "$@" 2>&1
}
state() { $matrig --json day "$1" | sed -n 's/.*"next":"\([a-z]*\)".*/\1/p'; }
steps() { $matrig --json day "$1" | grep -o '"step":"[a-z]*","state":"[a-z ]*"' | sed 's/"step":"\([a-z]*\)","state":"\([a-z ]*\)"/\1 \2/'; }
rest() { build/matrig-board --elf build/firmware/matrig.elf --flash "$tmp/flash.bin" --nor "$tmp/nor.bin" --serial "pty:$tmp/tty" --speed real --rig hil/rest.run "$@" 2>"$tmp/board.err" & board=$!; }
off() { kill -INT $board; wait $board; }

mistyped() { # no key but y makes a campaign
    day 'n\n' "$tmp/none.db" >"$tmp/said"
    [ $? = 2 ] && grep -q 'Begin a new campaign' "$tmp/said" && grep -q 'matrig: the campaign .*none.db does not exist, and none was created' "$tmp/said" && [ ! -e "$tmp/none.db" ] &&
        fails_with 3 'none.db' $matrig --json day "$tmp/none.db" && [ ! -e "$tmp/none.db" ]
}
begins() { # a skipped step is skipped for this day alone
    USER=kl day 'y\n\nfirst series\nrelaid\nstandard\njk\ns\nq\n' "$tmp/a.db" >"$tmp/said" || return 1
    cat "$tmp/said"
    grep -q '^  4 survey     skipped ' "$tmp/said" && grep -q '^> 7 ready      next ' "$tmp/said" && [ "$(sqlite3 "$tmp/a.db" 'select name, runway, pattern, who from series')" = "first series|relaid|standard|jk" ] &&
        steps "$tmp/a.db" | diff - <(printf '%s\n' 'look not needed' 'series done' 'calibrate not needed' 'survey next' 'load later' 'advise not needed' 'ready later' 'land later')
}
asks_for_links() { # the first step that needs them does; a command that fails ends nothing
    day "7\npty:$tmp/nothing\n\n7\nq\n" "$tmp/a.db" >"$tmp/said" || return 1
    cat "$tmp/said"
    [ "$(grep -c "the board's serial port" "$tmp/said")" = 1 ] && [ "$(grep -c "the board's CAN bus" "$tmp/said")" = 1 ] &&
        [ "$(grep -c "\$ matrig ready $tmp/a.db --serial pty:$tmp/nothing\$" "$tmp/said")" = 2 ] && grep -q 'failed (exit 3)' "$tmp/said"
}
odd_words() { # a name like an option, a line too long, a link that is none, a path that a shell must quote
    day '2\n--notes\nrw\n\nq\n' "$tmp/a.db" >/dev/null || return 1
    [ "$(sqlite3 "$tmp/a.db" 'select name, runway from series order by id desc limit 1')" = '--notes|rw' ] || return 1
    day "2\n$(printf 'x%.0s' {1..80})\nshort\n\n\nq\n" "$tmp/a.db" >"$tmp/said" || return 1
    grep -q 'input too long: give at most 78 characters' "$tmp/said" && [ "$(sqlite3 "$tmp/a.db" 'select name from series order by id desc limit 1')" = short ] || return 1
    day '7\nnd line\nq\n' "$tmp/a.db" | grep -q 'matrig: .*nd line' || return 1
    local db="$tmp/it's; \`id\`.db"
    day 'y\n2\nodd\n\n\n\nq\n' "$db" >/dev/null 2>&1
    eval "set -- $($matrig --json day "$db" | sed -n 's/.*"command":"\([^"]*\)".*/\1/p' | sed 's/\\\\/\\/g')"
    [ "$3" = "$db" ]
}
up_to_landing() { # series, survey (its readings are typed), load, ready; each in the foreground
    day "y\n\nstandard\nrelaid\n\njk\n\n$(printf '33.7%d\\n' $(seq 100 280))q\n" "$tmp/d.db" >"$tmp/said" || { cat "$tmp/said"; return 1; }
    [ "$(state "$tmp/d.db")" = load ] && [ "$(sqlite3 "$tmp/d.db" 'select count(*) from gage_readings')" = 181 ] || { cat "$tmp/said"; return 1; }
    rest
    day "\nq\n" "$tmp/d.db" --serial "pty:$tmp/tty" --can none >"$tmp/said" || return 1
    off
    for _ in 1 2 3 4 5; do
        rest --can "unix:$tmp/can" # that side waits for its host
        day "\nq\n" "$tmp/d.db" --serial "pty:$tmp/tty" --can "unix:$tmp/can" >"$tmp/ready" || return 1
        off
        grep -q 'no-go at .*: time of day' "$tmp/ready" || break # a busy computer slows the emulated board's clock
    done
    cat "$tmp/ready" >>"$tmp/said"
    cat "$tmp/said"
    [ "$(state "$tmp/d.db")" = land ] && grep -q "\$ matrig survey $tmp/d.db --load pty:$tmp/tty\$" "$tmp/said" && grep -q '^> 8 land       next  *start the log' "$tmp/said"
}
in_landing() { [ "$(sqlite3 "$tmp/d.db" 'select group_concat(state) from landings' 2>/dev/null)" = "$1" ]; }
landing() { # the log is seen, and what it records is next; the links are those of the log
    day "8\nq\n" "$tmp/d.db" --serial "pty:$tmp/tty" --can "unix:$tmp/can" >"$tmp/said" || return 1
    grep -o "\$ matrig log --serial pty:$tmp/tty --can unix:$tmp/can --db $tmp/d.db --page $tmp/d.db-landing.html --commands$" "$tmp/said" | sed 's/^. matrig/exec build\/matrig/' >"$tmp/log.sh"
    build/matrig-board --elf build/firmware/matrig.elf --flash "$tmp/flash.bin" --nor "$tmp/nor.bin" --serial "pty:$tmp/tty" --can "unix:$tmp/can" --rig tests/runs/landing5.run 2>/dev/null &
    board=$!
    bash "$tmp/log.sh" >"$tmp/log.txt" 2>&1 </dev/null &
    log=$!
    await in_landing 2 && $matrig --json day "$tmp/d.db" | tee "$tmp/said" | grep -q '"next":"land","reason":"RUN 1: .*"logging":true' || { cat "$tmp/said" "$tmp/log.txt"; return 1; }
    await in_landing 4 || return 1
    kill -INT $log 2>/dev/null
    wait $log
    [ "$(state "$tmp/d.db")" = look ] && [ -s "$tmp/d.db-landing.html" ] || return 1
    day '\n1300\n88\n2\n\nseen 1\nq\n' "$tmp/d.db" >"$tmp/said" || return 1 # no question for the operator: the series of today has him
    cat "$tmp/said"
    [ "$(sqlite3 "$tmp/d.db" "select group_concat(field || ' ' || value || ' ' || who, '; ') from landing_changes")" = 'weight_lb 1300 jk; note seen 1 jk' ] || return 1
    [ "$(sqlite3 "$tmp/d.db" "select kind, station_ft, panels, who from observations")" = 'wave|88.0|2|jk' ] || { sqlite3 "$tmp/d.db" 'select * from observations'; return 1; }
    grep -q '^> 4 survey     next  *the mat has not been surveyed since RUN 1$' "$tmp/said" && [ "$(sqlite3 "$tmp/d.db" "select value from landing_changes where field = 'note'")" = 'seen 1' ] &&
        $matrig --json day "$tmp/d.db" | grep -q '"command":"matrig survey .*--edges left","logging":false,"run":1,"landings_today":1' &&
        day '8\nr\nq\n' "$tmp/d.db" >"$tmp/said" && grep -q "\$ matrig log --serial pty:$tmp/tty --can unix:$tmp/can " "$tmp/said" && [ -s "$tmp/d.db-report.html" ]
}
weights() { sqlite3 "$1" "select group_concat(landing || ' ' || value, '; ') from landing_changes where field = 'weight_lb'"; }
once_a_day() { # the weight is that of the landing before; only on a day without one it is asked for, and not again
    . tests/board/played.sh
    campaign_of "$tmp/w.db" 1 4 >/dev/null || return 1
    sqlite3 "$tmp/w.db" "update landings set armed_us = (strftime('%s', 'now') - 1) * 1000000" && cp "$tmp/w.db" "$tmp/v.db"
    day '1\njk\n1250 lb\n\n\n1\n\n\nq\n' "$tmp/w.db" >"$tmp/said" && [ "$(grep -c 'weight of the aircraft' "$tmp/said")" = 1 ] &&
        [ "$(grep -c 'operator (Enter: ' "$tmp/said")" = 1 ] && [ "$(weights "$tmp/w.db")" = '2 1250' ] || return 1
    $matrig landing "$tmp/v.db" 1 --correct weight_lb=1300 --reason weighed >/dev/null && day '1\njk\n\n\nq\n' "$tmp/v.db" >"$tmp/said" &&
        ! grep 'weight of the aircraft' "$tmp/said" && [ "$(weights "$tmp/v.db")" = '1 1300; 2 1300' ]
}
import_is_none() { # an imported landing is no landing of the day
    $matrig export "$tmp/d.db" 1 --format csv -o "$tmp/i.csv" || return 1
    before=$($matrig --json day "$tmp/d.db")
    $matrig import "$tmp/d.db" "$tmp/i.csv" --map tests/exchange/exported.json --like 1 >"$tmp/said" 2>&1
    cat "$tmp/said"
    [ "$(sqlite3 "$tmp/d.db" 'select count(*) from imports')" = 1 ] && [ "$before" = "$($matrig --json day "$tmp/d.db")" ]
}
calibrates() { # the next channel is asked for until there is none; one that fails leaves the board as it was
    rest
    day "3\nd1\nq\n\nq\n" "$tmp/a.db" --serial "pty:$tmp/tty" --can none >"$tmp/said"
    cat "$tmp/said"
    off
    grep -q "\$ matrig calibrate d1 --serial pty:$tmp/tty -o $tmp/a.db-calibrated.cfg$" "$tmp/said" && ! grep -q 'config set' "$tmp/said"
}

killed_it_leaves_the_terminal() { # as it was: nothing has to be given back
    python3 - "$matrig" "$tmp/k.db" <<'EOF'
import os, pty, signal, subprocess, sys, termios
ours, theirs = pty.openpty()
was = termios.tcgetattr(theirs)
p = subprocess.Popen([sys.argv[1], "day", sys.argv[2]], stdin=theirs, stdout=theirs, stderr=theirs)
seen = b""
while b"campaign? y: " not in seen:
    seen += os.read(ours, 1000)
os.write(ours, b"y\n")
while b"quit >" not in seen:
    seen += os.read(ours, 1000)
p.send_signal(signal.SIGKILL)
p.wait()
assert termios.tcgetattr(theirs) == was
EOF
}
check "killed, it leaves the terminal as it was" killed_it_leaves_the_terminal
check "a name mistyped makes no campaign" mistyped
check "a series is begun, a survey skipped, the next step is known" begins
check "links are asked for, and a step that fails ends nothing" asks_for_links
check "names like options, lines too long, links that are none, odd paths" odd_words
check "series, survey, load, ready: the landing is next" up_to_landing
check "a log in another terminal is seen; its landing is looked at, noted, reported" landing
check "operator and weight are asked for once a day" once_a_day
check "an import is no landing of the day" import_is_none
check "calibrate: channel by channel" calibrates
finish
