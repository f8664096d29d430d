#!/usr/bin/env bash
# The black box's /CS, a second opinion beside tests/hil/test_pin_times.c: from the image's machine code alone, whatever runs.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
port_b=40020400 # GPIOB; RM0090 2.3
least_ns=50     # W25Q128JV rev. F, 9.6: tSHSL2
slew_ns=10      # PB12's rise at OSPEEDR 1 or more, STM32F407 data sheet
core_mhz=176    # 168, 4.5 % fast: ACC_HSI

arm-none-eabi-objdump -d $elf >"$tmp/code"
arm-none-eabi-nm -l $elf >"$tmp/symbols"
# functions that hold the port's address, with their source file
port_users() {
    awk -v port="$port_b" '/^[0-9a-f]+ <.*>:$/ { name = $2; gsub(/[<>:]/, "", name) } $3 == ".word" && $4 == "0x" port { print name }' "$tmp/code" | sort -u |
        while read -r name; do awk -F"\t" -v n="$name" '$1 ~ " " n "$" { f = $2; sub(/:[0-9]+$/, "", f); sub(/.*\//, "", f); print n, f; exit }' "$tmp/symbols"; done
}
one_function_moves_it() {
    port_users | tee "$tmp/users"
    [ "$(awk '$2 == "nor.c" { print $1 }' "$tmp/users" | xargs)" = select ]
}
# Straight from the entry to the loop, the loop as often as it says, then to the store: no instruction takes less than a cycle.
waits_before_it_falls() {
    awk '/<select>:$/ { on = 1; next } on && /^$/ { exit } on' "$tmp/code" | sed -E 's/^ *([0-9a-f]+):\t[0-9a-f ]+\t/\1 /; s/[;@].*//; s/\t/ /g' >"$tmp/select"
    cat "$tmp/select"
    awk -v least=$((least_ns + slew_ns)) -v mhz=$core_mhz '
        $2 ~ /^movs?(\.w)?$/ && $4 ~ /^#/ { count[$3] = substr($4, 2) + 0 }
        $2 == "dsb" { waits = 1; next }
        waits == 1 && $2 == "subs" { loop = $1; rounds = count[$3]; waits = 2; next }
        waits == 2 && $2 ~ /^bne/ && $3 == loop { cycles = 2 * rounds; waits = 3; next }
        waits == 3 && $2 == "str" { cycles++; ns = cycles * 1000 / mhz; found = 1; exit }
        waits == 3 { cycles++ }
        END { printf "%d rounds, %d cycles at least: %.1f ns of %d\n", rounds, cycles, ns, least; exit !(found && ns >= least) }' "$tmp/select"
}
is_fast() { # OSPEEDR of PB12, bits 24 and 25, as the emulated board has it after the start: not 0
    cat >"$tmp/speed.gdb" <<'END'
tbreak app_poll
continue
printf "speed %d\n", (*(unsigned *)0x40020408 >> 24) & 3
kill
END
    local sockets=$(mktemp -d /tmp/matrig.XXXXXX) board speed
    timeout 120 build/matrig-board --elf $elf --gdb "unix:$sockets/gdb" 2>"$tmp/board.err" &
    board=$!
    await test -S "$sockets/gdb"
    timeout 60 gdb-multiarch -nx -q -batch -ex "target remote $sockets/gdb" -x "$tmp/speed.gdb" $elf >"$tmp/session" 2>&1
    wait $board
    rm -rf "$sockets"
    speed=$(sed -n 's/^speed //p' "$tmp/session")
    echo "OSPEEDR of PB12: $speed"
    [ "${speed:-0}" -ge 1 ]
}

check "one function of the driver moves /CS" one_function_moves_it
check "it waits for tSHSL2 before it falls, by its machine code" waits_before_it_falls
check "the pin is fast" is_fast
finish
