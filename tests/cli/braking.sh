#!/usr/bin/env bash
# Brake edge and wheel-speed pick-up: a landing drawn by tests/braking/braked on the emulated board, logged, its edges held against the run
# file, and replayed.
. "$(dirname "$0")/tap.sh"
elf=build/tests/variant/wheel.elf

land() { # with the configuration, which a replay needs
    build/tests/braking/braked 1 "$tmp/1.run" >"$tmp/1.truth" || return 1
    build/matrig-board --elf "$elf" --can "unix:$tmp/can" --serial "unix:$tmp/serial" --rig "$tmp/1.run" 2>/dev/null &
    local board=$!
    build/matrig --quiet log --can "unix:$tmp/can" --serial "unix:$tmp/serial" --db "$tmp/1.db" >/dev/null
    wait $board
}
# The capture counts in 1/84 us from the start of the scans: a constant behind the times of the run.
edges_are_those_of_the_run() {
    sqlite3 -separator ' ' "$tmp/1.db" "select code, value from events where kind = 'braking' order by code" >"$tmp/edges.txt"
    awk '/^brake / { at[0] = $2 } /^wheel / { at[++n] = $2 }
        FILENAME ~ /edges/ { miss = at[$1] - $2 / 84e6; if (!seen++) first = miss; miss -= first; if (miss < 0) miss = -miss
            if (miss > worst) worst = miss; counted += $1 > 0 }
        END { printf "%d of %d pulses and the brake, at most %.4f us off\n", counted, n, worst * 1e6; exit !(counted > 150 && seen == counted + 1 && worst < 2.5e-8) }' \
        "$tmp/1.run" "$tmp/edges.txt"
}
replay_gives_the_edges_again() {
    build/matrig --json --quiet replay "$tmp/1.db" 1 --elf $elf >"$tmp/replay.json" || { head -c 2000 "$tmp/replay.json"; return 1; }
    sqlite3 :memory: "select json_extract(value, '\$.compared') from json_each((select json_extract(cast(readfile('$tmp/replay.json') as text), '\$.by_message'))) where json_extract(value, '\$.message') = 'braking_edge'" | tee "$tmp/compared.txt"
    [ "$(sort -nu "$tmp/compared.txt" | head -n 1)" -gt 150 ]
}
absent_nothing_is_said() { # the signals are there; the board is not told of them
    build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/absent.can" --rig "$tmp/1.run" 2>/dev/null &&
        build/matrig --quiet log --all --can "file:$tmp/absent.can" --db "$tmp/absent.db" >/dev/null || return 1
    ! grep -q ' 0BB#' "$tmp/absent.can" && [ "$(sqlite3 "$tmp/absent.db" "select count(*) from events where kind = 'braking'")" = 0 ]
}

check "a landing with brake and wheel is played and logged" land
check "each edge is recorded where it was, to a tick of the timer" edges_are_those_of_the_run
check "replay gives the edges again" replay_gives_the_edges_again
check "without pick-up nothing is said" absent_nothing_is_said
finish
