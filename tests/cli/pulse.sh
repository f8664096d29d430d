#!/usr/bin/env bash
# The black box's /CS, a second opinion beside the emulated board (tests/hil/test_rules.c): from the images' machine code alone, whatever runs
# (tests/machinecode/pulse.py). Both say the same of today's image, and of the one of 339b9da, whose black box would not have worked.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
old=build/tests/old/339b9da.elf
least_ns=50  # W25Q128JV rev. F, 9.6: tSHSL2
slew_ns=10   # PB12's rise at OSPEEDR 1 or more, STM32F407 data sheet
core_mhz=176 # 168, 4.5 % fast: ACC_HSI

high_cycles() { # ELF [--taken N]: least cycles that PB12 is high
    python3 tests/machinecode/pulse.py "$1" B 12 high "${@:2}"
}
ns_of() { # CYCLES SLEW
    awk -v cycles="$1" -v slew="$2" -v mhz=$core_mhz 'BEGIN { printf "%.1f\n", cycles * 1000 / mhz - slew }'
}
pulses_of_known_length() { # the image has pulses of 5, 1, 4 and 30 cycles
    high_cycles build/tests/hil/images/pins.elf | tee "$tmp/pins"
    [ "$(awk '{ print $1 }' "$tmp/pins")" = 1 ]
}
todays_is_long_enough() {
    high_cycles $elf >"$tmp/today" || return 1
    local ns=$(ns_of "$(awk '{ print $1 }' "$tmp/today")" $slew_ns)
    echo "$(cat "$tmp/today"): $ns ns of $least_ns"
    awk -v ns="$ns" -v least=$least_ns 'BEGIN { exit !(ns >= least) }'
}
one_function_moves_it() { # both stores, and no other of that port whose value is known
    awk '{ exit !($3 == "set_select" && $5 == "set_select") }' "$tmp/today"
}
the_old_is_too_short() { # whatever its slew
    high_cycles $old >"$tmp/old" || return 1
    local ns=$(ns_of "$(awk '{ print $1 }' "$tmp/old")" 0)
    echo "$(cat "$tmp/old"): $ns ns of $least_ns"
    awk -v ns="$ns" -v least=$least_ns '{ exit !(ns < least && $3 ~ /^nor_/ && $5 ~ /^nor_/) }' "$tmp/old"
}
# What ran cannot have been shorter than the shortest way that there is.
nothing_that_ran_was_shorter() { # ELF RULES: the board's nearest, slew put back, at 168 MHz; the code's in the same cycles
    build/matrig-board --elf "$1" --rig tests/runs/landing5.run --for 2 --rules "$2" --margins "$tmp/margins" 2>"$tmp/board.err" || return 1
    local ran=$(awk '$1 == "SELECT_HIGH" { printf "%.0f", ($5 + $6) * 0.168 }' "$tmp/margins") can=$(high_cycles "$1" --taken 1 | awk '{ print $1 }')
    echo "the shortest that ran: $ran cycles; the shortest that there is: $can"
    [ "$ran" -ge "$can" ] && [ "$ran" -le $((3 * can + 6)) ]
}
is_fast() { # OSPEEDR of PB12, bits 24 and 25, as the emulated board has it after the start: not 0
    cat >"$tmp/speed.gdb" <<'END'
tbreak app_poll
continue
printf "speed %d\n", (*(unsigned *)0x40020408 >> 24) & 3
kill
END
    local sockets=$(mktemp -d /tmp/matrig.XXXXXX) board speed
    timeout 600 build/matrig-board --elf $elf --gdb "unix:$sockets/gdb" 2>"$tmp/board.err" &
    board=$!
    await test -S "$sockets/gdb"
    timeout 600 gdb-multiarch -nx -q -batch -ex "target remote $sockets/gdb" -x "$tmp/speed.gdb" $elf >"$tmp/session" 2>&1
    wait $board
    rm -rf "$sockets"
    speed=$(sed -n 's/^speed //p' "$tmp/session")
    echo "OSPEEDR of PB12: $speed"
    [ "${speed:-0}" -ge 1 ]
}

check "pulses of known length are found" pulses_of_known_length
check "today's image: /CS is high for tSHSL2 on every way through its code" todays_is_long_enough
check "one function of the driver moves /CS" one_function_moves_it
check "the pin is fast" is_fast
check "the image of 339b9da: too short, in the driver of the black box" the_old_is_too_short
check "the emulated board saw nothing shorter in today's image" nothing_that_ran_was_shorter $elf stop
check "nor in the one of 339b9da" nothing_that_ran_was_shorter $old count
finish
