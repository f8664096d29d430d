#!/usr/bin/env bash
# Brake edge and wheel-speed pick-up: landings drawn by tests/braking/braked, played on the emulated board, logged, and what matrig says of
# brake, slip, locked wheel and thrust held against what was drawn.
. "$(dirname "$0")/tap.sh"
elf=build/tests/variant/wheel.elf
count=$(take 10 100)

# land SEED: a line of truth behind each measured value with its error
land() {
    local at=$tmp/$1 board name unit
    build/tests/braking/braked "$1" "$at.run" >"$at.truth" || return 1
    build/matrig-board --elf "$elf" --can "unix:$at.can" --serial "unix:$at.serial" --rig "$at.run" 2>/dev/null &
    board=$!
    build/matrig --quiet log --can "unix:$at.can" --serial "unix:$at.serial" --db "$at.db" >/dev/null
    wait $board && build/matrig --json show "$at.db" 1 >"$at.json" || return 1
    sqlite3 -separator ' ' :memory: "with j(b) as (select json_extract(cast(readfile('$at.json') as text), '\$.braking'))
        select $1, $(for f in onset_s slip locked_s deceleration_ft_s2 thrust_lb; do
        name=${f%%_*} unit=${f#"${f%%_*}"}
        printf "json_extract(b, '$.%s'), json_extract(b, '$.%s_error%s'), " "$f" "$name" "$unit"
    done) json_extract(b, '$.pulses'), json_array_length(b, '$.locks'), coalesce(json_extract(b, '$.locks[0].from_s'), -1),
        coalesce(json_extract(b, '$.locks[0].from_error_s'), 1) from j" | paste -d' ' - "$at.truth" >>"$tmp/table.txt"
    [ "$1" = 1 ] || rm -f "$at".*
}
all_land() {
    for seed in $(seq "$count"); do land "$seed" || return 1; done
    [ "$(wc -l <"$tmp/table.txt")" = "$count" ]
}
# Bounds of the shares: those of a uniform error, less what so few landings scatter (the last one chosen afterwards).
# columns: seed, 5 x (value, error), pulses, locks, first lock, error; truth: onset slip locked locks deceleration thrust first lock
errors_hold() {
    awk -v n="$count" '
        function held(name, value, error, truth,   z) {
            if (!(error > 0)) { print "no error of " name " in landing " $1; bad = 1; return }
            z = (value - truth) / error; if (z < 0) z = -z
            seen[name]++; in1[name] += z <= 1; in2[name] += z <= 2; in3[name] += z <= 3
            square[name] += (value - truth) ^ 2
        }
        {
            held("onset", $2, $3, $16); held("slip", $4, $5, $17); held("deceleration", $8, $9, $20); held("thrust", $10, $11, $21)
            if ($13 != $19) wrong++
            else if ($19 > 0) { held("locked", $6, $7, $18); held("lock", $14, $15, $22) }
        }
        END {
            for (name in seen) {
                printf "%s: %d within 1 error, %d within 2, %d within 3 of %d; rms %.5f\n", name, in1[name], in2[name], in3[name], seen[name], sqrt(square[name] / seen[name])
                if (in2[name] < 0.9 * seen[name] - 1 || in3[name] < 0.97 * seen[name] - 1 || in1[name] < 0.55 * seen[name] - sqrt(seen[name])) bad = 1
            }
            printf "number of locked spells wrong in %d of %d\n", wrong, n
            exit bad || wrong > 0.03 * n
        }' "$tmp/table.txt" | tee "$tmp/held.txt"
    [ "${PIPESTATUS[0]}" = 0 ] || { cat "$tmp/table.txt"; return 1; }
    sed 's/^/# /' "$tmp/held.txt" >&3
}
replay_gives_the_edges_again() {
    build/matrig --json --quiet replay "$tmp/1.db" 1 --elf $elf >"$tmp/replay.json" || { head -c 2000 "$tmp/replay.json"; return 1; }
    sqlite3 :memory: "select json_extract(value, '\$.compared') from json_each((select json_extract(cast(readfile('$tmp/replay.json') as text), '\$.by_message'))) where json_extract(value, '\$.message') = 'braking_edge'" | tee "$tmp/compared.txt"
    local edges
    edges=$(sqlite3 "$tmp/1.db" "select count(*) from events where kind = 'braking'")
    [ "$edges" -gt 150 ] && [ "$(sort -nu "$tmp/compared.txt" | head -n 1)" -ge "$edges" ]
}
absent_nothing_is_said() { # the signals are there; the board is not told of them
    build/tests/braking/braked 1 "$tmp/absent.run" >/dev/null &&
        build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/absent.can" --rig "$tmp/absent.run" 2>/dev/null &&
        build/matrig --quiet log --all --can "file:$tmp/absent.can" --db "$tmp/absent.db" >/dev/null || return 1
    ! grep -q ' 0BB#' "$tmp/absent.can" && [ "$(sqlite3 "$tmp/absent.db" "select count(*) from events where kind = 'braking'")" = 0 ] &&
        ! build/matrig show "$tmp/absent.db" 1 | grep -q 'brake\|wheel locked'
}
advice_has_the_thrust() { # the same as in the landing, but for the share
    build/matrig advise "$tmp/1.db" --members 64 >"$tmp/advice.txt"
    [ $? -le 1 ] && grep 'measured thrust' "$tmp/advice.txt"
}

exec 3>&1
check "$count drawn landings are played, logged and shown" all_land
check "onset, slip, locked wheel and thrust are those drawn, within their errors" errors_hold
check "replay gives the edges again" replay_gives_the_edges_again
check "without pick-up nothing is said" absent_nothing_is_said
check "advise shows the measured thrust" advice_has_the_thrust
finish
