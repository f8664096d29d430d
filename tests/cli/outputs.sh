#!/usr/bin/env bash
# What matrig can make again replaces a file; what people fill in does so only with --force; a database and what is read are never replaced. A
# file appears whole or not at all.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
short=$(mktemp -d /tmp/matrig.XXXXXX) # the project by a path without blanks
trap 'rm -rf "$short"' EXIT
ln -s "$PWD" "$short/top"
top=$short/top
matrig=$top/build/matrig
db=$tmp/campaign.db

played --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --rig tests/runs/landing5.run >/dev/null 2>&1
$matrig --quiet log --can "file:$tmp/can.log" --db "$db" >/dev/null
printf 'in,codes\n0,62.1\n0.5,372.4\n1,682.6\n0.5,372.3\n0,62.0\n' >"$tmp/d3.csv"
cat >"$tmp/sweep.json" <<JSON
{"base": "$top/host/scenes/wave.json", "vary": {"f": [0.5, 0.6]}, "outputs": ["status"]}
JSON
cp tests/runs/README.md "$tmp/mine"
echo "{\"pull\": {\"weight_lb\": 160, \"pull_lb\": 80}}" >"$tmp/readings.json"

# ---- every output ----

quiet() { timeout 600 "$@" >"$tmp/said" 2>"$tmp/err" </dev/null; }
refused() { # COMMAND...: exit 2, and one line that names the way out
    quiet "$@"
    local status=$?
    cat "$tmp/err"
    [ $status -eq 2 ] && [ "$(wc -l <"$tmp/err")" -eq 1 ] && grep -q 'exists already: .*--force' "$tmp/err"
}
replaces() { # FILE COMMAND...: the command writes FILE, also over another file
    cp "$tmp/mine" "$1"
    quiet "${@:2}" && [ -s "$1" ] && ! cmp -s "$1" "$tmp/mine" || { cat "$tmp/err"; return 1; }
}
keeps() { # FILE COMMAND...: the command writes FILE, and over another file only with --force
    rm -rf "$1"
    quiet "${@:2}" && [ -s "$1" ] && cp "$tmp/mine" "$1" && refused "${@:2}" && cmp "$1" "$tmp/mine" || { cat "$tmp/err"; return 1; }
    quiet "${@:2}" --force && ! cmp -s "$1" "$tmp/mine"
}

while read -r how file command; do
    # shellcheck disable=SC2086
    check "${command%% *}${command#"${command%% -*}"}" $how "$tmp/$file" $matrig $command
done <<EOL
replaces report.html report $db -o $tmp/report.html
replaces one.html report $db --run 1 -o $tmp/one.html
replaces campaign.html report $db
replaces run.csv export $db 1 --format csv -o $tmp/run.csv
replaces run.log export $db 1 --format candump -o $tmp/run.log
replaces run.mf4 export $db 1 --format mdf4 -o $tmp/run.mf4
replaces matrig.dbc export --format dbc -o $tmp/matrig.dbc
keeps sheet.csv survey $db --edges none --sheet $tmp/sheet.csv
replaces sim.csv sim host/scenes/wave.json --csv $tmp/sim.csv
replaces flat.svg error tests/sim_reference/scenes/report_frictionless.json --plot $tmp/flat.svg
keeps prototype.json scale host/scenes/wave.json -o $tmp/prototype.json
keeps params.json params $tmp/readings.json -o $tmp/params.json
replaces compare.csv compare $db 1 -o $tmp/compare.csv
EOL

# a board's: the refusal comes before it is asked
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$short" "$sockets"' EXIT
cat >"$tmp/board.sh" <<SH
#!/usr/bin/env bash
build/matrig-board --elf build/firmware/matrig.elf --serial "unix:$sockets/serial" --for 20 >"$tmp/board.out" 2>&1 &
board=\$!
$matrig board --serial "unix:$sockets/serial" "\$@"
status=\$?
kill \$board
wait \$board
exit \$status
SH
check "board config get -o" keeps "$tmp/rig.cfg" bash "$tmp/board.sh" config get -o "$tmp/rig.cfg"
check "board runway -o" keeps "$tmp/before.txt" bash "$tmp/board.sh" runway -o "$tmp/before.txt"
check "calibrate -o" keeps "$tmp/new.cfg" $matrig calibrate d3 --points "$tmp/d3.csv" --config "$tmp/rig.cfg" -o "$tmp/new.cfg"
check "log --page" replaces "$tmp/quick.html" $matrig log --can "file:$tmp/can.log" --db "$tmp/logged.db" --page "$tmp/quick.html"

csv=$tmp/sim.csv
sim=("$matrig" --quiet sim host/scenes/wave.json --csv)
mode_stays() { chmod 600 "$csv" && quiet "${sim[@]}" "$csv" && [ "$(stat -c %a "$csv")" = 600 ]; }
check "the mode of a file that is replaced stays" mode_stays

# ---- whole or not at all ----

linked() {
    mkdir -p "$tmp/far" && rm -f "$tmp/link.csv" && : >"$tmp/far/real.csv" && ln -s far/real.csv "$tmp/link.csv" && quiet "${sim[@]}" "$tmp/link.csv" && [ -L "$tmp/link.csv" ] && [ -s "$tmp/far/real.csv" ] &&
        quiet "${sim[@]}" "$tmp/link.csv" && [ -L "$tmp/link.csv" ]
}
check "a symbolic link is followed, and stays" linked
input() { # by each of its names
    cp host/scenes/wave.json "$tmp/scene.copy" && ln -sf scene.copy "$tmp/scene.link" && ln -f "$tmp/scene.copy" "$tmp/scene.hard" || return 1
    for other in scene.copy scene.link scene.hard; do
        fails_with 2 'would overwrite the input' $matrig sim "$tmp/scene.copy" --csv "$tmp/$other" || return 1
    done
    cmp "$tmp/scene.copy" host/scenes/wave.json
}
check "what is read is not written over" input
database() {
    local before
    before=$(sha256sum <"$db")
    cp "$db" "$tmp/other.db"
    for other in campaign.db other.db; do
        fails_with 2 'would overwrite' $matrig report "$db" -o "$tmp/$other" && fails_with 2 'file exists already' $matrig bundle "$db" 1 -o "$tmp/$other" || return 1
    done
    [ "$before" = "$(sha256sum <"$db")" ] && [ "$before" = "$(sha256sum <"$tmp/other.db")" ]
}
check "a campaign is not, by force neither" database
full() { # the disk is full: the old file stays, and nothing is left beside it
    rm -rf "$tmp/small" && mkdir -p "$tmp/small" && "${sim[@]}" "$tmp/small/a.csv" >/dev/null && cp "$tmp/small/a.csv" "$tmp/was" &&
        (ulimit -f 1; trap '' XFSZ; fails_with 3 'cannot write .*a\.csv' "$matrig" --quiet sim host/scenes/wave.json --csv "$tmp/small/a.csv") && cmp "$tmp/was" "$tmp/small/a.csv" && [ "$(ls -A "$tmp/small")" = a.csv ]
}
check "no room: the old file stays, nothing is left" full
race() { # eight at once, while a reader looks: whole, each time
    rm -f "$tmp/race.csv"
    local pids=() i
    for i in 1 2 3 4 5 6 7 8; do
        "${sim[@]}" "$tmp/race.csv" >/dev/null 2>>"$tmp/race.err" &
        pids+=($!)
    done
    for i in "${pids[@]}"; do wait "$i" || { cat "$tmp/race.err"; return 1; }; done
    cmp "$tmp/race.csv" "$tmp/was" && quiet "${sim[@]}" "$tmp/race.csv" && [ -z "$(find "$tmp" -maxdepth 1 -name '.matrig-*')" ]
}
check "eight at once to the same file are no harm" race
gone() { rm -rf "$tmp/no such" && fails_with 3 'cannot write .No such file.*no such/x' "$matrig" sim host/scenes/wave.json --csv "$tmp/no such/x" && fails_with 3 'cannot write .Is a directory' "$matrig" export --format dbc -o "$tmp"; }
check "a folder that is not there, and one in place of a file" gone

# ---- pipes and devices ----

streams() {
    $matrig export --format dbc >"$tmp/dbc" && $matrig export --format dbc -o /dev/stdout | cmp - "$tmp/dbc" && $matrig export --format dbc -o /dev/stdout >"$tmp/dbc2" && cmp "$tmp/dbc" "$tmp/dbc2" &&
        { echo head; $matrig export --format dbc -o /dev/stdout; echo tail; } >"$tmp/dbc3" && { echo head; cat "$tmp/dbc"; echo tail; } | cmp - "$tmp/dbc3" &&
        $matrig export --format dbc -o >(cat >"$tmp/dbc5"; : >"$tmp/dbc5.done") &&
        $matrig export --format dbc -o /dev/null && $matrig survey "$db" --sheet - | grep -q . || return 1
    await test -e "$tmp/dbc5.done"
    cmp "$tmp/dbc" "$tmp/dbc5" && [ -c /dev/null ] && fails_with 3 'cannot write .No space' $matrig export --format dbc -o /dev/full
}
check "standard output, a pipe, a device" streams
fifo() {
    rm -f "$tmp/fifo" && mkfifo "$tmp/fifo" || return 1
    timeout 600 cat "$tmp/fifo" >"$tmp/dbc6" &
    local reader=$!
    timeout 600 $matrig export --format dbc -o "$tmp/fifo" && wait "$reader" && [ -p "$tmp/fifo" ] && cmp "$tmp/dbc" "$tmp/dbc6"
}
check "a named pipe" fifo
finish
