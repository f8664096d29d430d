#!/usr/bin/env bash
# Debian's stm32flash against the boot ROM over a pseudo-terminal: id, erase, write, verify, go, and then the firmware
# says hello. Protection and parity: tests/hil/test_bootrom.c. Linux keeps no parity for pseudo-terminals: hence -m 8n1 (hil/link/wire_link.c).
. "$(dirname "$0")/tap.sh"
image=build/firmware/matrig.bin
tty=$(mktemp -u /tmp/matrig-tty.XXXXXX)
board=
trap 'stop_board; rm -f "$tty"' EXIT

# start_board OPTION...: in the background, with its flash in $tmp/flash
start_board() {
    timeout 600 build/matrig-board --serial "pty:$tty" --flash "$tmp/flash" --times typical "$@" 2>"$tmp/board" &
    board=$!
    await test -e "$tty" && return 0
    cat "$tmp/board"
    return 1
}
stop_board() {
    [ -z "$board" ] && return
    kill "$board" 2>/dev/null
    wait "$board"
    board_status=$?
    board=
}
flash() { # BAUD ARGUMENT...
    local baud=$1
    shift
    timeout 600 stm32flash -m 8n1 -b "$baud" "$@" "$tty" >"$tmp/out" 2>&1
    local status=$?
    tr '\r' '\n' <"$tmp/out" | tail -n 12
    return $status
}
flash_holds_image() { cmp -n "$(stat -c %s $image)" $image "$tmp/flash"; }

identifies() {
    start_board --boot0 && flash 115200 || return 1
    grep -q 'Device ID *: 0x0413' "$tmp/out" && grep -q 'Version *: 0x31' "$tmp/out"
    local found=$?
    stop_board
    [ "$board_status" -eq 0 ] && return $found
}
# The whole of it, and after GO the firmware on the same line at its own rate.
programs_and_goes() {
    start_board --boot0 && flash 460800 -w $image -v -g 0x08000000 || return 1
    grep -q 'verified address' "$tmp/out" && grep -q 'Starting execution' "$tmp/out" || return 1
    stty -F "$tty" 2000000 raw -echo
    timeout 2 cat "$tty" >"$tmp/said"
    stop_board
    [ "$board_status" -eq 0 ] || return 1
    build/matrig --quiet log --serial "file:$tmp/said" --db "$tmp/said.db" >/dev/null 2>&1
    local hellos
    hellos=$(sqlite3 "$tmp/said.db" "select count(*) from frames where can_id = 0x1f0")
    echo "$hellos hellos"
    [ "$hellos" -ge 1 ] && flash_holds_image
}
boots_from_file() { # the flash file alone, without ELF and boot ROM
    build/matrig-board --flash "$tmp/flash" --serial "file:$tmp/alone" --for 0.5 2>"$tmp/board" || return 1
    [ "$(stat -c %s "$tmp/alone")" -gt 1000 ] && flash_holds_image
}
elf_spares_configuration() { # sectors 2 and 3, which the ELF does not use, keep what is in the file
    cp "$tmp/flash" "$tmp/spared"
    printf 'kept' | dd of="$tmp/spared" bs=1 seek=$((0x8000)) conv=notrunc 2>/dev/null
    build/matrig-board --flash "$tmp/spared" --elf build/firmware/matrig.elf --for 0.1 2>"$tmp/board" || return 1
    [ "$(dd if="$tmp/spared" bs=1 skip=$((0x8000)) count=4 2>/dev/null)" = kept ] && cmp -n 4 $image "$tmp/spared"
}
check "the ROM names the chip" identifies
check "erase, write, verify, go: the firmware says hello" programs_and_goes
check "the flash file alone boots" boots_from_file
check "an ELF over a flash file spares the configuration" elf_spares_configuration
check "no firmware, no boot ROM" fails_with 3 "no firmware: the reset vector is 0xffffffff" build/matrig-board --flash "$tmp/none"
check "a database is no flash file" fails_with 4 "said.db: the file is a database" build/matrig-board --flash "$tmp/said.db"
check "parity that is none" fails_with 2 "--parity cannot be .mark." build/matrig-board --boot0 --parity mark
finish
