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

# Blocks of the layout alone, each reached by a link of the right kind; both tables, the DBC.
every_block_is_in_place() {
    build/matrig export "$db" 1 --format mdf4 -o "$file" && read_mdf4 blocks >"$tmp/blocks" && cat "$tmp/blocks" &&
        grep -q '^DG 2$' "$tmp/blocks" && grep -q '^AT 1$' "$tmp/blocks" && grep -q '^HD 1$' "$tmp/blocks"
}
# Each cell is the CSV export's: displacements to its 5 digits, tensions to 3; what is empty there is marked invalid here.
readings_are_the_csv() {
    build/matrig export "$db" 1 --format csv -o "$tmp/run.csv" && read_mdf4 table readings >"$tmp/mdf.csv" || return 1
    python3 - "$tmp/run.csv" "$tmp/mdf.csv" <<'PYTHON'
import csv, sys
with open(sys.argv[1]) as f:
    ours = list(csv.DictReader(line for line in f if not line.startswith("#")))
with open(sys.argv[2]) as f:
    mdf = list(csv.DictReader(f))
names = {"t_s": "since_touchdown", "gear_ft": "gear_station", "speed_ft_s": "gear_speed"}
names |= {f"d{i}_in": f"displacement_{i}" for i in range(1, 9)} | {f"t{i}_lb": f"tension_{i}" for i in range(1, 15)}
assert len(ours) == len(mdf) > 7000, (len(ours), len(mdf))
filled = empty = 0
for a, b in zip(ours, mdf):
    for name, column in names.items():
        digits = len(a[name].split(".")[1]) if a[name] else 0
        assert (a[name] == "") == (b[column] == ""), (name, a[name], b[column])
        if a[name]:
            filled += 1
            assert abs(float(a[name]) - float(b[column])) <= 0.5001 * 10 ** -digits + 1e-6 * abs(float(a[name])), (name, a[name], b[column])
        else:
            empty += 1
step = {round(float(q["time"]) - float(p["time"]), 9) for p, q in zip(mdf, mdf[1:])}
print(filled, "cells equal,", empty, "empty in both, steps", step)
assert filled > 100000 and empty > 0 and step == {0.001}
PYTHON
}
units_are_told() {
    read_mdf4 units readings >"$tmp/units" && build/matrig --si export "$db" 1 --format mdf4 -o "$tmp/si.mf4" &&
        tests/exchange/mdf4_read.py "$tmp/si.mf4" units readings >"$tmp/units-si" && paste "$tmp/units" "$tmp/units-si" &&
        grep -qx 'time,s' "$tmp/units" && grep -qx 'displacement_8,in' "$tmp/units" && grep -qx 'tension_14,lb' "$tmp/units" &&
        grep -qx 'gear_speed,ft/s' "$tmp/units" && grep -qx 'displacement_8,mm' "$tmp/units-si" && grep -qx 'tension_14,N' "$tmp/units-si"
}
# Frame by frame; times as candump has them but for where they begin.
frames_are_the_candump() {
    build/matrig export "$db" 1 --format candump -o "$tmp/export.log" && read_mdf4 candump 1000000000 >"$tmp/mdf.log" || return 1
    [ "$(wc -l <"$tmp/mdf.log")" -gt 20000 ] && cmp <(awk '{print $3}' "$tmp/export.log") <(awk '{print $3}' "$tmp/mdf.log") || return 1
    paste <(tr -d '()' <"$tmp/export.log" | awk '{print $1}') <(tr -d '()' <"$tmp/mdf.log" | awk '{print $1}') |
        awk 'NR == 1 {o = $1 - $2} {d = $1 - $2 - o; if (d < 0) d = -d; if (d > worst) worst = d}
             END {printf "worst time difference %.6f s\n", worst; exit worst > 0.0000021}'
}
dbc_is_attached() {
    read_mdf4 attachment matrig.dbc | cmp - <(build/matrig export --format dbc)
}
# By its time of day each frame lies where the candump log has it, which is when it was received: up to 2 ms after board time.
start_is_the_time_of_day() {
    read_mdf4 candump 0 >"$tmp/relative.log" || return 1
    local first
    first=$(head -n 1 "$tmp/relative.log" | awk '{print $3}')
    grep -n " $first\$" "$tmp/can" | head -n 1
    awk -v start="$(read_mdf4 start)" -v first="$first" '
        {gsub(/[()]/, "", $1)}
        NR == FNR {if (FNR == 1) at = $1; next}
        $3 == first && !done {late = $1 - (start / 1e9 + at); done = 1}
        END {printf "received %.6f s after its time of day\n", late; exit !(done && late > -0.002 && late < 0.002)}' "$tmp/relative.log" "$tmp/can"
}
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
check "second 0 is a time of day" start_is_the_time_of_day
check "the reader finds damage" reader_finds_damage
check "a landing with nothing in it is refused" nothing_to_export_is_said
finish
