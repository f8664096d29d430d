#!/usr/bin/env bash
# make series: landings 1 to 5 of the standard series on the emulated board, in order. What is known of the runway goes from landing to landing
# in the board's own memory (--nor), as on the rig. Zone by zone: what the board said; beside it what the report observed of its own five
# landings (4.2, 4.3) and the truth of these synthetic ones (tests/runs/README.md). Needs the runs in build/runs (tests/runs/synthesise).
# usage: tests/series.sh [FOLDER [RUNS [LANDING...]]]
set -eu
cd "$(dirname "$0")/.."
out=${1:-build/series}
runs=${2:-build/runs}
landings=${*:3}
db=$out/campaign.db
rm -rf "$out"
mkdir -p "$out"

observed=(
    "4 ft/s2; 1/4 to 1/3 in of movement with each passage"
    "4 ft/s2; waves two panels long, from here on"
    "deceleration not stated; waves two panels long"
    "4.6 ft/s2; two small waves left at station 88; peak movement at the same place as on landing 5"
    "35.5 ft/s, 6.6 to 9.2 ft/s2: buckles at 85 and 91; stations 10 to 80 in tension, compressed beyond 80, about 70 mats"
)

play() { # LANDING: and on, until the runway is in the memory, 0.5 s after it is disarmed
    local for_s
    for_s=$(awk '$1 == "duration_s" { print $2 + 1.2; exit }' "$runs/landing$1.run")
    build/matrig-board --elf build/firmware/matrig.elf --nor "$out/nor.bin" --can none --serial "file:$out/serial.bin" --rig "$runs/landing$1.run" \
        --for "$for_s" --seed "$1" 2>"$out/board$1.txt"
    # The file of the line may end inside a frame: after the landing.
    build/matrig --quiet log --all --serial "file:$out/serial.bin" --db "$db" >"$out/log$1.txt" 2>"$out/log.err" || grep -q 'ended inside a frame' "$out/log.err"
}
# Zones ahead of the wheel: statements that follow each other and overlap are one, told where it is longest. 10 mats or more.
# Seconds after touchdown, by the board's clock, as matrig log, predict and report have them: of the block that decided.
zones() { # RUN
    local zero_s
    zero_s=$(build/matrig export "$db" "$1" --format csv | sed -n 's/.*board time of t_s = 0: \([0-9.]*\) s.*/\1/p')
    sqlite3 -separator ' ' "$db" "select printf('%.3f', (1000.0 * z.block) / 1e6 - $zero_s), z.mats, z.start_ft, z.end_ft, coalesce(z.wheel_ft, -99), p.start_error_ft,
        p.end_error_ft, p.verdict, p.closed_joints, z.warning from zones z join predictions p using (landing, block)
        where z.landing = $1 order by z.block" |
        awk 'function told() { if (most >= 10) printf "    zone    %7.3f to %7.3f s: %2d mats, %5.1f +- %.1f to %5.1f +- %.1f ft, %d joints closed, wheel at %s, %s%s\n",
                 from, to, most, s, 2 * se, e, 2 * ee, closed, at < -90 ? "no station yet" : sprintf("%.1f ft", at), word[worst], warned == "" ? "" : " from " warned " s" }
             BEGIN { split("quiet advisory warning", w); for (i = 1; i <= 3; i++) word[i - 1] = w[i] }
             { if ($2 == 0 || (last && ($3 > laste || $4 < lasts))) { told(); most = 0; worst = 0; last = 0; warned = "" }
               if ($2 == 0) next
               if (!last) from = $1
               to = $1; last = 1; lasts = $3; laste = $4
               if ($8 > worst) worst = $8
               if ($10 == 1 && warned == "") warned = $1
               if ($2 > most) { most = $2; s = $3; e = $4; at = $5; se = $6; ee = $7; closed = $9 } }
             END { told() }'
}
left() { # RUN: the last statement, as the gear stands
    sqlite3 "$db" "select case when z.mats = 0 then 'nothing' else printf('%d mats, %.1f +- %.1f to %.1f +- %.1f ft', z.mats, z.start_ft, 2 * p.start_error_ft, z.end_ft,
        2 * p.end_error_ft) end from zones z join predictions p using (landing, block) where z.landing = $1 order by z.block desc limit 1"
}
truth() { sed -n "s/^truth $2 //p" "$runs/landing$1.run"; }
run() { # LANDING RUN
    echo "Landing $1"
    echo "  report:   ${observed[$1 - 1]}"
    printf '  truth:    left %s mats, %.1f to %.1f ft, in all %s joints closed; longest ahead of the wheel %s mats\n' "$(truth "$1" zone_at_end_mats)" \
        "$(truth "$1" zone_at_end_start_station_ft)" "$(truth "$1" zone_at_end_end_station_ft)" "$(truth "$1" closed_joints_at_end)" \
        "$(truth "$1" zone_ahead_longest_mats)"
    echo "  board:    runway after $(sqlite3 "$db" "select landings from runways where landing = $2") landings, $(sqlite3 "$db" "select count(*) from slack join surveys on surveys.id = survey where landing = $2") segments surveyed"
    zones "$2"
    sed -n -e '/^  zone /s/^/  /p' -e '/^  first warning/,/^  [^ ]/s/^    /      /p' "$out/log$1.txt"
    echo "    left ahead of the stop: $(left "$2"); closing resistance $(sqlite3 "$db" "select printf('%.2f', resistance) from trust where landing = $2 order by block desc limit 1") of the one configured"
}

echo "Errors are 95 % (1.96 standard errors, told as 2). Times are seconds after touchdown, by the board's clock, at the beginning of the block that decided."
number=0
for landing in ${landings:-1 2 3 4 5}; do
    number=$((number + 1))
    play "$landing"
    run "$landing" $number
done
