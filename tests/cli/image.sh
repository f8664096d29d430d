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

check "at most 128 KiB of flash" flash_fits
check "at most 120 KiB of RAM" ram_fits
check "no heap linked" no_heap
check "worst-case stack from the compiler's figures fits its region" stack_bounded
check "configuration sectors are spared" configuration_sectors_empty
check "the raw binary starts with the vectors" bin_equals_elf
finish
