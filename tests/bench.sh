#!/usr/bin/env bash
# Timings as ratios within one run: virtual time over processor time on the emulated board (one thread: the same as wall
# time when nothing else runs; three runs each, the median counts), then how often the fit's intervals hold. For information: a
# figure that is missed fails nothing.
set -euo pipefail
cd "$(dirname "$0")/.."
tmp=build/test-tmp/bench
mkdir -p "$tmp"

median_of_3() { sort -n | sed -n 2p; }
TIMEFORMAT='processor %U %S'
timed_board() { # ARGUMENTS...: its statistics and processor time in one line: virtual seconds, instructions, processor seconds
    { time build/matrig-board "$@"; } 2>&1 |
        sed -n 's/^matrig-board: \([0-9.]*\) s virtual.*), \([0-9]*\) instructions.*/\1 \2/p; s/^processor \(.*\) \(.*\)/\1 \2/p' |
        paste -s -d ' ' | awk '{ print $1, $2, $3 + $4 }'
}
board_ratio() { # EXTRA ARGUMENTS...
    for _ in 1 2 3; do
        timed_board --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" "$@" | awk '{ print $1 / $3 }'
    done | median_of_3
}

echo "emulated board, virtual over processor time:"
printf '  landing %s          %6.1f x (wanted: 1.5, the predictor running)\n' 1 "$(board_ratio --rig tests/runs/landing1.run)"
printf '  landing %s          %6.1f x (wanted: 1.5, the predictor running)\n' 5 "$(board_ratio --rig tests/runs/landing5.run)"
printf '  the same, no rules %6.1f x (the difference is what rules of time and electricity cost)\n' \
    "$(board_ratio --rig tests/runs/landing5.run --rules off)"
printf '  5, everything traced %4.1f x (wanted: 2)\n' \
    "$(board_ratio --rig tests/runs/landing5.run --vcd "$tmp/vcd" --profile "$tmp/profile")"
printf '  idle, disarmed     %6.1f x (wanted: 30)\n' "$(board_ratio --for 20)"
echo "emulated board, by instruction mix (one image each), million instructions a second, and relative to the first:"
for mix in integer memory float register interrupt; do
    for _ in 1 2 3; do
        timed_board --elf build/tests/hil/images/mix_$mix.elf --for 5 | awk '{ print $2 / $3 / 1e6 }'
    done | median_of_3 | sed "s/^/$mix /"
done | awk '{ if (NR == 1) first = $2; printf "  %-18s %6.0f  %5.2f\n", $1, $2, $2 / first }'
echo "emulated board at --speed real for 3 s, latest end of a millisecond:"
build/matrig-board --elf build/firmware/matrig.elf --for 3 --speed real 2>&1 | sed -n 's/.*at most \([0-9.]* ms\) late, \([0-9.]*\) after.*/  \1 at the start, then \2 ms (wanted: 5 ms)/p'
echo "what a rig saves by what it lacks, idle and (landing 5) recording: instructions a block, CAN frames, serial bytes, black-box bytes a second:"
counts() { # ELF, SECONDS, EXTRA ARGUMENTS...: instructions, CAN frames, serial bytes, pages of the black box
    rm -f "$tmp/nor"
    build/matrig-board --elf "$1" --can "file:$tmp/can" --serial "file:$tmp/serial" --nor "$tmp/nor" --for "$2" "${@:3}" 2>&1 |
        sed -n 's/.*x), \([0-9]*\) instructions, CAN \([0-9]*\) out.*serial \([0-9]*\) bytes out.*/\1 \2 \3/p'
    od -An -v -tx1 -w256 "$tmp/nor" | grep -vc '^\( ff\)*$' || true
}
for rig in full quiet bandless four switches; do
    elf=build/tests/variant/$rig.elf
    if [ $rig = full ]; then elf=build/firmware/matrig.elf; fi
    { counts $elf 5; counts $elf 10; counts $elf 1.8 --rig tests/runs/landing5.run; counts $elf 5.8 --rig tests/runs/landing5.run; } | paste -s -d ' ' |
        awk -v rig=$rig '{ printf "  %-9s idle %5.0f %5.0f %6.0f %6.0f   recording %6.0f %5.0f %6.0f %6.0f\n", rig, ($5 - $1) / 5000, ($6 - $2) / 5,
            ($7 - $3) / 5, 256 * ($8 - $4) / 5, ($13 - $9) / 4000, ($14 - $10) / 4, ($15 - $11) / 4, 256 * ($16 - $12) / 4 }'
done
echo "matrig fit, 1,000 synthetic landings of a 30-mat runway, fitted by its own model, with known parameters (tests/fit/cheap.h; 0.003 in of noise, joints of their own; make fit-misfits has longer runways):"
build/tests/fit/coverage 1000 160
