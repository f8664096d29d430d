#!/usr/bin/env bash
# matrig flash programs the emulated board through its boot ROM, by stm32flash: what is there afterwards, what is spared, what happens to
# broken-off sessions, and what is refused. The pseudo-terminal keeps the board waiting while nobody has it open.
. "$(dirname "$0")/tap.sh"
firmware=build/firmware
tty=$(mktemp -u /tmp/matrig-tty.XXXXXX)
board=
trap 'stop_board; rm -f "$tty"' EXIT

start_board() { # OPTION...: in the background, with its flash in $tmp/flash
    rm -f "$tty" # of the board before
    timeout 600 build/matrig-board --serial "pty:$tty" --flash "$tmp/flash" --times typical "$@" 2>"$tmp/board" &
    board=$!
    await test -e "$tty" && return 0
    cat "$tmp/board"
    return 1
}
stop_board() { # its flash is written then
    [ -z "$board" ] && return 0
    kill "$board" 2>/dev/null
    wait "$board"
    board_status=$?
    board=
    [ $board_status -eq 0 ] || cat "$tmp/board"
    return $board_status
}
fresh_flash() { # a configuration in sectors 2 and 3, noise where the program goes, all else erased
    perl -e 'srand(4); print "\xff" x 0x8000, join("", map chr(int(rand(256))), 1 .. 0x8000), join("", map chr(int(rand(256))), 1 .. 3000),
        "\xff" x (0x100000 - 0x10000 - 3000)' >"$tmp/flash"
    cp "$tmp/flash" "$tmp/before"
}
part() { dd if="$1" bs=4096 skip=$(($2 / 4096)) count=$(($3 / 4096)) status=none; } # FILE FROM LENGTH
configuration_kept() { cmp <(part "$tmp/flash" 0x8000 0x8000) <(part "$tmp/before" 0x8000 0x8000); }
configuration_blank() { cmp <(part "$tmp/flash" 0x8000 0x8000) <(head -c 32768 /dev/zero | tr '\0' '\377'); }
program_there() { # IMAGE.bin: all of it but what lies between vectors and program
    cmp -n "$(stat -c %s $firmware/vectors.bin)" "$1" "$tmp/flash" &&
        cmp -i 65536 -n $(($(stat -c %s "$1") - 65536)) "$1" "$tmp/flash"
}
flash() { # ARGUMENT...
    timeout 600 build/matrig flash "pty:$tty" "$@" --baud 460800 >"$tmp/said" 2>"$tmp/err"
    local status=$?
    cat "$tmp/said" "$tmp/err"
    return $status
}

flashes() { # FILE: the whole of it; the board runs it; the configuration is as it was
    fresh_flash && start_board --boot0 && flash "$1" && stop_board &&
        grep -q 'board  *runs it' "$tmp/said" && program_there $firmware/matrig.bin && configuration_kept
}
# The firmware that runs gives way. What it runs already is not flashed.
from_the_firmware() {
    start_board && flash $firmware/matrig.bin && grep -q 'already runs this image' "$tmp/said" || return 1
    cp $firmware/matrig.elf "$tmp/other.elf" && build/firmware/stamp "$tmp/other.elf" 0123456789ab-dirty &&
        flash "$tmp/other.elf" && grep -q 'the program is that of the image, but the header' "$tmp/err" &&
        grep -q '^commit  *0123456789ab-dirty$' "$tmp/said" && grep -q 'board  *runs it' "$tmp/said" && stop_board && configuration_kept
}
compares() { # the board with files
    start_board && build/matrig board --serial "pty:$tty" --image $firmware/matrig.bin >"$tmp/said" || return 1
    cat "$tmp/said"
    grep -q "^commit  *$(cat $firmware/commit)\$" "$tmp/said" && grep -q "^image  *intact\$" "$tmp/said" && grep -q "^running this image  *yes" "$tmp/said" || return 1
    build/matrig --json board --serial "pty:$tty" --image build/tests/variant/rest.elf >"$tmp/json"
    [ $? -eq 1 ] && grep -q '"same":false,"difference":"program ' "$tmp/json" && stop_board
}
# stm32flash as it is, but for one part, at which the cable is pulled.
pulled_at() { # ADDRESS IMAGE
    mkdir -p "$tmp/bin"
    printf '#!/bin/sh\ncase "$*" in *"-S %s "*) echo "Failed to write memory at address %s"; exit 1 ;; esac\nexec %s "$@"\n' \
        "$1" "$1" "$(command -v stm32flash)" >"$tmp/bin/stm32flash"
    chmod +x "$tmp/bin/stm32flash"
    PATH=$tmp/bin:$PATH fails_with 3 "stm32flash failed at the program, $1: .*Failed to write memory.*run the command again" \
        build/matrig --quiet flash "pty:$tty" "$2" --baud 460800
}
half_a_program_does_not_start() { # power off and on, BOOT0 low: the board is in its boot ROM all the same, and the same command goes on
    fresh_flash && start_board --boot0 && pulled_at 0x08010000 $firmware/matrig.elf && stop_board && configuration_kept &&
        start_board && flash $firmware/matrig.elf && grep -q 'expecting the boot ROM' "$tmp/err" && grep -q 'board  *runs it' "$tmp/said" && stop_board &&
        program_there $firmware/matrig.bin && configuration_kept
}
no_stm32flash() {
    mkdir -p "$tmp/none" && fresh_flash && start_board --boot0 || return 1
    fails_with 3 'stm32flash is missing.*apt-get install stm32flash' env PATH="$tmp/none" "$PWD/build/matrig" --quiet flash "pty:$tty" $firmware/matrig.elf
    local found=$?
    stop_board && return $found
}
protected() {
    local i done=1
    for i in 1 2 3; do # it does not ask again when a busy computer answers late
        start_board --boot0 && timeout 600 stm32flash -m 8n1 -b 460800 -j "$tty" && done=0 && break
        stop_board
    done
    [ $done = 0 ] && stop_board && start_board --boot0 || return 1
    fails_with 3 'stm32flash failed at the jump to the boot ROM.*stm32flash -u .*-k removes read protection' build/matrig --quiet flash "pty:$tty" $firmware/matrig.elf --baud 460800
    local found=$?
    stop_board && return $found
}
not_during_a_landing() { # the run file arms in the first second
    rm -f "$tmp/flash" && start_board --elf $firmware/matrig.elf --rig tests/runs/landing5.run --speed real || return 1
    sleep 10 <"$tty" &
    sleep 1.5
    fails_with 2 'cannot restart during a landing \(state: (armed|landing)\)' build/matrig --quiet flash "pty:$tty" build/tests/variant/rest.elf
    local found=$?
    kill $! "$board"
    wait "$board"
    board=
    return $found
}
nobody_there() {
    start_board --elf $firmware/bringup.elf || return 1 # no firmware, and no boot ROM
    fails_with 3 'the boot ROM does not answer .*BOOT0 high' build/matrig --quiet flash "pty:$tty" $firmware/matrig.elf --baud 460800
    local found=$?
    stop_board && return $found
}
refused() { # before any board is spoken to
    local elf=$firmware/matrig.elf
    cp $elf "$tmp/notes.txt" && head -c 100 README.md >"$tmp/text" && : >"$tmp/empty.bin" || return 1
    fails_with 4 'different machine' build/matrig flash serial:/dev/null build/matrig &&
        fails_with 4 'the image file is empty' build/matrig flash serial:/dev/null "$tmp/empty.bin" &&
        fails_with 4 'neither an ELF file nor named .bin' build/matrig flash serial:/dev/null "$tmp/text" &&
        fails_with 3 'no firmware image' build/matrig flash serial:/dev/null "$tmp/nowhere.elf" &&
        fails_with 2 "has no matrig header" build/matrig flash serial:/dev/null build/tests/hil/images/talk.elf &&
        fails_with 3 'no serial port' build/matrig flash serial:/dev/nowhere $elf &&
        fails_with 2 'stm32flash needs a serial port: can:can0' build/matrig flash can:can0 $elf &&
        fails_with 2 'stm32flash needs a serial port: file:x' build/matrig flash file:x $elf &&
        fails_with 2 'stm32flash needs a serial port' build/matrig flash unix:x $elf &&
        fails_with 2 'out of range: 300 for --baud' build/matrig flash serial:/dev/null $elf --baud 300 &&
        fails_with 2 'argument missing' build/matrig flash serial:/dev/null || return 1
    MAKEFLAGS= make -s flash >"$tmp/out" 2>"$tmp/err"
    [ $? -eq 2 ] && head -n 1 "$tmp/err" | grep -q 'make flash PORT=/dev/ttyUSB0'
}
same_from_the_same() { # nothing of time or place: linked twice, in two folders, the same bytes
    for place in "$tmp/here" "$tmp/there"; do
        mkdir -p "$place/host/common" "$place/host/firmware" && touch "$place/.demo-packages" && cp -a build/arm "$place/" &&
            cp -a build/host/common/. "$place/host/common/" && cp -a build/firmware/stamp "$place/host/firmware/" &&
            make -s B="$place" "$place/firmware/matrig.elf" || return 1
    done
    cmp "$tmp/here/firmware/matrig.elf" "$tmp/there/firmware/matrig.elf"
}

check "matrig flash programs and verifies an image, and the board runs it" flashes $firmware/matrig.elf
check "matrig board compares the image that runs with a file" compares
check "the firmware gives way to the boot ROM; what runs already is not flashed" from_the_firmware
check "half a program does not start, and is flashed again" half_a_program_does_not_start
check "without stm32flash" no_stm32flash
check "read protection is told" protected
check "a landing is not interrupted" not_during_a_landing
check "nobody there is told" nobody_there
check "what is no image or no board is refused" refused
check "linked again, the image is the same" same_from_the_same
finish
