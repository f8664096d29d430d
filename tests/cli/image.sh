#!/usr/bin/env bash
# The firmware image: size, no heap, stack within its region, boots where most of the chip is missing.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf

flash_fits() {
    local flash
    flash=$(arm-none-eabi-size "$elf" | awk 'NR == 2 {print $1 + $2}')
    echo "flash $flash bytes of 131072"
    [ "$flash" -le 131072 ]
}
ram_fits() {
    local ram
    ram=$(arm-none-eabi-size -A -d "$elf" | awk '$3 >= 536870912 && $3 < 537001984 {sum += $2} END {print sum + 0}')
    echo "RAM $ram bytes of 122880, stack included"
    [ "$ram" -le 122880 ] && [ "$ram" -gt 4096 ]
}
no_heap() { ! arm-none-eabi-nm "$elf" | grep -E ' _*(malloc|calloc|realloc|free|sbrk)(_r)?$'; }
stack_bounded() { grep -E '^worst case [0-9]+ bytes of [0-9]+$' build/firmware/stack.txt; }
configuration_sectors_empty() { # sectors 2 and 3 are spared: nothing is linked there
    ! arm-none-eabi-objdump -h "$elf" | awk '{print $4, $5}' | grep -Ei '0800[89abcdef][0-9a-f]{3}'
}
bin_equals_elf() {
    arm-none-eabi-objcopy -I binary -O binary build/firmware/matrig.bin "$tmp/bin" &&
        [ "$(od -An -tx4 -j4 -N4 build/firmware/matrig.bin | tr -d ' ')" = \
            "$(printf '%08x' $((0x$(arm-none-eabi-nm "$elf" | awk '$3 == "reset" {print $1}') | 1)))" ]
}

# QEMU's netduinoplus2 has no RCC, DMA, CAN or ADC that answers: bounded waits must get the board to its serial port, where
# it says who it is and what is missing.
boots_on_qemu() {
    local pid
    qemu-system-arm -M netduinoplus2 -kernel "$elf" -display none -monitor none -serial "file:$tmp/serial" &
    pid=$!
    has_said() { [ "$(stat -c %s "$tmp/serial" 2>/dev/null || echo 0)" -gt 8000 ]; }
    await has_said
    kill $pid
    wait $pid 2>/dev/null
    # matrig itself reads what it said: hello with this layout (else log refuses it), and a fault for each part missing
    # it is stopped at any time, so what it said may end inside a frame
    build/matrig --quiet log --serial "file:$tmp/serial" --db "$tmp/qemu.db" 2>"$tmp/log.err" || grep 'ended inside a frame' "$tmp/log.err" || return 1
    sqlite3 "$tmp/qemu.db" "select distinct code from events where kind = 'fault' order by code" >"$tmp/faults"
    sqlite3 "$tmp/qemu.db" "select count(*) from frames where can_id = 0x1f0" >"$tmp/hellos"
    echo "faults $(tr '\n' ' ' <"$tmp/faults"), $(cat "$tmp/hellos") hellos"
    # 0 no crystal, 1 no PLL, 2 no DMA, 16 serial polled, 17 CAN silent, 22 no identity
    for fault in 0 1 2 16 17 22; do
        grep -qx $fault "$tmp/faults" || return 1
    done
    [ "$(cat "$tmp/hellos")" -ge 1 ]
}

check "at most 128 KiB of flash" flash_fits
check "at most 120 KiB of RAM" ram_fits
check "no heap linked" no_heap
check "worst-case stack from the compiler's figures fits its region" stack_bounded
check "configuration sectors are spared" configuration_sectors_empty
check "the raw binary starts with the vectors" bin_equals_elf
check "boots on QEMU's netduinoplus2 and reports what is missing" boots_on_qemu
finish
