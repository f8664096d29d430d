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
# Others' frames, put into the log behind its 9000th: none becomes a data frame of 11 bits.
foreign_frames_keep_their_kind() {
    awk '{print} NR == 9000 {n = split("00000123#EE 18FF50E5#A1A2A3A4A5A6A7A8 124#R4 0CF00400#R8 20000040# 20000080#0000000000000000 20000020# 20000088#0000020000000000 20000008#0000040A00000000 20000008#0000000800000000 20000008#0000100000000000", f, " "); for (i = 1; i <= n; i++) print $1, $2, f[i]}' "$tmp/can" >"$tmp/mixed.log"
    build/matrig --quiet import "$tmp/mixed.db" "$tmp/mixed.log" >/dev/null && build/matrig --quiet export "$tmp/mixed.db" 1 --format mdf4 -o "$tmp/mixed.mf4" &&
        build/matrig --quiet export "$tmp/mixed.db" 1 --format candump -o "$tmp/mixed.out" && tests/exchange/mdf4_read.py "$tmp/mixed.mf4" foreign "$tmp/mixed.out"
}
# A date where the campaign knows the board's clock, as the candump export has it; else none, and that is told.
a_date_stands_where_the_clock_is_known() {
    build/matrig export "$db" 1 --format mdf4 -o "$tmp/no.mf4" 2>"$tmp/err" && grep -q 'the time of day is unknown, so the file begins in 1970; [a-z]' "$tmp/err" &&
        tests/exchange/mdf4_read.py "$tmp/no.mf4" undated || { cat "$tmp/err"; return 1; }
    sqlite3 "$db" "vacuum into '$tmp/dated.db'" && sqlite3 "$tmp/dated.db" "delete from time_maps; insert into time_maps(session, boot, link, landing, refusal, pairs,
        from_us, to_us, spread_us, fast_ppm, fast_half_ppm, board_us, host_us, host_half_us) select session, boot, 0, 1, 0, 60, 0, 9000000, 50, 25, 0.1, 4000000,
        1764000000123456, 30 from landings where id = 1" && build/matrig export "$tmp/dated.db" 1 --format candump -o "$tmp/dated.log" || return 1
    build/matrig export "$tmp/dated.db" 1 --format mdf4 -o "$tmp/dated.mf4" 2>"$tmp/err" && [ ! -s "$tmp/err" ] && tests/exchange/mdf4_read.py "$tmp/dated.mf4" start "$tmp/dated.log"
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
check "others' frames keep their kind" foreign_frames_keep_their_kind
check "second 0 is a time of day, or has none" a_date_stands_where_the_clock_is_known
check "the reader finds damage" reader_finds_damage
check "a landing with nothing in it is refused" nothing_to_export_is_said
finish
