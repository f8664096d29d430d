#!/bin/sh
# matrig demo: landings 1, 4 and 5 of the standard series, which are synthetic (tests/runs/README.md): two gentle ones, and one that the
# board warns of. Each is played by the emulated board, logged and compared; a page is made of all three.
# demo.sh FOLDER MATRIG BOARD IMAGE RUNS [OPTIONS OF MATRIG...]
set -eu
folder=$1 matrig=$2 board=$3 image=$4 runs=$5
shift 5
db=$folder/campaign.db page=$folder/report.html playing='' logging=''
fail() { # CODE WORDS
    echo "matrig: $2" >&2
    exit "$1"
}
end() {
    for process in $playing $logging; do
        kill "$process" 2>/dev/null || :
        wait "$process" 2>/dev/null || :
    done
    rm -rf "$links"
}

[ -x "$board" ] || fail 3 "no emulated board: $board; make all builds it, the package matrig-board has it"
[ -r "$image" ] || fail 3 "no firmware image: $image; make all builds it, the package matrig has it"
[ -r "$runs/landing1.run" ] || fail 3 "no recorded landing: $runs/landing1.run; make install puts it there, the package matrig has it"
for file in "$db" "$page"; do [ ! -e "$file" ] || fail 2 "there is one already: $file; name a new folder"; done
mkdir -p "$folder" 2>/dev/null || fail 3 "cannot make the folder: $folder; name another one"
links=$(mktemp -d "${TMPDIR:-/tmp}/matrig-demo.XXXXXX")
trap end EXIT
trap 'fail 3 "interrupted: matrig demo; name a new folder to start once more"' INT TERM

run=0
for landing in 1 4 5; do
    run=$((run + 1))
    echo "== Landing $landing of the standard series (synthetic) on the emulated board"
    "$board" --elf "$image" --can "unix:$links/can" --serial "unix:$links/serial" --rig "$runs/landing$landing.run" --speed max &
    playing=$!
    "$matrig" "$@" log --can "unix:$links/can" --serial "unix:$links/serial" --db "$db" &
    logging=$!
    wait "$logging" || fail $? "matrig log ended with exit code $?: matrig demo; its own message stands above"
    logging=''
    wait "$playing" || fail 3 "matrig-board ended with exit code $?: matrig demo; its own message stands above"
    playing=''
    "$matrig" "$@" compare "$db" $run
done
"$matrig" "$@" report "$db" -o "$page"
echo "Look at $page; the campaign is $db."
