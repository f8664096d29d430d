#!/usr/bin/env bash
# Headroom: wait states and the bus are not modelled; with one and a half cycles an instruction the board does all that it does, with two it
# records all. Landing 5 with plan and chart is the dearest; in make long landings 1 and 4 too.
. "$(dirname "$0")/tap.sh"
dearest=$tmp/landing5.run
python3 tests/board/chart.py tests/runs/landing5.run 0 35.5 0:7.0,1.5:7.0,1.7:8.5 >"$dearest"
played() { # CPI RUN: what is said of it is in $tmp/said
    rm -f "$tmp/campaign.db"
    build/matrig-board --elf build/firmware/matrig.elf --cpi "$1" --rig "$2" --can "file:$tmp/can" --serial "file:$tmp/serial" 2>"$tmp/board.err" &&
        build/matrig --quiet log --all --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/campaign.db" >"$tmp/said"
    cat "$tmp/board.err" "$tmp/said"
    grep -q '^  time to rest ' "$tmp/said"
}
recorded() { played "$1" "$2" && grep -q '^  gaps  *none$' "$tmp/said" && grep -q '^  faults  *none$' "$tmp/said"; }
whole() { recorded "$1" "$2" && ! grep -q 'instead of every mat' "$tmp/said"; }
for run in $(take "$dearest" "$dearest tests/runs/landing1.run tests/runs/landing4.run"); do
    check "$(basename "$run" .run) at 1.5 cycles an instruction: no block missed, the predictor whole" whole 1.5 "$run"
    check "$(basename "$run" .run) at 2: recorded whole, no task late" recorded 2 "$run"
done
# and at so many that the board cannot: it is said
slow_is_told() { ! recorded 4 "$dearest" && grep -q 'instead of every mat' "$tmp/said"; }
check "a board that is too slow says so" slow_is_told
refused() { fails_with 2 '^matrig-board: --cpi cannot be `0.9`' build/matrig-board --cpi 0.9 --rig "$dearest"; }
check "fewer than one is refused" refused
finish
