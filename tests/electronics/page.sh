#!/usr/bin/env bash
# make electronics: a thousand drawn boards, what they did as docs/measured/electronics.md. Parts that are there already are kept: remove
# build/electronics for all anew. usage: page.sh FOLDER BOARDS LANDINGS
set -eu
cd "$(dirname "$0")/../.."
out=$1 boards=$2 landings=$3
mkdir -p "$out"
program=build/tests/electronics/electronics
# part NAME COMMAND...: its output, whole or not at all
part() {
    [ -s "$out/$1.md" ] && return
    "${@:2}" >"$out/$1.part" && mv "$out/$1.part" "$out/$1.md"
}
part boards $program boards "$boards" &
part landings python3 tests/electronics/landings.py "$out/landings" "$landings"
wait $!
part staircase $program staircase "$boards"
cat >docs/measured/electronics.md <<P
# Measured: boards with electronics of their own

Every figure on this page was measured on the emulated board; no real board was measured. \`make electronics\` makes the page
(\`tests/electronics\`), here on $(date -u +%F), at $(git rev-parse --short HEAD). Boards are drawn from the figures of the reference
circuits (\`hil/circuits/figures.def\`); what is drawn, and what not: [hil/README.md](../../hil/README.md#electricity).

## Switches, zeros and spans

Each board's 24 switches open in order, its zeros are taken by the command \`zero\`, then every transducer goes through 0 to 2.8 in and every gage through 0 to
400 lb. The calibration is that of \`matrig calibrate\`, through five known values; four in between judge it. Of each kind: root mean
square, 95 % are below, the most. At the ends of the supply a board's own errors can use up the reference's 2 %: then it does not take \`zero\`, and
its bridges read nothing, told as REFERENCE.

$(cat "$out/boards.md")

## The staircase and the converter's linearity

INL of exactly the data sheet's typical and most; resistors of 0.1 % as in the circuits, and of 1 %.

$(cat "$out/staircase.md")

## Landing 5: do stated errors hold?

Electronics, supply (3.24 to 3.36 V) and temperature (10 to 30 C) are drawn for each board, the landing is the same. No board is calibrated:
errors are those that are built in. If errors are what is stated, 68.3 % of the values lie within one and 95.4 % within two of them. A speed rests on times alone, so all
boards say the same: its rows tell one error, that of this landing, as often as there are boards.

$(cat "$out/landings.md")
P
