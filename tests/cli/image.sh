#!/usr/bin/env bash
# The firmware images: size, place, no heap, stack within its region. Regions are those of common/memory.def.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf

# region NAME: where it starts and how many bytes of it the smallest chip has
region() { # NAME
    local at f407 f446
    read -r at f407 f446 < <(sed -n "s/^REGION($1, \(0x[0-9a-f]*\), KIB(\([0-9]*\), \([0-9]*\)),.*/\1 \2 \3/p" common/memory.def) &&
        echo "$((at)) $((1024 * (f407 < f446 ? f407 : f446)))"
}
# Every byte that is loaded or set aside is in one of the three, of the smallest board: not in the configuration's sectors, nor where no DMA comes.
fits() {
    local image name at size load rest flash ram start
    read -r flash rest < <(region VECTORS) && [ "$flash $rest" = "134217728 32768" ] && [ "$(region CCM)" = "268435456 0" ] || return 1
    for image in build/firmware/{,discovery/,nucleo446/}{matrig,bringup}.elf; do
        arm-none-eabi-objdump -h "$image" | awk '$1 ~ /^[0-9]+$/ {n = $2; s = $3; v = $4; l = $5; getline; if (/ALLOC/) print n, s, v, l}' >"$tmp/sections"
        [ "$(wc -l <"$tmp/sections")" -ge 5 ] || return 1
        flash=0 ram=0
        while read -r name size at load; do
            size=$((16#$size)) at=$((16#$at)) load=$((16#$load))
            case $name in
            .vectors) within VECTORS "$at" "$size" && [ "$load" = "$at" ] || return 1 ;;
            .text | .ARM.exidx) within PROGRAM "$at" "$size" && [ "$load" = "$at" ] && flash=$((flash + size)) || return 1 ;;
            .data) within PROGRAM "$load" "$size" && within RAM "$at" "$size" && flash=$((flash + size)) ram=$((ram + size)) || return 1 ;;
            *) within RAM "$at" "$size" && ram=$((ram + size)) || return 1 ;;
            esac
        done <"$tmp/sections"
        read -r start rest < <(region PROGRAM)
        echo "$image: flash $flash bytes, left $((rest - flash)); RAM $ram, left $(($(region RAM | cut -d ' ' -f 2) - ram))"
        [ "$flash" -gt 30000 ] && [ "$ram" -gt 4096 ] || return 1
    done
}
within() { # REGION ADDRESS BYTES
    local start bytes
    read -r start bytes < <(region "$1") && [ "$2" -ge "$start" ] && [ $(($2 + $3)) -le $((start + bytes)) ] || { echo "$image: $name is not in $1"; return 1; }
}
no_heap() { ! arm-none-eabi-nm "$elf" | grep -E ' _*(malloc|calloc|realloc|free|sbrk)(_r)?$'; }
stack_bounded() { grep -E '^worst case [0-9]+ bytes of [0-9]+$' build/firmware/stack.txt; }
# What is compiled for speed is there to be compiled, and what the compiler noted of itself is as firmware/hot.txt says.
hot_is_fast() {
    local file
    grep -v '^#' firmware/hot.txt >"$tmp/hot" && [ -s "$tmp/hot" ] || return 1
    while read -r _ file _; do
        [ -f "$file.c" ] || { echo "no $file.c"; return 1; }
    done <"$tmp/hot"
    find build/arm/common build/arm/firmware build/arm/zg -name '*.o' -exec arm-none-eabi-readelf -p .debug_str {} + >"$tmp/strings" || return 1
    awk 'FNR == NR { level[$2] = $3; next }
        $1 == "File:" { file = $2; sub(/^build\/arm\/(zg\/)?/, "", file); sub(/\.o$/, "", file); files++ }
        / GNU C11 / { how = ""; for (i = 1; i <= NF; i++) if ($i ~ /^-O/) how = $i
            wanted = file in level ? level[file] : "-Os"; seen++
            if (how != wanted) { print file ": hot.txt says otherwise: " how; bad = 1 } }
        END { if (seen != files || seen < 50) print seen " of " files " objects say how"; exit bad || seen != files || seen < 50 }' "$tmp/hot" "$tmp/strings"
}
bin_equals_elf() {
    arm-none-eabi-objcopy -I binary -O binary build/firmware/matrig.bin "$tmp/bin" &&
        [ "$(od -An -tx4 -j4 -N4 build/firmware/matrig.bin | tr -d ' ')" = \
            "$(printf '%08x' $((0x$(arm-none-eabi-nm "$elf" | awk '$3 == "reset" {print $1}') | 1)))" ]
}

check "every image fits the smallest board, each part in its region" fits
check "no heap linked" no_heap
check "worst-case stack from the compiler's figures fits its region" stack_bounded
check "files that take instructions are compiled for speed, the others for size" hot_is_fast
check "the raw binary starts with the vectors" bin_equals_elf
finish
