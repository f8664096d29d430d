#!/usr/bin/env bash
# Decoding a candump log, side by side in one run: matrig into memory and into a campaign, can-utils' log2asc, python3-can. Processor
# time of each; three runs, the median counts. The log is landing 5 as the emulated board sends it, several times over.
set -euo pipefail
cd "$(dirname "$0")/../.."
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
times=${1:-40}
TIMEFORMAT='%U %S'
median_of_3() { sort -g | sed -n 2p; }
rate() { # FRAMES COMMAND...: frames a second of processor time
    local frames=$1
    shift
    for _ in 1 2 3; do { time "$@" >/dev/null 2>&1; } 2>&1 | awk -v n="$frames" '{print n / ($1 + $2)}'; done | median_of_3
}
import() { rm -f "$tmp"/c.db*; build/matrig --quiet import "$tmp/c.db" "$tmp/log"; }

build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/can" --rig tests/runs/landing5.run >/dev/null 2>&1
for _ in $(seq "$times"); do cat "$tmp/can"; done >"$tmp/log"
# python3-can takes a hundred times as long: a fortieth of it will do; log2asc refuses a time of 0 s.
cp "$tmp/can" "$tmp/one.log"
sed 's/^(0/(1/' "$tmp/log" >"$tmp/dated"
cat >"$tmp/reader.py" <<'PYTHON'
import can, sys
assert len(list(can.LogReader(sys.argv[1]))) == int(sys.argv[2])
PYTHON
frames=$(wc -l <"$tmp/log") few=$(wc -l <"$tmp/one.log")
/usr/bin/python3 "$tmp/reader.py" "$tmp/one.log" "$few" # it reads all of them, or this ends
log2asc -I "$tmp/dated" can0 | awk '/ Rx +d /{n++} END {exit n < '"$frames"'}'
memory=$(for _ in 1 2 3; do build/tests/exchange/decode "$tmp/log" | awk '{print $3}'; done | median_of_3)
campaign=$(rate "$frames" import)
log2asc=$(rate "$frames" log2asc -I "$tmp/dated" can0)
python=$(rate "$few" /usr/bin/python3 "$tmp/reader.py" "$tmp/one.log" "$few")
echo "a candump log of $frames frames (landing 5, $times times), frames a second of processor time, and relative to log2asc:"
printf '%s %s\n' "into memory, every value" "$memory" "into a campaign" "$campaign" "log2asc" "$log2asc" "python3-can" "$python" |
    awk -v base="$log2asc" '{rate = $NF; $NF = ""; printf "  %-26s %10.0f %9.2f x\n", $0, rate, rate / base}'
echo "  wanted: 2000000 into memory, 500000 into a campaign"
