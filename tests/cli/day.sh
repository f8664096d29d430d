#!/usr/bin/env bash
# matrig day: on a terminal through whole landings and killed on its way (tests/day/day.py), and without one.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
board=
trap 'kill $board $(cut -d" " -f1 "$tmp"/*-day/log.lock 2>/dev/null) 2>/dev/null' EXIT

day() { # KEYS DB WORDS...: what it says to these keys
    local keys=$1
    shift
    printf "$keys" | timeout 60 $matrig day "$@" 2>&1
}
state() { $matrig --json day "$1" | sed -n 's/.*"next":"\([a-z]*\)".*/\1/p'; }
steps() { $matrig --json day "$1" | grep -o '"step":"[a-z]*","state":"[a-z ]*"' | sed 's/"step":"\([a-z]*\)","state":"\([a-z ]*\)"/\1 \2/'; }

mistyped() { # no key but y makes a campaign
    day 'n\n' "$tmp/none.db" >"$tmp/said"
    [ $? = 2 ] && grep -q 'Begin a new campaign' "$tmp/said" && grep -q '^matrig: no campaign: .*none.db; nothing was made' "$tmp/said" && [ ! -e "$tmp/none.db" ] &&
        fails_with 3 'none.db' $matrig --json day "$tmp/none.db" && [ ! -e "$tmp/none.db" ]
}
begins() {
    day 'y\n\nfirst series\nrelaid\ns\ny\nq\n' "$tmp/a.db" >"$tmp/said" || return 1
    cat "$tmp/said"
    steps "$tmp/a.db" >"$tmp/steps"
    diff - "$tmp/steps" <<'S' || return 1
look not needed
series done
calibrate not needed
survey skipped
load not needed
advise not needed
ready next
land later
S
    grep -q 'all is kept' "$tmp/said" &&
        [ "$(sqlite3 "$tmp/a.db" 'select name, runway from series')" = "first series|relaid" ]
}
says_links_once() { # asked for by the first step that needs them, kept, and a failure ends nothing
    day "\npty:$tmp/nothing\n\nq\n" "$tmp/a.db" >"$tmp/said" || return 1
    day '\nq\n' "$tmp/a.db" >>"$tmp/said" || return 1
    cat "$tmp/said"
    [ "$(grep -c "the board's serial port" "$tmp/said")" = 1 ] && [ "$(grep -c 'its CAN bus' "$tmp/said")" = 1 ] &&
        [ "$(grep -c "\$ matrig ready $tmp/a.db --serial pty:$tmp/nothing\$" "$tmp/said")" = 2 ] && grep -q 'did not end well (exit 3)' "$tmp/said" && [ "$(state "$tmp/a.db")" = ready ]
}
what_is_next_stands_in_json() { $matrig --json day "$tmp/a.db" | grep -q '"command":"matrig ready .*","logging":false,"run":0'; }

# The log that a day began goes on without it, is found again, takes orders, and is ended.
arms_and_disarms() {
    build/matrig-board --elf build/firmware/matrig.elf --serial "pty:$tmp/tty" --rig hil/rest.run --speed real 2>"$tmp/board.err" &
    board=$!
    day "s\ny\ns\n\nq\n" "$tmp/a.db" --serial "pty:$tmp/tty" --can none >"$tmp/said" || return 1
    grep -q 'the log goes on: matrig day' "$tmp/said" && $matrig --json day "$tmp/a.db" | grep -q '"next":"land".*"logging":true' || return 1
    in_state() { [ "$(sqlite3 "$tmp/a.db" 'select group_concat(state) from landings')" = "$1" ]; }
    mkfifo "$tmp/keys"
    $matrig day "$tmp/a.db" <"$tmp/keys" >>"$tmp/said" 2>&1 &
    local here=$!
    exec 7<>"$tmp/keys" # both ends, so that it outlives whoever reads
    printf '\n' >&7
    armed() { printf 'a\ny\n' >&7 && wait_until 2 in_state 1; } # a board that has just begun refuses for a moment
    wait_until 30 armed || { cat "$tmp/said"; kill $here; return 1; }
    kill -9 $here
    wait $here 2>/dev/null
    in_state 1 && $matrig --json day "$tmp/a.db" | grep -q '"next":"land","reason":"RUN 1 goes on: armed".*"logging":true' || return 1
    timeout 60 $matrig day "$tmp/a.db" <"$tmp/keys" >>"$tmp/said" 2>&1 &
    here=$!
    printf '\nd\n' >&7
    await in_state 0 || { cat "$tmp/said"; kill $here; return 1; } # disarmed before the gear came: no landing, and the log goes on
    $matrig --json day "$tmp/a.db" | grep -q '"next":"land".*"logging":true,"run":0,"landings_today":0' || return 1
    printf 'e\nq\n' >&7
    wait $here
    exec 7>&-
    cat "$tmp/said"
    [ "$(state "$tmp/a.db")" = land ] && $matrig --json day "$tmp/a.db" | grep -q '"logging":false' && [ "$(sqlite3 "$tmp/a.db" 'select sum(lost) from links')" = 0 ]
}
# What comes into the campaign otherwise is no landing of the day, and ends no log of it.
import_ends_nothing() {
    cp build/test-tmp/day/day/day.db "$tmp/i.db" && $matrig export "$tmp/i.db" 1 --format csv -o "$tmp/i.csv" || return 1
    before=$($matrig --json day "$tmp/i.db")
    $matrig import "$tmp/i.db" "$tmp/i.csv" --like 1 >"$tmp/said" 2>&1
    cat "$tmp/said"
    [ "$(sqlite3 "$tmp/i.db" 'select count(*) from imports')" = 1 ] && [ "$before" = "$($matrig --json day "$tmp/i.db")" ]
}
other_log_is_seen() { # begun by hand, with the board armed
    mkfifo "$tmp/hand"
    exec 6<>"$tmp/hand"
    timeout 60 $matrig --quiet log --serial "pty:$tmp/tty" --db "$tmp/h.db" --commands <"$tmp/hand" >"$tmp/hand.txt" 2>&1 &
    local log=$!
    await test -e "$tmp/h.db"
    hand_armed() { [ "$(sqlite3 "$tmp/h.db" 'select group_concat(state) from landings' 2>/dev/null)" = 1 ]; }
    arms() { printf 'arm\nyes\n' >&6 && wait_until 2 hand_armed; }
    wait_until 30 arms || { cat "$tmp/hand.txt"; kill $log; return 1; }
    $matrig --json day "$tmp/h.db" | tee "$tmp/said" | grep -q '"next":"land","reason":"a log that this day did not begin is running: end it first"'
    local good=$?
    cat "$tmp/said" "$tmp/hand.txt"
    printf 'disarm\nyes\n' >&6
    disarmed() { [ "$(sqlite3 "$tmp/h.db" 'select group_concat(state) from landings')" = 0 ]; }
    await disarmed
    kill -INT $log
    wait $log
    exec 6>&-
    return $good
}
odd_words() { # a name like an option, a line too long, a link that is none, a second line
    day '2\n--notes\nrw\nq\n' "$tmp/a.db" >/dev/null || return 1
    [ "$(sqlite3 "$tmp/a.db" 'select name, runway from series order by id desc limit 1')" = '--notes|rw' ] || return 1
    day "2\n$(printf 'x%.0s' {1..80})\nshort\n\nq\n" "$tmp/a.db" >"$tmp/said" || return 1
    grep -q 'too long: at most 79 characters' "$tmp/said" && [ "$(sqlite3 "$tmp/a.db" 'select name from series order by id desc limit 1')" = short ] || return 1
    printf 'y\n7\nnd line\nq\n' | timeout 60 $matrig day "$tmp/l.db" >"$tmp/said" 2>&1
    cat "$tmp/said"
    [ "$(sqlite3 "$tmp/l.db" "select count(*) from day_words where word = 'serial'")" = 0 ] || return 1
    local db="$tmp/it's; \`id\`.db"
    printf 'y\nq\n' | $matrig day "$db" >/dev/null 2>&1
    day '2\nodd\n\nq\n' "$db" >/dev/null 2>&1
    eval "set -- $($matrig --json day "$db" | sed -n 's/.*"command":"\([^"]*\)".*/\1/p' | sed 's/\\\\/\\/g')"
    [ "$3" = "$db" ]
}
walks_along_channels() { # the board was never calibrated: all 22 are due; what is left leaves the walk open
    printf '3\ns\nq\nq\n' | timeout 60 $matrig day "$tmp/b.db" --serial "pty:$tmp/tty" --can none --who t >"$tmp/said" 2>&1
    cat "$tmp/said"
    grep -q '^22 channels are due$' "$tmp/said" && grep -q '^d1 .*never calibrated; due' "$tmp/said" && grep -q '^d2 .*never calibrated; due' "$tmp/said" &&
        [ "$(sqlite3 "$tmp/b.db" "select count(*) from day_words where word = 'calibrated'")" = 0 ] && [ -s "$tmp/b.db-day/rig.cfg" ]
}
whole_day() { timeout 500 python3 tests/day/day.py "$tmp/day" "$(take 1 5)" "$(take 2 10)"; }

check "a name mistyped makes no campaign" mistyped
check "a series is begun, a survey skipped, the next step is known" begins
check "links are asked for once, and a step that fails ends nothing" says_links_once
check "what is next stands in the JSON" what_is_next_stands_in_json
check "the log goes on without the day, takes its orders, and a landing that was disarmed is none" arms_and_disarms
check "a log begun by hand is seen" other_log_is_seen
check "names like options, lines too long, links that are none, odd paths" odd_words
printf 'y\nq\n' | $matrig day "$tmp/b.db" >/dev/null 2>&1
check "a walk along all channels begins with those that are due, and says what the board has" walks_along_channels
check "landings on a terminal, killed on the way: nothing lost, nothing asked twice" whole_day
check "an import is no landing of the day" import_ends_nothing
finish
