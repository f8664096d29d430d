#!/usr/bin/env bash
# matrig day: on a terminal through whole landings and killed on its way (tests/day/day.py), and without one.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
board=
trap 'kill $board $(cat "$tmp"/*-day/log.lock 2>/dev/null) 2>/dev/null' EXIT

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
    day 'y\n\nfirst series\nrelaid\ns\nq\n' "$tmp/a.db" >"$tmp/said" || return 1
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
    grep -q "\$ matrig series .*a.db 'first series' --runway relaid" "$tmp/said" && grep -q 'all is kept' "$tmp/said" &&
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
    day "s\ns\n\nq\n" "$tmp/a.db" --serial "pty:$tmp/tty" --can none >"$tmp/said" || return 1
    grep -q 'the log goes on: matrig day' "$tmp/said" && $matrig --json day "$tmp/a.db" | grep -q '"next":"land".*"logging":true' || return 1
    in_state() { [ "$(sqlite3 "$tmp/a.db" 'select group_concat(state) from landings')" = "$1" ]; }
    mkfifo "$tmp/keys"
    $matrig day "$tmp/a.db" <"$tmp/keys" >>"$tmp/said" 2>&1 &
    local here=$!
    exec 7<>"$tmp/keys" # both ends, so that it outlives whoever reads
    printf '\na\ny\n' >&7
    await in_state 1 || { cat "$tmp/said"; return 1; }
    kill -9 $here
    wait $here 2>/dev/null
    in_state 1 && $matrig --json day "$tmp/a.db" | grep -q '"next":"land","reason":"RUN 1 goes on: armed".*"logging":true' || return 1
    timeout 60 $matrig day "$tmp/a.db" <"$tmp/keys" >>"$tmp/said" 2>&1 &
    here=$!
    printf '\nd\n' >&7
    await grep -q 'what was seen\|> 1 look ' "$tmp/said"
    printf 'q\n' >&7
    exec 7>&-
    wait $here
    cat "$tmp/said"
    in_state 0 && [ "$(state "$tmp/a.db")" = look ] && $matrig --json day "$tmp/a.db" | grep -q '"logging":false' && [ "$(sqlite3 "$tmp/a.db" 'select sum(lost) from links')" = 0 ]
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
check "the log goes on without the day, takes its orders, and ends when the landing has" arms_and_disarms
printf 'y\nq\n' | $matrig day "$tmp/b.db" >/dev/null 2>&1
check "a walk along all channels begins with those that are due, and says what the board has" walks_along_channels
check "landings on a terminal, killed on the way: nothing lost, nothing asked twice" whole_day
finish
