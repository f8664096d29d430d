#!/usr/bin/env bash
# Faults in a copy of the schematics are found, each by what it does: by the design rules, the pin table, the reference rules, the simulation.
# That the sources have none: make circuits, which make test-circuits has run before.
. "$(dirname "$0")/../cli/tap.sh"
circuits() { python3 hil/circuits/circuits.py --cache build/circuits/cache "$@"; }

copy() { # NAME: a copy of the schematics
    mkdir -p "$tmp/$1" && cp -r hil/circuits/*.sch hil/circuits/*.scm hil/circuits/symbols hil/circuits/gafrc hil/circuits/lepton.conf "$tmp/$1"
}
edit() { # FILE SED: changes that file, and something in it
    cp "$1" "$tmp/before" && sed -i -E "$2" "$1" && ! cmp -s "$tmp/before" "$1" || { echo "nothing to change in $1: $2" | tee -a "$tmp/unchanged"; return 1; }
}
# part REFDES SED: a script for sed that changes the lines of that part of a sheet
part() { echo "/^\{/{:a;N;/\n\}/!ba;/\nrefdes=$1\n/{$2}}"; }
says() { # FILE PATTERN
    grep -E -- "$2" "$1" || { cat "$1"; return 1; }
}

# A copy with many faults, each in another place; all are to be told at once.
broken=$tmp/broken
copy broken
# the wire from the amplifier to its filter
edit $broken/bridge.sch "0,/^N [0-9]+ [0-9]+ [0-9]+ [0-9]+ 4$/{//d}"
edit $broken/mcu.sch "s/=GAGE_3$/=X/; s/=GAGE_4$/=GAGE_3/; s/=X$/=GAGE_4/"
edit $broken/memory.sch "s/=MEMORY_SELECT$/=MEMORY_SELEKT/"
edit $broken/transducer.sch "s/^(C .* )rail-2V5T.sym/\1rail-3V3.sym/"
edit $broken/links.sch "s/=CAN_IN$/=LAMP/"
edit $broken/lamp.sch "$(part R402 's/tol=1%/tol=much/')"
edit $broken/inputs.sch "$(part R701 's/footprint=0603/footprint=/')"
circuits --folder "$broken" --blocks none "$tmp/broken-work" >"$tmp/broken.out" 2>&1
broken_status=$?

# Values and nothing else: the schematics are whole, the figures tell.
changed=$tmp/changed
copy changed
edit $changed/bridge.sch "$(part R5 's/value=12.4/value=20/')"
edit $changed/transducer.sch "$(part C5 's/value=1n/value=10n/')"
edit $changed/lamp.sch "$(part R408 's/value=1k/value=3k/')"
circuits --folder "$changed" --blocks bridge,transducer,lamp "$tmp/changed-work" >"$tmp/changed.out" 2>&1
changed_status=$?

all_were_made() { ! cat "$tmp/unchanged" 2>/dev/null; }
ends_with_one() { [ $broken_status -eq 1 ] && [ $changed_status -eq 1 ] || { echo "$broken_status $changed_status"; cat "$tmp/broken.out" "$tmp/changed.out"; return 1; }; }

figures_are_c() { # each has a name of its own, and a value that is a double
    printf '%s\n' '#define FIGURE(name, value, unit, block, what) static const double name = value; _Static_assert(sizeof unit block what > 3, "");' \
        '#include "hil/circuits/figures.def"' >"$tmp/figures.c" && ${CC:-cc} -std=c11 -fsyntax-only -I. -Wall -Wextra -Werror -Wno-unused "$tmp/figures.c"
}

check "figures.def is C" figures_are_c
check "each of the faults was put in" all_were_made
check "a wire cut: the pin that leads nowhere" says "$tmp/broken.out" '^wires: pin .* of G[0-9]+/.* is not connected$'
check "lepton's own rules see that too" says "$tmp/broken.out" '^rules: ERROR'
check "two gages exchanged at the chip: the pin table" says "$tmp/broken.out" '^pins: PA2 is on net GAGE_4, but zg.def names it GAGE_3$'
check "a signal that does not reach its block" says "$tmp/broken.out" '^pins: MEMORY_SELECT does not reach pin /CS of U501$'
check "a pull that the pin table demands" says "$tmp/broken.out" '^pulls: no resistor pulls MEMORY_SELECT up$'
check "a drive that is not supplied by the reference" says "$tmp/broken.out" '^reference: pin VCC of T1/U1 is on 3V3, not 2V5T'
check "a tolerance that is none, and a part without footprint" \
    says "$tmp/broken.out" '^parts: R402 has the tolerance "much"|^parts: R701 has no footprint'
check "a value changed: the amplifier's gain" says "$tmp/changed.out" '^figures: gage_v_per_lb is 0.00[0-9]+ V/lb by the simulation'
check "the same is outside what firmware and emulator assume" says "$tmp/changed.out" '^limits: gage_v_per_lb is '
check "a value changed: the transducer settles late" says "$tmp/changed.out" '^(figures|limits): transducer_settle_us is '
check "a value changed: the lamp's threshold" says "$tmp/changed.out" '^limits: lamp_sense_threshold_a is '
check "each ends with 1" ends_with_one
finish
