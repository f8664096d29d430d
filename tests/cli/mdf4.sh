#!/usr/bin/env bash
# The MDF4 export, read back by a reader that shares nothing with the writer (tests/exchange/mdf4_read.py) and held against the CSV
# and candump exports and the DBC file.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
elf=build/firmware/matrig.elf
db=$tmp/campaign.db
file=$tmp/landing5.mf4
read_mdf4() { tests/exchange/mdf4_read.py "$file" "$@"; }

played --elf $elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run >/dev/null
build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >/dev/null

e() { build/matrig export "$db" 1 --format "$1" -o "$2"; }
every_block_is_in_place() { e mdf4 "$file" && read_mdf4 blocks; }
readings_are_the_csv() { e csv "$tmp/run.csv" && read_mdf4 readings "$tmp/run.csv"; }
units_are_told() { build/matrig --si export "$db" 1 --format mdf4 -o "$tmp/si.mf4" && read_mdf4 units "$tmp/si.mf4"; }
frames_are_the_candump() { e candump "$tmp/export.log" && read_mdf4 frames "$tmp/export.log"; }
dbc_is_attached() { build/matrig export --format dbc -o "$tmp/our.dbc" && read_mdf4 dbc "$tmp/our.dbc"; }
# One byte turned in any block's head or length is found: the reader's checks can fail.
reader_finds_damage() {
    local at
    for at in 65 72 80 88; do
        cp "$file" "$tmp/damaged.mf4"
        printf '\377' | dd of="$tmp/damaged.mf4" bs=1 seek=$at conv=notrunc status=none
        ! tests/exchange/mdf4_read.py "$tmp/damaged.mf4" blocks 2>/dev/null >&2 || return 1
    done
    head -c 100000 "$file" >"$tmp/damaged.mf4"
    ! tests/exchange/mdf4_read.py "$tmp/damaged.mf4" blocks 2>/dev/null >&2
}
nothing_to_export_is_said() {
    build/matrig --quiet bundle "$db" 1 -o "$tmp/empty.db" && sqlite3 "$tmp/empty.db" 'delete from frames; delete from blocks' &&
        fails_with 2 'nothing to export: RUN 1' build/matrig export "$tmp/empty.db" 1 --format mdf4 -o "$tmp/empty.mf4"
}

check "every byte is in a block, every block is linked" every_block_is_in_place
check "readings are the CSV export's" readings_are_the_csv
check "units are told, SI on request" units_are_told
check "CAN frames are the candump export's" frames_are_the_candump
check "the DBC is attached, its MD5 right" dbc_is_attached
check "second 0 is a time of day" read_mdf4 start "$tmp/can"
check "the reader finds damage" reader_finds_damage
check "a landing with nothing in it is refused" nothing_to_export_is_said
finish
