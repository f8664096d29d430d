#!/usr/bin/env bash
# One rule for every file that matrig writes: it takes the place of a file only while its content is what matrig wrote there, or with
# --force; never of a database or of what is read. A file appears whole or not at all.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
short=$(mktemp -d /tmp/matrig.XXXXXX) # the project by a path without blanks
trap 'rm -rf "$short"' EXIT
ln -s "$PWD" "$short/top"
top=$short/top
matrig=$top/build/matrig
export XDG_STATE_HOME=$top/$tmp/state
db=$tmp/campaign.db

played --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --rig tests/runs/landing5.run >/dev/null 2>&1
$matrig --quiet log --can "file:$tmp/can.log" --db "$db" >/dev/null
printf 'in,codes\n0,62.1\n0.5,372.4\n1,682.6\n0.5,372.3\n0,62.0\n' >"$tmp/d3.csv"
cat >"$tmp/sweep.json" <<JSON
{"base": "$top/host/scenes/wave.json", "vary": {"f": [0.5, 0.6]}, "outputs": ["status"]}
JSON
cp tests/runs/README.md "$tmp/mine"
echo "{\"pull\": {\"weight_lb\": 160, \"pull_lb\": 80}}" >"$tmp/readings.json"

# ---- every output: what matrig wrote is written over; what a hand changed, or made, is not, and with --force it is ----

quiet() { timeout 120 "$@" >"$tmp/said" 2>"$tmp/err" </dev/null; }
refused() { # COMMAND...: exit 2, and one line that names the way out
    quiet "$@"
    local status=$?
    cat "$tmp/err"
    [ $status -eq 2 ] && [ "$(wc -l <"$tmp/err")" -eq 1 ] && grep -q 'is there already.*--force' "$tmp/err"
}
follows() { # FILE COMMAND...: the command writes FILE
    local file=$1
    shift
    rm -rf "$file"
    quiet "$@" && [ -s "$file" ] || { echo "does not write $file"; cat "$tmp/err"; return 1; }
    quiet "$@" || { echo "not twice"; cat "$tmp/err"; return 1; }
    printf '\n' >>"$file" && cp "$file" "$tmp/changed" # a hand's
    refused "$@" && cmp "$file" "$tmp/changed" && grep -q 'was changed since matrig wrote it' "$tmp/err" || return 1
    quiet "$@" --force && ! cmp -s "$file" "$tmp/changed" || { echo "not by force"; cat "$tmp/err"; return 1; }
    quiet "$@" || { echo "not after force"; return 1; }
    cp "$tmp/mine" "$tmp/another" && mv "$tmp/another" "$file" # another file of this name
    refused "$@" && cmp "$file" "$tmp/mine" && quiet "$@" --force && ! cmp -s "$file" "$tmp/mine"
}

while read -r file command; do
    # shellcheck disable=SC2086
    check "${command%% *}${command#"${command%% -*}"}" follows "$tmp/$file" $matrig $command
done <<EOL
report.html report $db -o $tmp/report.html
one.html report $db --run 1 -o $tmp/one.html
campaign.html report $db
run.csv export $db 1 --format csv -o $tmp/run.csv
run.log export $db 1 --format candump -o $tmp/run.log
run.mf4 export $db 1 --format mdf4 -o $tmp/run.mf4
matrig.dbc export --format dbc -o $tmp/matrig.dbc
sheet.csv survey $db --edges none --sheet $tmp/sheet.csv
sim.csv sim host/scenes/wave.json --csv $tmp/sim.csv
flat.svg error host/scenes/friction_block.json --plot $tmp/flat.svg
prototype.json scale host/scenes/wave.json -o $tmp/prototype.json
params.json params $tmp/readings.json -o $tmp/params.json
compare.svg compare $db 1 --plot $tmp/compare.svg
compare.csv compare $db 1 -o $tmp/compare.csv
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
check "board config get -o" follows "$tmp/rig.cfg" bash "$tmp/board.sh" config get -o "$tmp/rig.cfg"
check "board runway -o" follows "$tmp/before.txt" bash "$tmp/board.sh" runway -o "$tmp/before.txt"
check "board slow --csv" follows "$tmp/slow.csv" bash "$tmp/board.sh" slow --csv "$tmp/slow.csv"
check "calibrate -o" follows "$tmp/new.cfg" $matrig calibrate d3 --points "$tmp/d3.csv" --config "$tmp/rig.cfg" -o "$tmp/new.cfg"
check "log --page" follows "$tmp/quick.html" $matrig log --can "file:$tmp/can.log" --db "$tmp/logged.db" --page "$tmp/quick.html"

# ---- how it is known ----

csv=$tmp/sim.csv
sim=("$matrig" --quiet sim host/scenes/wave.json --csv)
touched() { "${sim[@]}" "$csv" --force >/dev/null && touch "$csv" && chmod 600 "$csv" && quiet "${sim[@]}" "$csv" && [ "$(stat -c %a "$csv")" = 600 ]; }
check "one that was touched only is still matrig's; its mode stays" touched
copied() {
    cp "$csv" "$tmp/copy.csv" && refused "${sim[@]}" "$tmp/copy.csv" && grep -q 'nothing says that matrig wrote it' "$tmp/err" && cp -a "$csv" "$tmp/copy2.csv" && refused "${sim[@]}" "$tmp/copy2.csv"
}
check "a copy that somebody made to keep is not" copied
renamed() { mv "$csv" "$tmp/kept.csv" && refused "${sim[@]}" "$tmp/kept.csv" && cmp -s "$tmp/kept.csv" "$tmp/copy.csv"; }
check "neither is one that was renamed" renamed
moved() { mkdir -p "$tmp/a folder" && "${sim[@]}" "$tmp/a folder/x.csv" >/dev/null && mv "$tmp/a folder" "$tmp/another folder" && quiet "${sim[@]}" "$tmp/another folder/x.csv"; }
back() { "${sim[@]}" "$csv" >/dev/null && cp "$csv" "$tmp/was" && echo >>"$csv" && refused "${sim[@]}" "$csv" && cat "$tmp/was" >"$csv" && quiet "${sim[@]}" "$csv"; }
check "one whose change was taken back is" back
empty() { : >"$tmp/empty.csv" && quiet "${sim[@]}" "$tmp/empty.csv" && [ -s "$tmp/empty.csv" ]; }
check "an empty file is nobody's: mktemp's" empty
longer() { head -c 3000000 /dev/zero >"$tmp/long" && refused "${sim[@]}" "$tmp/long" && [ "$(stat -c %s "$tmp/long")" = 3000000 ]; }
check "a long one" longer

if python3 -c "import os, sys; os.setxattr('$csv', 'user.matrig.test', b'1')" 2>/dev/null; then
    check "in a folder that was moved all is as it was" moved
    no_home() { ( unset HOME XDG_STATE_HOME; rm -f "$tmp/home.csv"; quiet "${sim[@]}" "$tmp/home.csv" && quiet "${sim[@]}" "$tmp/home.csv" && echo >>"$tmp/home.csv" && refused "${sim[@]}" "$tmp/home.csv" ); }
    check "without a home folder as well" no_home
else
    check "in a folder that was moved all is as it was # SKIP no extended attributes here" true
    check "without a home folder as well # SKIP no extended attributes here" true
fi

# A file system without extended attributes is played by a library that has none.
cat >"$tmp/none.c" <<'C'
#include <errno.h>
#include <sys/types.h>
int fsetxattr(int fd, const char *name, const void *value, size_t size, int flags) { (void)fd, (void)name, (void)value, (void)size, (void)flags; errno = ENOTSUP; return -1; }
ssize_t fgetxattr(int fd, const char *name, void *value, size_t size) { (void)fd, (void)name, (void)value, (void)size; errno = ENOTSUP; return -1; }
C
cc -shared -fPIC -o "$tmp/none.so" "$tmp/none.c"
bare=(env "LD_PRELOAD=$top/$tmp/none.so")
recorded() {
    rm -f "$tmp/bare.csv" && quiet "${bare[@]}" "$matrig" --quiet sim host/scenes/wave.json --csv "$tmp/bare.csv" && quiet "${bare[@]}" "$matrig" sim host/scenes/wave.json --csv "$tmp/bare.csv" &&
        (cd / && sha256sum -c "$XDG_STATE_HOME"/matrig/written/*) && echo >>"$tmp/bare.csv" && refused "${bare[@]}" "$matrig" sim host/scenes/wave.json --csv "$tmp/bare.csv"
}
check "without extended attributes the state folder says it, in sha256sum's words" recorded
nowhere() { # neither: the safe answer, and what helps
    mkdir -p "$tmp/readonly" && rm -f "$tmp/nowhere.csv"
    local home
    for home in "" /proc; do
        quiet "${bare[@]}" env -u XDG_STATE_HOME HOME="$home" "$matrig" --quiet sim host/scenes/wave.json --csv "$tmp/nowhere.csv" --force && [ -s "$tmp/nowhere.csv" ] || return 1
        refused "${bare[@]}" env -u XDG_STATE_HOME HOME="$home" "$matrig" --quiet sim host/scenes/wave.json --csv "$tmp/nowhere.csv" || return 1
    done
}
check "without them, and without a home that can be written: not overwritten, with --force it is" nowhere

# ---- whole or not at all ----

linked() {
    mkdir -p "$tmp/far" && rm -f "$tmp/far/real.csv" "$tmp/link.csv" && ln -s far/real.csv "$tmp/link.csv" && quiet "${sim[@]}" "$tmp/link.csv" && [ -L "$tmp/link.csv" ] && [ -s "$tmp/far/real.csv" ] &&
        quiet "${sim[@]}" "$tmp/link.csv" && [ -L "$tmp/link.csv" ] && echo >>"$tmp/far/real.csv" && refused "${sim[@]}" "$tmp/link.csv"
}
check "a symbolic link is followed, and stays" linked
input() { # by each of its names
    cp host/scenes/wave.json "$tmp/scene.json" && ln -sf scene.json "$tmp/scene.link" && ln -f "$tmp/scene.json" "$tmp/scene.hard" || return 1
    for other in scene.json scene.link scene.hard; do
        fails_with 2 'would overwrite what is read' $matrig sim "$tmp/scene.json" --csv "$tmp/$other" --force || return 1
    done
    cmp "$tmp/scene.json" host/scenes/wave.json
}
check "what is read is not written over, by force neither" input
database() {
    local before
    before=$(sha256sum <"$db")
    cp "$db" "$tmp/other.db"
    for other in campaign.db other.db; do
        fails_with 2 'would overwrite' $matrig report "$db" -o "$tmp/$other" --force && fails_with 2 'is there already' $matrig bundle "$db" 1 -o "$tmp/$other" || return 1
    done
    [ "$before" = "$(sha256sum <"$db")" ] && [ "$before" = "$(sha256sum <"$tmp/other.db")" ]
}
check "a campaign is not, by force neither" database
# A program that dies leaves what it committed in the -wal alone, as the log of a computer that loses its power does.
dies() {
    python3 - "$1" <<'P'
import os, sqlite3, sys
db = sqlite3.connect(sys.argv[1])
db.execute("pragma journal_mode=wal")
db.execute("pragma wal_autocheckpoint=0")
db.execute("create table kept(x)")
db.execute("insert into kept values(42)")
db.commit()
os._exit(0)
P
}
own='would overwrite a part of a database'
journals() { # there or not, by any name of theirs
    local tail other
    mkdir -p "$tmp/own/sub" && cp "$db" "$tmp/own/c.db" && ln -sfn own "$tmp/own.link" || return 1
    for tail in -wal -shm -journal; do
        ln -sf "own/c.db$tail" "$tmp/dangling$tail" && ln -sf "dangling$tail" "$tmp/twice$tail" || return 1
        for other in "own/c.db$tail" "own/sub/../c.db$tail" "own.link/c.db$tail" "dangling$tail" "twice$tail"; do
            fails_with 2 "$own, .*c\.db: .*$other; give another file" $matrig export "$db" 1 --format csv -o "$tmp/$other" --force &&
                fails_with 2 "$own" $matrig export --format dbc -o "$tmp/$other" && fails_with 2 "$own" $matrig bundle "$db" 1 -o "$tmp/$other" &&
                fails_with 2 "$own" $matrig sim host/scenes/wave.json --csv "$tmp/$other" --force &&
                fails_with 2 "$own" $matrig sweep "$tmp/sweep.json" --cases 1 -o "$tmp/$other" &&
                fails_with 2 "$own" $matrig import "$tmp/$other" "$tmp/can.log" || return 1
        done
    done
    [ "$(ls "$tmp/own")" = "$(printf 'c.db\nsub')" ] && cmp "$db" "$tmp/own/c.db" || return 1
    : >"$tmp/own/c.db" && fails_with 2 "$own" $matrig export --format dbc -o "$tmp/own/c.db-journal" || return 1 # a database that is being made
    echo text >"$tmp/own/text" && quiet $matrig export --format dbc -o "$tmp/own/text-wal" && quiet $matrig export --format dbc -o "$tmp/own/none-wal" # no database has them
}
check "what SQLite keeps beside a campaign is not, by force neither" journals
committed() { # by a name that does not say so, or when the campaign was moved away
    local other
    mkdir -p "$tmp/died" && cp "$db" "$tmp/died/c.db" && dies "$tmp/died/c.db" && [ -s "$tmp/died/c.db-wal" ] && ln -f "$tmp/died/c.db-wal" "$tmp/died/hard" || return 1
    for other in c.db-wal c.db-shm hard; do
        fails_with 2 "$own" $matrig report "$db" -o "$tmp/died/$other" --force || return 1
    done
    mv "$tmp/died/c.db" "$tmp/died/moved.db" && fails_with 2 "$own" $matrig report "$db" -o "$tmp/died/c.db-wal" --force || return 1
    mv "$tmp/died/moved.db" "$tmp/died/c.db" && [ "$(sqlite3 "$tmp/died/c.db" 'select x from kept')" = 42 ]
}
check "nor is what was committed and stands there alone" committed
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
        $matrig export --format dbc -o /dev/fd/7 7>"$tmp/dbc4" && cmp "$tmp/dbc" "$tmp/dbc4" && $matrig export --format dbc -o >(cat >"$tmp/dbc5"; : >"$tmp/dbc5.done") &&
        $matrig export --format dbc -o /dev/null && $matrig survey "$db" --sheet - | grep -q . || return 1
    await test -e "$tmp/dbc5.done"
    cmp "$tmp/dbc" "$tmp/dbc5" && [ -c /dev/null ] && fails_with 3 'cannot write .No space' $matrig export --format dbc -o /dev/full
}
check "standard output, a descriptor, a pipe, a device" streams
fifo() {
    rm -f "$tmp/fifo" && mkfifo "$tmp/fifo" || return 1
    timeout 20 cat "$tmp/fifo" >"$tmp/dbc6" &
    local reader=$!
    timeout 20 $matrig export --format dbc -o "$tmp/fifo" && wait "$reader" && [ -p "$tmp/fifo" ] && cmp "$tmp/dbc" "$tmp/dbc6"
}
check "a named pipe" fifo
finish
