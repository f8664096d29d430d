#!/usr/bin/env bash
# Barriers of the firmware, which no emulated board misses: by its machine code and its source.
. "$(dirname "$0")/tap.sh"

# On each way out of a handler a DSB stands behind its last store: a flag that is not clear yet at the peripheral brings the interrupt again.
# SysTick has no flag to clear.
handlers_end_with_a_barrier() { # ELF
    arm-none-eabi-objdump -d --no-show-raw-insn "$1" | awk '
        /^[0-9a-f]+ <.*>:$/ { name = $2; inside = name ~ /^<(adc|can1_[a-z0-9]+|dma[12]_stream[0-9])_irq>:$/; fenced = 0; handlers += inside; next }
        !inside { next }
        $2 == "dsb" { fenced = 1 }
        $2 ~ /^(v?st|bl)/ && $2 !~ /^bl[est]/ { fenced = 0 }
        $2 ~ /^(pop|ldmia)/ && /pc}/ || $2 == "bx" || $2 ~ /^b(\.[nw])?$/ && $0 !~ name_of(name) { if (!fenced) { print "no barrier: " name $0; bad = 1 } }
        function name_of(label) { return "<" substr(label, 2, length(label) - 3) }
        END { print handlers " handlers"; exit bad || handlers != 7 }'
}
fences_are_in_one_place() { # streams start behind the one of regs.h, rings count by queue.h
    ! grep -nE '\| DMA_CR_EN|volatile uint32_t .*(queued|taken|_put|_got)' firmware/f407/*.c
}
# Barriers between a store and what looks for its effect, and between a count of DMA and the bytes it counts.
functions_have_their_barriers() { # ELF
    local function barrier
    while read -r function barrier; do
        arm-none-eabi-objdump -d --no-show-raw-insn --disassemble="$function" "$1" | grep -qw "$barrier" || { echo "no $barrier in $function" && return 1; }
    done <<'L'
flash_program dsb
board_sleep dsb
board_enter_rom dsb
board_serial_receive dmb
nor_poll dmb
L
}

check "each handler ends with a barrier" handlers_end_with_a_barrier build/firmware/matrig.elf
check "functions that hand over or take data have their barriers" functions_have_their_barriers build/firmware/matrig.elf
check "streams and rings have their fences" fences_are_in_one_place
finish
