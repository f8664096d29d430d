#!/usr/bin/env bash
# Timings as ratios within one run: virtual time over wall time on the emulated board, board time over run time of the
# simulation. Three runs each; the median counts.
set -euo pipefail
cd "$(dirname "$0")/.."
tmp=build/test-tmp/bench
mkdir -p "$tmp"

median_of_3() { sort -n | sed -n 2p; }
board_ratio() { # EXTRA ARGUMENTS...
    for _ in 1 2 3; do
        build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" "$@" 2>&1 |
            sed -n 's/.*(\([0-9.]*\) x).*/\1/p'
    done | median_of_3
}

echo "emulated board, virtual over wall time:"
printf '  landing %s          %6.1f x (wanted: 5)\n' 1 "$(board_ratio --rig tests/runs/landing1.run)"
printf '  landing %s          %6.1f x (wanted: 5)\n' 5 "$(board_ratio --rig tests/runs/landing5.run)"
printf '  idle, disarmed     %6.1f x\n' "$(board_ratio --for 20)"
echo "simulation, chain of 420 mats, one landing:"
for _ in 1 2 3; do
    build/matrig --json sim host/scenes/model_runway.json | sed -n 's/.*"run_ms": *\([0-9.]*\).*"t_end_s": *\([0-9.]*\).*/\1 \2/p; s/.*"t_end_s": *\([0-9.]*\).*"run_ms": *\([0-9.]*\).*/\2 \1/p'
done | sort -n | sed -n 2p | awk '{printf "  %.0f ms for %.2f s of landing: %.0f x real time\n", $1, $2, 1000 * $2 / $1}'
