#!/usr/bin/env bash
# matrig advise --load, on the emulated board: chart and plan go to a board whose runway has had as many landings as the advice says, and to no other.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
trap 'kill $(jobs -p) 2>/dev/null' EXIT

board() {
    rm -f "$tmp/board.sock"
    build/matrig-board --elf build/firmware/matrig.elf --serial "unix:$tmp/board.sock" --nor "$tmp/nor.bin" 2>"$tmp/board.err" &
    board=$!
}
stop() { kill -TERM $board 2>/dev/null; wait $board 2>/dev/null; }
load() { # OUT OPTION...: gives it to a board of its own
    local out=$1
    shift
    board
    $matrig --quiet --json advise "$tmp/campaign.db" --members 64 --load --serial "unix:$tmp/board.sock" "$@" >"$tmp/$out.json" 2>"$tmp/$out.err"
    local status=$?
    stop
    return $status
}
runway() { # LANDINGS
    { printf 'mats 420\nlandings %s\nresistance 1\n' "$1"; awk 'BEGIN { for (j = 1; j <= 421; j++) printf "joint %d 0.01500\n", j }'; } >"$tmp/runway.txt"
    board
    $matrig board --serial "unix:$tmp/board.sock" runway load "$tmp/runway.txt" >/dev/null
    local status=$?
    stop
    return $status
}
campaign() { campaign_of "$tmp/campaign.db" 5 >"$tmp/log.txt"; } # the board began it with a runway of no landings
told() { sqlite3 "$tmp/campaign.db" "$1"; }
risks_are_kept() {
    [ "$(told 'select count(*) > 100 from risks where risk between 0 and 1')" = 1 ] &&
        [ "$(told 'select count(*) from risk_items where item < 53 and value is not null')" = 0 ] && # no chart
        grep -q 'largest risk of a zone of 50 mats: 0\.[0-9]*, at .* computed without plan and chart' "$tmp/log.txt"
}
another_runway() { ! load another && grep -q 's runway includes 0 landings, but the runway of the advice includes 1' "$tmp/another.err"; }
right_one() { runway 1 && { load right --speed 30ft/s --profile 0s:3ft/s2,2s:3ft/s2,2.2s:12ft/s2 || [ $? = 1 ]; } && [ "$(sqlite3 :memory: "select json_extract(cast(readfile('$tmp/right.json') as text), '\$.loaded')")" = 1 ]; }
what_was_computed_is_shown() { # braking that ends at 0 is no plan for a board: the rows all the same, then why
    ! load shown --speed 30ft/s --profile 0s:9ft/s2,9s:9ft/s2,10s:0ft/s2 && grep -q '^matrig: the board cannot store this plan' "$tmp/shown.err" &&
        [ "$(sqlite3 :memory: "select json_extract(j, '\$.loaded') = 0 and json_array_length(j, '\$.rows') > 5 and json_extract(j, '\$.exit') = 2 from (select cast(readfile('$tmp/shown.json') as text) j)")" = 1 ]
}
# Landing 5 of a board that was told a plan and a chart before it.
told_before() { # LANDINGS SPEED PROFILE
    python3 tests/board/chart.py tests/runs/landing5.run "$@" >"$tmp/told.run" && rm -f "$tmp/told.db" &&
        build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/told.can" --serial "file:$tmp/told.serial" --rig "$tmp/told.run" 2>"$tmp/told.err" &&
        $matrig --quiet log --all --can "file:$tmp/told.can" --serial "file:$tmp/told.serial" --db "$tmp/told.db" >"$tmp/told.txt" &&
        build/tests/again/again "$tmp/told.db" 1 >"$tmp/told.json" && grep -E 'risk of a zone|plan was' "$tmp/told.txt" &&
        [ "$(sqlite3 :memory: "select json_extract(j, '$.statements') > 100 and json_extract(j, '$.differ') = 0 from (select cast(readfile('$tmp/told.json') as text) j)")" = 1 ]
}
both_count() {
    told_before 0 35.5 0:7.0,1.5:7.0,1.7:8.5 && grep -q 'risk of a zone .* computed with chart and plan$' "$tmp/told.txt" && ! grep 'differs from the plan' "$tmp/told.txt" &&
        [ "$(sqlite3 "$tmp/told.db" 'select count(*) > 100 from risks')" = 1 ] &&
        $matrig --quiet replay "$tmp/told.db" 1 --exact >"$tmp/replay.txt" && grep 'result *0 of ' "$tmp/replay.txt"
}
gentle_plan_is_left() { told_before 0 35.5 0:3.0 && grep -q 'the board detected at [0-9.]* s that the landing differs from the plan' "$tmp/told.txt"; }
# the board refuses it: it has had no landing
of_another_runway() { told_before 3 35.5 0:7.5 && grep -q 'computed without plan and chart$' "$tmp/told.txt" && [ "$(sqlite3 "$tmp/told.db" 'select count(*) from risks where basis & 2 and block < 6000')" = 0 ]; }
needs_a_link() { ! $matrig advise "$tmp/campaign.db" --load 2>"$tmp/link.err" && grep -q -- '--load --serial LINK' "$tmp/link.err"; }

check "a campaign of a landing" campaign
check "its risks are kept, and told" risks_are_kept
check "a board whose runway has had other landings refuses" another_runway
check "the right one takes chart and plan, a profile" right_one
check "of a load that fails the table is shown, and then why" what_was_computed_is_shown
check "a landing told both: they count, the host says the same, and a replay" both_count
check "a plan that is not followed is left, and that is told" gentle_plan_is_left
check "a chart of another runway counts for nothing" of_another_runway
check "without a link nothing is loaded" needs_a_link
finish
