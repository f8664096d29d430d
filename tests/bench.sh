#!/usr/bin/env bash
# Timings as ratios within one run: virtual time over wall time on the emulated board (three runs each; the median
# counts), then the simulation (tests/bench/). For information: a figure that is missed fails nothing.
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
build/tests/bench/sim_bench
