#!/usr/bin/env bash
# Linked emulated boards: two on one CAN bus in one process, one log of the bus, a serial link each (hil/board/canbus.h; tests/hil/test_bus.c).
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
board=build/matrig-board
elf=build/firmware/matrig.elf
runs=tests/runs
for_s=2 # armed at 0.8 s, the first switch opens at 1.5 s
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$sockets"' EXIT

# Each at its own base for what its run file says to it; the images have base 0, so the second is armed by nobody but the first.
both() { # NAME
    $board --elf $elf --for $for_s --can "file:$tmp/$1.can" --serial "file:$tmp/$1.1.serial" --rig $runs/landing5.run \
        --and --serial "file:$tmp/$1.2.serial" --rig $runs/landing4.run --can-base 512 --temperature 30 2>"$tmp/$1.err"
}
# hello's second message: words 0 and 1 of the chip's identity, least byte first
identities() { awk '$3 ~ /^1F1#/ { print $3 }' "$1" | sort | uniq -c | awk '{ print $1, $2 }'; }
both_speak() {
    cat "$tmp/one.err"
    identities "$tmp/one.can"
    [ "$(identities "$tmp/one.can" | wc -l)" = 2 ] && identities "$tmp/one.can" | grep -q ' 1F1#420031000F504758$' &&
        identities "$tmp/one.can" | grep -q ' 1F1#430031000F504758$'
}
counted() { # what the log has is what both say that they sent, and what the bus says that was good
    local first second all bad host
    first=$(sed -n 's/^matrig-board: board 1: .* CAN \([0-9]*\) out.*/\1/p' "$tmp/one.err")
    second=$(sed -n 's/^matrig-board: board 2: .* CAN \([0-9]*\) out.*/\1/p' "$tmp/one.err")
    all=$(sed -n 's/^matrig-board: CAN bus: \([0-9]*\) frames, load .* %, bad .*/\1/p' "$tmp/one.err")
    bad=$(sed -n 's/^matrig-board: CAN bus: .*, bad \([0-9]*\)$/\1/p' "$tmp/one.err")
    host=2 # commands of both run files; and one may be under way at the end
    echo "$first and $second sent, $all on the bus, $bad bad, $(wc -l <"$tmp/one.can") in the log"
    [ "$first" -gt 1000 ] && [ "$second" -gt 1000 ] && [ "$(wc -l <"$tmp/one.can")" = $((first + second)) ] &&
        [ $((all - first - second - bad - host)) -ge 0 ] && [ $((all - first - second - bad - host)) -le 1 ]
}
in_order() { # on one wire: each frame ends 47 us or more after the one before (44 bits, 3 of intermission; the log has whole microseconds)
    awk -F '[(). ]' '{ t = $2 * 1000000 + $3; if (NR > 1 && t - before < 46) { print; bad = 1 } before = t } END { exit bad || NR < 1000 }' "$tmp/one.can"
}
same_again() {
    both two || return 1
    for file in can 1.serial 2.serial; do cmp "$tmp/one.$file" "$tmp/two.$file" || return 1; done
}
measured() { # NAME: every block of the record, as bytes
    build/matrig --quiet log --serial "file:$tmp/$1.serial" --db "$tmp/$1.db" >/dev/null &&
        sqlite3 "$tmp/$1.db" "select idx, hex(record) from blocks order by idx" >"$tmp/$1.blocks" && [ "$(wc -l <"$tmp/$1.blocks")" -gt 1000 ]
}
measures_as_alone() {
    played --elf $elf --for $for_s --can none --serial "file:$tmp/alone1.serial" --rig $runs/landing5.run || return 1
    played --elf $elf --for $for_s --can none --serial "file:$tmp/alone2.serial" --rig $runs/landing4.run --temperature 30 || return 1
    for i in 1 2; do
        measured "one.$i" && measured "alone$i" && cmp "$tmp/one.$i.blocks" "$tmp/alone$i.blocks" || return 1
    done
    ! cmp -s "$tmp/one.1.blocks" "$tmp/one.2.blocks"
}
collisions_are_told() { grep -Eq '^matrig-board: CAN bus: [0-9]+ times two boards sent the same identifier .*; give each its own' "$tmp/one.err"; }
each_has_its_link() { # a host at each: what it is told is that board's
    local board_pid uid
    timeout 60 $board --elf $elf --for 60 --serial "unix:$sockets/1" --and --serial "unix:$sockets/2" 2>"$tmp/links.err" &
    board_pid=$!
    for i in 1 2; do
        build/matrig board --serial "unix:$sockets/$i" config get >"$tmp/link.$i" 2>&1 &
        eval "host_$i=\$!"
    done
    wait "$host_1" && wait "$host_2"
    local status=$?
    kill $board_pid && wait $board_pid
    tail -n 2 "$tmp/link.1" "$tmp/link.2" "$tmp/links.err"
    [ $status -eq 0 ] && [ "$(wc -l <"$tmp/link.1")" -gt 20 ] && cmp "$tmp/link.1" "$tmp/link.2"
}
one_resets() { # the power of the second goes for 300 ms: the first speaks on, the second comes back
    printf 'matrig-faults 1\nat 0.5 power-cut 300\n' >"$tmp/cut.faults"
    $board --elf $elf --for 1.2 --can "file:$tmp/cut.can" --and --faults "$tmp/cut.faults" 2>"$tmp/cut.err"
    cat "$tmp/cut.err"
    grep -q '^board 2: fault at 0\.500000[0-9]* s: power cut for 300 ms (line 2)$' "$tmp/cut.err" || return 1
    awk -F '[(). ]' '{ t = $2 + $3 / 1000000 } t > 0.6 && t < 0.79 { n++ } END { exit n < 20 }' "$tmp/cut.can" &&
        [ "$(awk '$3 ~ /^1F1#43/ { print $1 }' "$tmp/cut.can" | awk -F '[(.)]' '$3 > 800000 || $2 > 0' | wc -l)" -ge 1 ]
}
one_stops() { # the firmware of the second hangs: the run ends, and says whose
    $board --for 2 --hang 0.1 --and --elf build/tests/hil/images/hang_loop.elf 2>"$tmp/hang.err"
    [ $? -eq 3 ] && cat "$tmp/hang.err" && grep -q '^matrig-board: board 2: stopped at 0\.1[0-9]* s: the firmware hangs' "$tmp/hang.err"
}
refusals() {
    fails_with 2 '--can behind --and: .* give it before --and' $board --for 1 --and --can none &&
        fails_with 2 '--gdb with --and: .*debug it alone' $board --gdb 0 --and --seed 2 &&
        fails_with 2 '--for behind --and' $board --and --for 1 || return 1
    fails_with 2 'one board and 3 more' $board --for 1 --and --and --and --and &&
        fails_with 2 'board 2: its chip has the identity of one before it.*--board-seed' $board --for 0.1 --board-seed 3 --and --board-seed 3 &&
        fails_with 2 '--serial and --serial are both .*/same; give each its own' $board --for 1 --serial "file:$tmp/same" \
            --and --serial "file:$tmp/same" || return 1
    for fault in 'bus dominant' 'bus short' 'can in drop 1' 'can in repeat 1'; do
        printf 'matrig-faults 1\nat 0.5 %s\n' "$fault" >"$tmp/refused.faults"
        fails_with 2 'refused.faults: line 2: .*--and.*run the board alone' $board --for 1 --and --faults "$tmp/refused.faults" || return 1
    done
}

check "two boards run on one bus" both one
check "both speak on it, each with its own identity" both_speak
check "the log has each frame once" counted
check "no two frames overlap" in_order
check "the same bytes again" same_again
check "each measures what it measures alone" measures_as_alone
check "the same identifiers from both are told" collisions_are_told
check "each has its own serial link" each_has_its_link
check "the power of one goes: the other speaks on, and the one comes back" one_resets
check "where one stops the run ends, and says which" one_stops
check "what cannot be with several boards is refused in one line" refusals
finish
