#!/usr/bin/env bash
# What a link itself sees - CAN error frames here - is recorded and told; and which program links which library.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig

played --elf build/firmware/matrig.elf --can "file:$tmp/all.can" --serial none \
    --rig tests/runs/landing5.run 2>"$tmp/board.err"
# Before the landing one error frame, in its middle bus off with 50 frames lost and the restart, then no
# acknowledgement twice.
awk 'function fault(id, data) { print $1, "can0", id "#" data }
     NR == 20 { fault("20000004", "0004000000000000") }
     NR == 12000 { fault("20000040", "0000000000000000") }
     NR >= 12000 && NR < 12050 { next }
     NR == 12050 { fault("20000100", "0000000000000000") }
     NR == 15000 || NR == 15001 { fault("200000A8", "0000001900000000") }
     { print }' "$tmp/all.can" >"$tmp/faults.can"
log() { $matrig log --all --can "file:$tmp/faults.can" --db "$tmp/faults.db" >"$tmp/faults.txt" 2>"$tmp/faults.err"; }
db() { sqlite3 "$tmp/faults.db" "$1"; }

told() {
    cat "$tmp/faults.err"
    grep -q "^matrig: file:.*faults.can: bus off: 1$" "$tmp/faults.err" &&
        grep -q "^matrig: .*: restarted after bus off: 1$" "$tmp/faults.err" &&
        [ "$(grep -Ec "^matrig: .*: (no acknowledgement|protocol error|bus error): 1$" "$tmp/faults.err")" = 3 ]
}
summary_says() {
    cat "$tmp/faults.txt"
    grep -q "^  CAN link      bus off 1, restarted after bus off 1, no acknowledgement 2, protocol error 2, bus error 2$" "$tmp/faults.txt" &&
        grep -q "^ *CAN  *50  frame  *all  *lost while the adapter was off the bus " "$tmp/faults.txt" &&
        grep -q "^CAN link in this session: bus off 1, restarted after bus off 1, error warning 1, " "$tmp/faults.txt"
}
recorded() {
    echo "$(db "select code, detail from events where kind = 'can-link' order by id")"
    [ "$(db "select sum(detail) from events where kind = 'can-link' and code = 5 and landing = 1")" = 2 ] &&
        [ "$(db "select count(*) from frames where can_id & 0x20000000")" = 5 ] &&
        [ "$(db "select outside from links")" = 0 ] && [ "$(db "select lost from links")" = 50 ] &&
        [ "$(db "select received from links")" = $(($(wc -l <"$tmp/all.can") - 50)) ]
}
in_json() {
    $matrig --json --quiet log --can "file:$tmp/faults.can" --db "$tmp/json.db" >"$tmp/faults.json"
    grep -qF '"troubles":{"bus off":1,"restarted after bus off":1,"error warning":1,"no acknowledgement":2,' "$tmp/faults.json"
}
# A named pipe to which nothing writes: the log says so and ends by a signal; one that gets its writer late is read.
pipe_without_writer() {
    mkfifo "$tmp/pipe"
    timeout -k 60 250 $matrig log --can "file:$tmp/pipe" --db "$tmp/pipe.db" >/dev/null 2>"$tmp/pipe.err" &
    local log=$!
    await grep -q 'no hello from a board: file:.*/pipe; no frame in' "$tmp/pipe.err" && kill -TERM $log || return 1
    wait $log
    local status=$?
    echo "exit $status"
    [ $status -lt 124 ]
}
pipe_with_a_late_writer() {
    $matrig log --can "file:$tmp/pipe" --db "$tmp/late.db" >"$tmp/late" 2>"$tmp/late.err" &
    local log=$!
    await grep -q 'no frame in' "$tmp/late.err" && cat "$tmp/all.can" >"$tmp/pipe" && wait $log && grep -q '^RUN 1: landing 5, done' "$tmp/late"
}
no_line_end() { # what never ends and never is a line
    timeout -k 60 250 $matrig log --can file:/dev/zero --db "$tmp/zero.db" >/dev/null 2>"$tmp/zero.err"
    local status=$?
    cat "$tmp/zero.err"
    [ $status = 4 ] && grep -q '^matrig: the file has no end of line in [0-9]* bytes: file:/dev/zero; ' "$tmp/zero.err"
}
needs() { readelf -d "$1" | sed -n 's/.*(NEEDED).*\[\(lib[a-z]*\).*/\1/p'; }
libraries_apart() {
    needs $matrig; needs build/matrig-board
    needs $matrig | grep -qx libserialport && ! needs $matrig | grep -q libunicorn &&
        needs build/matrig-board | grep -qx libunicorn && ! needs build/matrig-board | grep -q libserialport
}

check "a log with error frames is logged" log
check "each is told at once" told
check "landing and session name them, and why frames are lost" summary_says
check "the campaign has them, and the counts are right" recorded
check "the JSON has them" in_json
check "a pipe without a writer ends by a signal" pipe_without_writer
check "a pipe with a late writer is read" pipe_with_a_late_writer
check "a device without an end of line is refused" no_line_end
check "libserialport only in matrig, Unicorn only in matrig-board" libraries_apart
finish
