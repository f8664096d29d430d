#!/usr/bin/env bash
# No board is understood on a link: nothing comes, or the rate is another one, or the bus has errors alone. Terminals: tests/link/wrongrate.py.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
here=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$here"' EXIT
played --elf build/firmware/matrig.elf --can "file:$tmp/idle.can" --serial "file:$tmp/idle.serial" \
    --rig tests/runs/landing1.run 2>"$tmp/board.err"

# sender BAUD: a port at that rate, $here/port, until gone
sender() {
    rm -f "$here/port" "$here/port.sent"
    python3 tests/link/wrongrate.py "$tmp/idle.serial" "$here/port" "$1" 2>"$tmp/port.err" &
    port=$!
    await test -L "$here/port"
}
gone() {
    kill $port 2>/dev/null
    wait $port 2>/dev/null
    cat "$tmp/err" "$tmp/port.err"
}
# heard SENDER-BAUD COMMAND...: the command's exit code, with the port of that sender in place of PORT
heard() {
    sender "$1" || return 99
    shift
    timeout 600 "${@//PORT/$here/port}" >"$tmp/out" 2>"$tmp/err" </dev/null
    local status=$?
    gone
    return $status
}
# logged SENDER-BAUD LINK-END UNTIL...: the exit code of matrig log, which is interrupted once UNTIL holds
logged() {
    sender "$1" || return 99
    timeout 600 $matrig --json log --serial "serial:$here/port$2" --db "$tmp/rate.db" >"$tmp/out" 2>"$tmp/err" </dev/null &
    local log=$! status
    await "${@:3}"
    kill -INT $log
    wait $log
    status=$?
    gone
    return $status
}
sent() { test "$(cat "$here/port.sent")" -ge "$1"; }
# says STATUS PATTERN SENDER LINK: matrig log, from a port of that sender
says() {
    logged "$3" "$4" sent 8000
    local status=$?
    echo "exit $status"
    [ $status = "$1" ] && grep -Eq -- "$2" "$tmp/err"
}
its_own_rate() { logged 2000000 '' sent 8000 && grep -q '"unheard":null' "$tmp/out"; }
garbled() { # SENDER
    says 3 "received [1-9][0-9]* bytes/s and [0-9]+ ends of frames, but no complete frame: check that the board sends at 2000000 baud" "$1" '' &&
        grep -q '"unheard":"garbled"' "$tmp/out"
}
cable_is_off() {
    mkfifo "$tmp/silent.fifo"
    sleep 30 >"$tmp/silent.fifo" &
    timeout 600 $matrig --json log --serial "file:$tmp/silent.fifo" --db "$tmp/silent.db" --for 0.5 >"$tmp/out" 2>"$tmp/err"
    local status=$?
    cat "$tmp/err"
    [ $status = 3 ] && grep -Eq 'no byte received in [0-9.]+ s: check that the board is on' "$tmp/err" && grep -q '"unheard":"silent"' "$tmp/out"
}
board_and_ready() {
    heard 1000000 $matrig board --serial serial:PORT; [ $? = 3 ] && grep -q 'check that the board sends at 2000000 baud' "$tmp/err" || return 1
    heard 1000000 $matrig ready "$tmp/ready.db" --serial serial:PORT; [ $? = 3 ] && grep -q 'check that the board sends at 2000000 baud' "$tmp/err"
}
# As SocketCAN tells them: bit stuffing errors, and nothing else; and a bus on which nobody speaks.
bus_errors() {
    for _ in $(seq 200); do echo '(1700000000.000000) can0 20000088#0000040000000000'; done >"$tmp/errors.can"
    fails_with 3 "only error frames received \(200\), most of them (protocol error|bus error): check that the bit rate is 1 Mbit/s and both ends of the bus are terminated" \
        $matrig --quiet log --can "file:$tmp/errors.can" --db "$tmp/errors.db"
}
no_frames() {
    : >"$tmp/none.can"
    fails_with 3 "no frame in [0-9.]+ s: check that the board is on and connected to this bus" $matrig --quiet log --can "file:$tmp/none.can" --db "$tmp/none.db"
}
told_while_waiting() { # after 3 s, and the log goes on
    logged 115200 '' grep -q 'but no complete frame: check that the board sends at 2000000 baud' "$tmp/err"
    [ $? = 3 ] && [ "$(grep -c 'but no complete frame: check that the board sends at 2000000 baud' "$tmp/err")" = 2 ]
}

check "a sender at the rate of the link" its_own_rate
check "another rate is told" garbled 115200
check "a cable that is off" cable_is_off
check "board and ready say the same, exit 3" board_and_ready
check "error frames alone on CAN" bus_errors
check "no frame at all on CAN" no_frames
check "told while a board is waited for" told_while_waiting
finish
