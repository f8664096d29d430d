#!/usr/bin/env bash
# `make golden`: keep what today's image says as a new version of each golden landing whose answers differ. `make golden FIRST=1`: record
# all three anew, as version 1, from tests/runs; for when nothing has been relied on yet.
set -eu -o pipefail
cd "$(dirname "$0")/../.."
scratch=$(mktemp -d /tmp/matrig-golden.XXXXXX)
trap 'rm -rf "$scratch"' EXIT
. tests/golden/landing.sh
elf=build/firmware/matrig.elf

record_first() { # LANDING: a run, logged; a replay of it must say the same
    build/matrig-board --elf $elf --rig "tests/runs/landing$1.run" --seed "1$1" --can "file:$scratch/run.can" --serial "file:$scratch/run.serial" 2>"$scratch/board"
    build/matrig --quiet log --can "file:$scratch/run.can" --serial "file:$scratch/run.serial" --db "$scratch/$1.db" >/dev/null
    build/matrig --quiet replay "$scratch/$1.db" 1 --exact >"$scratch/replay" || { cat "$scratch/replay"; echo "landing $1: its replay says something else; nothing is recorded" >&2; exit 1; }
    rm -f "$golden_dir/landing$1".v*.gz
    $golden given "$scratch/$1.db" 1 "$scratch/given.txt" "$golden_dir/landing$1.v1.given.gz"
    cp "$golden_dir/landing$1.v1.given.gz" "$scratch/given.gz"
    touch "$golden_dir/landing$1.v1.said.gz" # play asks for the newest version
    play "$1" $elf "$scratch/said.gz"
    cp "$scratch/said.gz" "$golden_dir/landing$1.v1.said.gz"
    sed -i "/^landing$1\./d" "$golden_dir/CHANGES"
    echo "$golden_dir/landing$1.v1: recorded"
}

new=0
for landing in 1 4 5; do
    if [ -n "${FIRST:-}" ]; then
        record_first $landing && new=1
    else
        play $landing $elf "$scratch/said.gz"
        new_version $landing "$scratch/said.gz" && new=1
    fi
done
[ $new = 1 ] || { echo "nothing differs: no golden landing has a new version" >&2; exit 1; }
