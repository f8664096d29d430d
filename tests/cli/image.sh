#!/usr/bin/env bash
# The firmware image: size, no heap, stack within its region, boots where most of the chip is missing.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf

section_bytes() { # sum of sections whose address matches
    arm-none-eabi-size -A -x "$elf" | awk -v want="$1" '$3 ~ want {sum += strtonum($2)} END {print sum + 0}'
}
flash_fits() {
    local flash
    flash=$(arm-none-eabi-size "$elf" | awk 'NR == 2 {print $1 + $2}')
    echo "flash $flash bytes of 131072"
    [ "$flash" -le 131072 ]
}
ram_fits() {
    local ram
    ram=$(section_bytes '^0x2000')
    echo "RAM $ram bytes of 98304, stack included"
    [ "$ram" -le 98304 ] && [ "$ram" -gt 4096 ]
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
    for _ in $(seq 100); do
        sleep 0.2
        [ "$(stat -c %s "$tmp/serial" 2>/dev/null || echo 0)" -gt 2000 ] && break
    done
    kill $pid
    wait $pid 2>/dev/null
    build/matrig --json log --serial "file:$tmp/serial" --db "$tmp/qemu.db" >"$tmp/qemu.json"
    cat "$tmp/qemu.json"
    sqlite3 "$tmp/qemu.db" 'select name, text from events' | sort -u
    # layout 1 spoken, and the faults that the catalogue gives to what is missing: no PLL, no DMA, no CAN clock to trust
    for fault in CLOCK_RAW DMA_MISSING SERIAL_POLLED CAN_SILENT IDENTITY_MISSING; do
        grep -q "\"$fault\"" "$tmp/qemu.json" || return 1
    done
}

check "at most 128 KiB of flash" flash_fits
check "at most 96 KiB of RAM" ram_fits
check "no heap linked" no_heap
check "worst-case stack from the compiler's figures fits its region" stack_bounded
check "configuration sectors are spared" configuration_sectors_empty
check "the raw binary starts with the vectors" bin_equals_elf
check "boots on QEMU's netduinoplus2 and reports what is missing" boots_on_qemu
finish
