#!/usr/bin/env bash
# Arrows run one way: firmware, host and hil rest on common and on nothing of each other. Seen in the programs themselves (each
# object's source, from the debug information) and in what the sources include.
. "$(dirname "$0")/tap.sh"

# parts PROGRAM: the folders whose objects are in it, one a line
parts() {
    readelf --wide --debug-dump=info --dwarf-depth=1 "$1" 2>/dev/null |
        sed -nE 's!.*DW_AT_name .*[ :](common|firmware|hil|host|tests)/[^ ]*$!\1!p' | sort -u | paste -sd ' '
}
# is_made_of PROGRAM PARTS
is_made_of() {
    echo "$1: $(parts "$1")"
    [ "$(parts "$1")" = "$2" ]
}
# a program that has an object of firmware/: so the question has two answers
finds_an_object_of_the_firmware() { is_made_of build/tests/golden/golden "common firmware host tests"; }
# includes_only FOLDER PARTS: as a pattern
includes_only() {
    ! grep -rnE '^ *# *include "' --include='*.[ch]' --include='*.def' "$1" | grep -vE "include \"($2)"
}

check "matrig has objects of common/ and host/ alone" is_made_of build/matrig "common host"
check "matrig-study likewise" is_made_of build/matrig-study "common host"
check "matrig-board has objects of common/ and hil/ alone" is_made_of build/matrig-board "common hil"
check "the firmware has objects of common/ and firmware/ alone" is_made_of build/firmware/matrig.elf "common firmware"
check "an object of the firmware in a program is found" finds_an_object_of_the_firmware
check "common/ includes nothing but common/" includes_only common common/
check "host/ includes common/ and host/ alone, and the numbers of the circuits" includes_only host 'common/|host/|hil/circuits/figures\.def"'
check "hil/ includes common/ and hil/ alone" includes_only hil 'common/|hil/'
check "firmware/ includes common/ and firmware/ alone" includes_only firmware 'common/|firmware/'
finish
