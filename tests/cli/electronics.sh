#!/usr/bin/env bash
# Drawn boards: --vdda and --board-seed on the command line; landing 5 the whole way, and whether what is stated of it holds.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf

bytes() { # FILE OPTION...: what a board says on its serial line in the first 1.2 s of landing 5
    timeout 600 build/matrig-board --elf $elf --serial "file:$tmp/$1" --rig tests/runs/landing5.run --for 1.2 "${@:2}" 2>"$tmp/$1.err"
}
a_seed_is_a_board() { # same board, same bytes; another board, others; the noise's seed is another thing
    bytes one --board-seed 4 && bytes again --board-seed 4 && bytes other --board-seed 5 && bytes noise --board-seed 4 --seed 2 && bytes ideal &&
        cmp "$tmp/one" "$tmp/again" && ! cmp -s "$tmp/one" "$tmp/other" && ! cmp -s "$tmp/one" "$tmp/noise" && ! cmp -s "$tmp/one" "$tmp/ideal"
}
stated_errors_hold() { # a few boards here, more in make long
    python3 tests/electronics/landings.py "$tmp/landings" "$(take 2 20)"
}
# The same with the errors stated at a tenth: the check can fail.
a_tenth_does_not_hold() {
    python3 - "$tmp/landings" <<'P'
import glob, json, sys
for path in glob.glob(sys.argv[1] + "/board*.json"):
    landing = json.load(open(path))
    for of in landing["displacements"] + landing["tensions"]:
        for key in of:
            if key.startswith(("error_", "least_error", "most_error")) or key.endswith("_error_lb") or key.endswith("_error_in"):
                of[key] = of[key] / 10
    json.dump(landing, open(path, "w"))
P
    ! python3 tests/electronics/landings.py "$tmp/landings" "$(take 2 20)" 2>"$tmp/said" && grep -q 'does not hold at its rate: peak displacement' "$tmp/said"
}

check "a seed is a board" a_seed_is_a_board
check "what is stated of landing 5 holds on drawn boards" stated_errors_hold
check "stated errors of a tenth do not hold, and that is told" a_tenth_does_not_hold
check "a supply beyond the chip's" fails_with 2 '--vdda cannot be `2.6`' build/matrig-board --vdda 2.6
check "a supply in hexadecimal" fails_with 2 '--vdda cannot be `0x3`' build/matrig-board --vdda 0x3
check "a board that is no number" fails_with 2 '--board-seed cannot be `x`' build/matrig-board --board-seed x
finish
