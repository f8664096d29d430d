#!/usr/bin/env bash
# A board's health from the host: log tells of a processor fault and of CAN, board health, self-test and reset.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

# Clears the Thumb bit of SysTick's vector at 1 s, and sets it again when the board has been reset by that.
printf 'matrig-faults 1\nat 1.0 flip 0x0800003c 0\nat 1.005 + 6000 flip 0x0800003c 0\nat 2 bus unplug\nat 3.5 bus connect\n' >"$tmp/faults"

one() { python3 -c 'import json,sys; print(json.load(open(sys.argv[1]))'"$2"')' "$1"; }

a_fault_is_logged() {
    build/matrig-board --elf $elf --serial "file:$tmp/serial" --can "file:$tmp/can" --faults "$tmp/faults" --for 5 2>"$tmp/board.err" || return 1
    build/matrig log --all --serial "file:$tmp/serial" --can "file:$tmp/can" --db "$tmp/log.db" >"$tmp/log.txt" 2>&1 || return 1
    cat "$tmp/log.txt"
    grep -Eq 'the board restarted after a usage fault at 0x080[0-9a-f]{5}' "$tmp/log.txt" &&
        grep -q 'no acknowledgement: unplugged\|works again after 1\.[45][0-9] s; 1 outage since' "$tmp/log.txt" &&
        [ "$(sqlite3 "$tmp/log.db" "select count(distinct code), count(*) from events where kind = 'crash'")" = '42|42' ] &&
        [ "$(sqlite3 "$tmp/log.db" "select group_concat(distinct code) from events where kind = 'can-state' and code = 3")" = 3 ]
}
health_is_told() {
    with_board --serial "unix:$sockets/serial" --faults "$tmp/faults" -- build/matrig --quiet --json board --serial "unix:$sockets/serial" health >"$tmp/health.json"
    [ $? = 1 ] || return 1 # there was a fault
    cat "$tmp/health.json"
    [ "$(one "$tmp/health.json" "['restarts']")" = 1 ] && one "$tmp/health.json" "['crash']['text']" | sed -E 's/.* at (0x[0-9a-f]+),.*/\1/' | xargs arm-none-eabi-addr2line -fe $elf | grep -qx systick &&
        [ "$(one "$tmp/health.json" "['brown_out']")" = off ] && [ "$(one "$tmp/health.json" "['stack_size']")" = 4096 ]
}
a_sound_board_is_told_as_such() { with_board --serial "unix:$sockets/serial" -- build/matrig --quiet board --serial "unix:$sockets/serial" health >"$tmp/sound.txt" && cat "$tmp/sound.txt" &&
    grep -q '^CAN  *good' "$tmp/sound.txt" && ! grep -q fault "$tmp/sound.txt"; }
self_test_passes() { with_board --serial "unix:$sockets/serial" -- build/matrig --json --quiet board --serial "unix:$sockets/serial" self-test >"$tmp/test.json" && cat "$tmp/test.json" &&
    [ "$(one "$tmp/test.json" "['failed']")" = 0 ] && [ $(($(one "$tmp/test.json" "['done']") & 127)) = 127 ]; }
self_test_fails() {
    printf 'matrig-faults 1\nat 0 lamp broken\n' >"$tmp/lamp"
    with_board --serial "unix:$sockets/serial" --faults "$tmp/lamp" -- build/matrig --quiet board --serial "unix:$sockets/serial" self-test >"$tmp/test.txt"
    [ $? = 1 ] && cat "$tmp/test.txt" && grep -q 'warning lamp, on  *FAILED' "$tmp/test.txt"
}
it_restarts() { with_board --serial "unix:$sockets/serial" -- build/matrig --quiet board --serial "unix:$sockets/serial" reset && grep -q 'resets 1,' "$tmp/board.err"; }

check "log tells of a processor fault and of CAN, and keeps the words" a_fault_is_logged
check "board health: restart, fault, whose address names the function" health_is_told
check "board health of a sound board" a_sound_board_is_told_as_such
check "board self-test passes" self_test_passes
check "board self-test names what fails" self_test_fails
check "board reset" it_restarts
check "board health takes no number" fails_with 2 "health takes no number: '3'" build/matrig board --serial unix:x health 3
finish
