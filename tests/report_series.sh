#!/usr/bin/env bash
# make report-series: the five landings of the standard series on the emulated board, each with a survey of the mat before it, compared with the
# simulation, on one page: build/report-series/report.html. An engineer's notes and waves are made up. Needs the runs in build/runs.
set -eu
cd "$(dirname "$0")/.."
out=build/report-series
db=$out/campaign.db
rm -rf "$out"
mkdir -p "$out"

# Readings of all four gage lines, with every tenth mat's gap sum as the run file has it and a caliper's error of 0.003 in.
sheet() { # RUN-FILE WORD SEED NOTE
    awk -v word="$2" -v seed="$3" 'BEGIN { srand(seed); print "kind,line,place,reading_in" }
        $1 == word { for (i = 2; i <= NF; i++) gap[n++] = $i }
        END { for (line = 1; line <= 4; line++)
                  for (span = 0; span < 42; span++) {
                      sum = 0
                      for (k = 0; k < 10; k++) sum += gap[10 * span + k]
                      e = 0
                      for (k = 0; k < 12; k++) e += rand()
                      printf "gap,%d,%d,%.3f\n", line, span, 33.5 + sum + 0.003 * (e - 6)
                  } }' "$1" >"$out/sheet.csv"
    USER=jk build/matrig --quiet survey "$db" --new --edges none --from "$out/sheet.csv" --doubtful --note "$4" >/dev/null
}
play() { # LANDING: and on, until the runway is in the board's memory, 0.5 s after it is disarmed
    local for_s
    for_s=$(awk '$1 == "duration_s" { print $2 + 1.2; exit }' "build/runs/landing$1.run")
    build/matrig-board --elf build/firmware/matrig.elf --nor "$out/nor.bin" --can "unix:$sockets/can" --serial "unix:$sockets/serial" \
        --rig "build/runs/landing$1.run" --for "$for_s" --seed "$1" --speed max 2>"$out/board.txt" &
    board=$!
    build/matrig --quiet log --can "unix:$sockets/can" --serial "unix:$sockets/serial" --db "$db" >"$out/log.txt" 2>"$out/log.err"
    wait "$board"
    board=
}
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
board=
trap '[ -z "$board" ] || kill "$board" 2>/dev/null || true; rm -rf "$sockets"' EXIT
build/matrig --quiet landing "$db" --series standard --runway "model, 1 to 7" --pattern standard >/dev/null
for landing in 1 2 3 4 5; do
    sheet "build/runs/landing$landing.run" gap_in "$landing" "before landing $landing"
    play "$landing"
    build/matrig --quiet compare "$db" "$landing" >"$out/compare.txt" || [ $? = 1 ]
done
sheet build/runs/landing5.run gap_end_in 6 "after landing 5"
build/matrig --quiet landing "$db" 4 --observe wave --station 88 --panels 2 --height 0.3 --who jk >/dev/null
build/matrig --quiet landing "$db" 5 --observe wave --station 91 --panels 2 --height 0.6 --side left --who jk >/dev/null
build/matrig report "$db" -o "$out/report.html"
