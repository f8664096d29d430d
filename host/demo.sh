#!/bin/sh
# matrig demo: a day on the emulated board, with landings that are synthetic (tests/runs/README.md). Two landings teach what the runway is
# like, it is surveyed, and matrig advise recommends against the next landing as planned. That landing is then played three times, each
# time on the runway and with the board's memory as the survey found them: as planned, as advised, and with hard braking from touchdown on.
# demo.sh FOLDER MATRIG BOARD IMAGE RUNS [OPTIONS OF MATRIG...]
set -eu
folder=$1 matrig=$2 board=$3 image=$4 runs=$5
shift 5
db=$folder/campaign.db page=$folder/report.html playing='' logging='' run=0 sent=0
export USER='A. Operator' # author of all entries
fail() { # CODE WORDS
    echo "matrig: $2" >&2
    exit "$1"
}
end() {
    for process in $playing $logging; do
        kill "$process" 2>/dev/null || :
        wait "$process" 2>/dev/null || :
    done
    rm -rf "$work"
}
notes() { # what board and log wrote, without the board's statistics; the commands of the run file are counted
    grep -hv -e '^matrig: another program sent ' -e '^matrig-board: .* s virtual in ' "$work/board.err" "$work/log.err" >&2 || :
    sent=$((sent + $(grep -c '^matrig: another program sent ' "$work/log.err" || :)))
}
play() { # LANDING OPTIONS...: until the runway is in the board's memory, 0.5 s after the landing is disarmed
    landing=$1
    shift
    run=$((run + 1)) logged=0 played=0
    for_s=$(awk '$1 == "duration_s" { print $2 + 1.2; exit }' "$runs/landing$landing.run")
    "$board" --elf "$image" --flash "$work/flash" --nor "$work/memory" --can "unix:$work/can" --serial "unix:$work/serial" --rig "$runs/landing$landing.run" --for "$for_s" --speed max 2>"$work/board.err" &
    playing=$!
    "$matrig" "$@" log --can "unix:$work/can" --serial "unix:$work/serial" --db "$db" 2>"$work/log.err" &
    logging=$!
    wait "$logging" || logged=$?
    logging=''
    [ $logged != 0 ] || wait "$playing" || played=$?
    notes
    [ $logged = 0 ] || fail $logged "matrig log ended with exit code $logged: matrig demo; its own message stands above"
    playing=''
    [ $played = 0 ] || fail 3 "matrig-board ended with exit code $played: matrig demo; its own message stands above"
    "$matrig" --quiet landing "$db" $run --correct weight_lb=1300 --reason 'weight of the gear in the synthetic landings' >"$work/said"
    "$matrig" --quiet compare "$db" $run >"$work/said"
}
at_rest() { # WORDS of matrig board, to a board whose gear stands; it takes one connection
    told=0
    "$board" --elf "$image" --flash "$work/flash" --can none --serial "unix:$work/serial" --speed max 2>"$work/board.err" &
    playing=$!
    "$matrig" --quiet board --serial "unix:$work/serial" "$@" >"$work/said" || told=$?
    kill $playing 2>/dev/null || : # it writes its flash and ends
    wait $playing || :
    playing=''
    notes
    [ $told = 0 ] || fail $told "matrig board ended with exit code $told: matrig demo; its own message stands above"
}
configured() { # as a crew does before the first landing: place and serial numbers
    at_rest config get -o "$work/read.cfg"
    awk '$1 == "site.name" { $3 = "\"emulated rig\"" } $1 ~ /\.kind$/ { kind = $3 } $1 ~ /\.number$/ { number = $3 }
        $1 ~ /\.serial$/ && (kind == 1 || kind == 2) { $3 = "\"EMU-" (kind == 1 ? "D" : "T") number "\"" } { print }' "$work/read.cfg" >"$work/rig.cfg"
    at_rest config set "$work/rig.cfg"
}
surveyed() { # RUN: a sheet on standard input, filled in with the openings that were read before that landing
    awk -F, -v OFS=, -v run="$1" 'BEGIN { while ((getline line <run) > 0) { split(line, word, " "); if (word[4] == "survey") sum[word[5]] = word[6] } }
        NR > 1 { $4 = 33.5 + sum[$3] } { print }'
}

[ -x "$board" ] || fail 3 "no emulated board: $board; make all builds it, the package matrig-board has it"
[ -r "$image" ] || fail 3 "no firmware image: $image; make all builds it, the package matrig has it"
[ -r "$runs/landing1.run" ] || fail 3 "no recorded landing: $runs/landing1.run; make install puts it there, the package matrig has it"
for file in "$db" "$page"; do [ ! -e "$file" ] || fail 2 "there is one already: $file; name a new folder"; done
mkdir -p "$folder" 2>/dev/null || fail 3 "cannot make the folder: $folder; name another one"
work=$(mktemp -d "${TMPDIR:-/tmp}/matrig-demo.XXXXXX")
: >"$work/log.err"
trap end EXIT
trap 'fail 3 "interrupted: matrig demo; name a new folder to start once more"' INT TERM

echo 'Emulated board, synthetic landings: no hardware and no mat is involved.'
configured
echo '== Landings 1 and 4 of the standard series: 28 ft/s, braked gently'
"$matrig" --quiet landing "$db" --series standard --runway '1/7-scale AM2 mat, synthetic' --pattern standard --modification none >"$work/said"
play 1 "$@"
play 4 "$@"
cp "$work/memory" "$work/surveyed"

echo '== Survey, and advice on landing 5, planned at 35.5 ft/s and 7.8 ft/s2'
"$matrig" --quiet survey "$db" --edges none --sheet "$work/sheet.csv" >"$work/said"
surveyed "$runs/landing5.run" <"$work/sheet.csv" >"$work/read.csv"
"$matrig" --quiet survey "$db" --edges none --error 0.01 --from "$work/read.csv" >"$work/said"
"$matrig" "$@" advise "$db" --speed 35.5ft/s --deceleration 7.8ft/s2 --keep || [ $? = 1 ] || fail 3 'matrig advise failed; its own message stands above'

echo '== Landing 5 as planned, against the advice: braked at 6.6 to 9.2 ft/s2'
play 5 "$@"
echo '== The same landing on the same runway as advised: braked at 6.5 ft/s2'
cp "$work/surveyed" "$work/memory"
play 6 "$@"
echo '== The same landing on the same runway, braked at 8.5 ft/s2 from touchdown on'
cp "$work/surveyed" "$work/memory"
play 7 "$@"

echo '== The last landing against a simulation of the model runway'
"$matrig" "$@" compare "$db" $run
[ $sent = 0 ] || echo "In each landing the emulated rig sent survey, arm, mark and disarm; the campaign records these $sent commands as sent by another program."
"$matrig" "$@" report "$db" -o "$page"
"$matrig" "$@" show "$db" | sed -n '/^The wheel reached a zone/,$p'
echo "Look at $page; the campaign is $db."
