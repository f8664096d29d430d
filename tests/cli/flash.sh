#!/usr/bin/env bash
# stm32flash and matrig flash program the emulated board through its boot ROM: what is there afterwards, what is spared, what happens to
# damaged and broken-off sessions, and what is refused. The pseudo-terminal keeps the board waiting while nobody has it open.
. "$(dirname "$0")/tap.sh"
firmware=build/firmware
tty=$(mktemp -u /tmp/matrig-tty.XXXXXX)
board=
trap 'stop_board; rm -f "$tty"' EXIT

start_board() { # OPTION...: in the background, with its flash in $tmp/flash
    rm -f "$tty" # of the board before
    timeout 120 build/matrig-board --serial "pty:$tty" --flash "$tmp/flash" --times typical "$@" 2>"$tmp/board" &
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
    timeout 100 build/matrig flash "pty:$tty" "$@" --baud 460800 >"$tmp/said" 2>"$tmp/err"
    local status=$?
    cat "$tmp/said" "$tmp/err"
    return $status
}
with_stm32flash() {
    timeout 60 stm32flash -m 8n1 -b 460800 "$@" "$tty" >"$tmp/out" 2>&1
    local status=$?
    tr '\r' '\n' <"$tmp/out" | tail -n 12
    return $status
}

flashes() { # FILE: the whole of it; the board runs it; the configuration is as it was
    fresh_flash && start_board --boot0 && flash --boot0 "$1" && stop_board &&
        grep -q 'board  *runs it' "$tmp/said" && grep -q 'configuration kept' "$tmp/said" &&
        grep -q 'erased *sectors 0, 4; ' "$tmp/said" && program_there $firmware/matrig.bin && configuration_kept
}
stm32flash_too() { # in two parts, and verified by itself
    fresh_flash && start_board --boot0 && with_stm32flash -w $firmware/program.bin -v -S 0x08010000 &&
        with_stm32flash -w $firmware/vectors.bin -v -S 0x08000000 || return 1
    stop_board && program_there $firmware/matrig.bin && configuration_kept
}
# The firmware that runs gives way. What it runs already is not flashed; the same program of another commit is sector 0 alone.
from_the_firmware() {
    start_board && flash $firmware/matrig.bin && grep -q 'runs it already' "$tmp/said" || return 1
    cp $firmware/matrig.elf "$tmp/other.elf" && build/firmware/stamp "$tmp/other.elf" 0123456789ab-dirty &&
        flash "$tmp/other.elf" --enter && grep -q 'the same program, another header' "$tmp/err" &&
        grep -q 'erased *sectors 0; ' "$tmp/said" && grep -q '^commit  *0123456789ab-dirty$' "$tmp/said" &&
        grep -q 'board  *runs it' "$tmp/said" && stop_board && configuration_kept
}
compares() { # the board with files
    start_board && build/matrig board --serial "pty:$tty" --image $firmware/matrig.bin >"$tmp/said" || return 1
    cat "$tmp/said"
    grep -q "^commit  *$(cat $firmware/commit)\$" "$tmp/said" && grep -q "^image  *whole\$" "$tmp/said" && grep -q "^it runs that  *yes" "$tmp/said" || return 1
    build/matrig --json board --serial "pty:$tty" --image build/tests/variant/rest.elf >"$tmp/json"
    [ $? -eq 1 ] && grep -q '"same":false,"difference":"program ' "$tmp/json" && stop_board
}
over_a_socket() { # which has no rate of its own: what both ends speak is the board's option
    fresh_flash
    timeout 60 build/matrig-board --boot0 --serial "unix:$tmp/rom" --baud 115200 --parity even --flash "$tmp/flash" --times typical \
        2>"$tmp/board" &
    board=$!
    timeout 60 build/matrig flash "unix:$tmp/rom" build/tests/hil/images/talk.elf --boot0 --force --stay || return 1
    stop_board && cmp -n 8 <(arm-none-eabi-objcopy -O binary build/tests/hil/images/talk.elf /dev/stdout) "$tmp/flash" && configuration_kept
}

# An image without a header: enough to be broken off in, and short.
small_image() { # BYTES of program
    perl -e 'srand(9); print pack("VV", 0x20001000, 0x08010001), "\x11" x 500, "\xff" x (0x10000 - 508), join("", map chr(int(rand(256))), 1 .. $ARGV[0])' \
        "$1" >"$tmp/small.bin"
}
damaged_on_the_way() { # some 40 bits to the board and 40 from it: each is noticed, and what is there is right
    local in out
    small_image 32000 && fresh_flash
    printf 'matrig-faults 1\nseed 3\nat 0.001 serial in corrupt all p 0.0012\nat 0.001 serial out corrupt all p 0.0006\n' >"$tmp/faults"
    start_board --boot0 --faults "$tmp/faults" && flash --boot0 "$tmp/small.bin" --force --stay || return 1
    stop_board || return 1
    in=$(grep -c 'serial in: .*' "$tmp/board") out=$(grep -c 'serial out: .*' "$tmp/board")
    echo "$in bits to the board, $out from it"
    [ "$in" -ge 25 ] && [ "$out" -ge 25 ] && grep -q '^repeated  *[1-9][0-9]* exchanges$' "$tmp/said" &&
        cmp -i 65536 -n 32000 "$tmp/small.bin" "$tmp/flash" && cmp -n 508 "$tmp/small.bin" "$tmp/flash" && configuration_kept
}
# pulled_after BYTES FILE: a cable that is pulled after so many bytes to the board; the boot ROM stays where it is.
pulled_after() {
    local cable
    stty -F "$tty" 460800 raw -echo
    rm -f "$tmp/cable"
    perl -MSocket -e '
        my ($tty, $path, $left) = @ARGV;
        open(my $board, "+<", $tty) or die "$tty: $!";
        socket(my $listener, AF_UNIX, SOCK_STREAM, 0); bind($listener, pack_sockaddr_un($path)) or die "$path: $!"; listen($listener, 1);
        alarm 30; accept(my $host, $listener) or die;
        while ($left > 0) {
            my $in = ""; vec($in, fileno($board), 1) = vec($in, fileno($host), 1) = 1;
            select(my $out = $in, undef, undef, undef);
            if (vec($out, fileno($host), 1)) {
                my $n = sysread($host, my $bytes, $left) or last;
                syswrite($board, $bytes); $left -= $n;
            }
            if (vec($out, fileno($board), 1)) { sysread($board, my $bytes, 4096); syswrite($host, $bytes); }
        }' "$tty" "$tmp/cable" "$1" &
    cable=$!
    timeout 30 build/matrig flash "unix:$tmp/cable" "$2" --boot0 --force --stay >"$tmp/said" 2>"$tmp/err"
    local status=$?
    cat "$tmp/err"
    wait $cable
    [ $status -eq 3 ] && grep -q 'run it again: it goes on where it was' "$tmp/err"
}
pulled_ten_times() {
    local bytes
    small_image 12000 && fresh_flash && start_board --boot0 || return 1
    for bytes in 20 61 300 700 1000 1400 1800 2200 2600 3001; do
        pulled_after $bytes "$tmp/small.bin" || return 1
    done
    flash "$tmp/small.bin" --boot0 --force --stay && grep -q '^written .*, resumed$' "$tmp/said" && grep -Eq '^were there +[1-9][0-9]$' "$tmp/said" && stop_board &&
        cmp -i 65536 -n 12000 "$tmp/small.bin" "$tmp/flash" && cmp -n 508 "$tmp/small.bin" "$tmp/flash" && configuration_kept
}
half_a_program_does_not_start() { # power off and on, BOOT0 low: the board is in its boot ROM all the same
    small_image 12000 && fresh_flash && start_board --boot0 && pulled_after 1500 "$tmp/small.bin" && stop_board || return 1
    start_board && flash "$tmp/small.bin" --boot0 --force --stay && grep -q resumed "$tmp/said" && stop_board &&
        cmp -i 65536 -n 12000 "$tmp/small.bin" "$tmp/flash" && configuration_kept
}
protected() {
    local i done=1
    for i in 1 2 3; do # it does not ask again when a busy computer answers late
        start_board --boot0 && with_stm32flash -j && done=0 && break
        stop_board
    done
    [ $done = 0 ] && stop_board && start_board --boot0 || return 1
    fails_with 2 'the chip is read-protected: .*stm32flash -k' build/matrig --quiet flash "pty:$tty" $firmware/matrig.elf --boot0 --baud 460800
    local found=$?
    stop_board && return $found
}
not_during_a_landing() { # the run file arms in the first second
    rm -f "$tmp/flash" && start_board --elf $firmware/matrig.elf --rig tests/runs/landing5.run --speed real || return 1
    sleep 10 <"$tty" &
    sleep 1.5
    fails_with 2 'does not leave a landing \(it is (armed|landing)\)' build/matrig --quiet flash "pty:$tty" build/tests/variant/rest.elf --enter
    local found=$?
    kill $! "$board"
    wait "$board"
    board=
    return $found
}
nobody_there() {
    start_board --elf $firmware/matrig.elf || return 1 # it runs, and so there is no boot ROM
    fails_with 3 'no boot ROM, something else speaks there: .*--enter' build/matrig flash "pty:$tty" $firmware/matrig.elf --boot0 --baud 460800
    local found=$?
    stop_board && return $found
}
refused() { # before any board is spoken to
    local elf=$firmware/matrig.elf
    cp $elf "$tmp/notes.txt" && head -c 100 README.md >"$tmp/text" && : >"$tmp/empty.bin" || return 1
    fails_with 4 'another machine' build/matrig flash serial:/dev/null build/matrig &&
        fails_with 4 'an empty file' build/matrig flash serial:/dev/null "$tmp/empty.bin" &&
        fails_with 4 'neither ELF nor Intel HEX' build/matrig flash serial:/dev/null "$tmp/text" &&
        fails_with 3 'no firmware image' build/matrig flash serial:/dev/null "$tmp/nowhere.hex" &&
        fails_with 2 "without matrig's header" build/matrig flash serial:/dev/null build/tests/hil/images/talk.elf &&
        fails_with 3 'no serial port' build/matrig flash serial:/dev/nowhere $elf &&
        fails_with 2 'carries no serial bytes' build/matrig flash can:can0 $elf &&
        fails_with 2 'a file is no board' build/matrig flash file:x $elf &&
        fails_with 2 'give one' build/matrig flash serial:/dev/null $elf --enter --boot0 &&
        fails_with 2 'promises 115200 baud at most .AN3155.' build/matrig flash serial:/dev/null $elf --baud 230400 &&
        fails_with 2 'out of range: 300 for --baud' build/matrig flash serial:/dev/null $elf --baud 300 &&
        fails_with 2 'something is missing' build/matrig flash serial:/dev/null || return 1
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

check "matrig flash programs and verifies a .hex, and the board runs it" flashes $firmware/matrig.hex
check "stm32flash does so too; in two parts it spares the configuration" stm32flash_too
check "matrig board compares the image that runs with a file" compares
check "the firmware gives way to the boot ROM; what is there is not written again" from_the_firmware
check "over a socket" over_a_socket
check "bits damaged on the way are noticed and made good" damaged_on_the_way
check "broken off ten times, then resumed" pulled_ten_times
check "half a program does not start" half_a_program_does_not_start
check "read protection is told" protected
check "a landing is not interrupted" not_during_a_landing
check "nobody there is told" nobody_there
check "what is no image or no board is refused" refused
check "linked again, the image is the same" same_from_the_same
finish
