#!/usr/bin/env bash
# Devices on pseudo-terminals (tests/link/adapter.py): a LAWICEL adapter through a landing of more than a minute, and a serial port that is
# unplugged in the middle of one and plugged in again. Real ports and CAN cards: tests/linux.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
here=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$here"' EXIT
db() { sqlite3 "$tmp/$1.db" "$2"; }
says() { grep -Eq -- "$1" "$2"; }

# 73 s of CAN, armed for 66 s of them; the clock of matrig passes as much faster as the adapter plays, once its channel is open.
build/tests/link/longlanding "$tmp/long.can" "$tmp/long.serial" 66
python3 tests/link/adapter.py slcan "$here/adapter" "$tmp/long.can" 10 59000 00,00,08,08,00,28,20 >"$tmp/adapter.txt" 2>&1 &
adapter=$!
await test -e "$here/adapter"
a_minute_over_slcan() {
    LD_PRELOAD=build/tests/link/faults.so CLOCK_RATE=$here/adapter.open:10 \
        timeout 120 $matrig log --listen --can "slcan:$here/adapter" --db "$tmp/slcan.db" >"$tmp/slcan.txt" 2>"$tmp/slcan.err" &
    local logger=$! status
    wait $adapter
    kill -INT $logger
    wait $logger
    status=$?
    cat "$tmp/adapter.txt" "$tmp/slcan.err"
    grep -v " lb\|ft " "$tmp/slcan.txt"
    [ $status = 0 ] && says "^RUN 1: landing 1, done" "$tmp/slcan.txt" && [ "$(db slcan 'select sum(lost + bad) from links')" = 0 ] &&
        [ "$(db slcan 'select count(*) from frames where can_id < 2048')" = "$(wc -l <"$tmp/long.can")" ]
}
every_frame() { # in order, bit by bit
    cmp <(db slcan "select printf('%03X#', can_id) || hex(data) from frames where can_id < 2048 order by id") <(awk '{print $3}' "$tmp/long.can")
}
stamps_wrap() { python3 tests/link/lossy.py stamps "$tmp/slcan.db" "$tmp/long.can"; }
status_flags() { # said: receive overflow three times, passive once and then still
    cat "$tmp/adapter.txt"
    says "^sent [0-9]+ .*08 2 .*28 1" "$tmp/adapter.txt" && says "CAN link in this session: error passive 1, receive overflow in the adapter 3(,|$)" "$tmp/slcan.txt" &&
        [ "$(db slcan "select sum(detail) from events where kind = 'can-link' and code = 9")" = 3 ]
}

# A landing of 7 s, played in three; its middle happens while the port is away.
build/tests/link/longlanding "$tmp/short.can" "$tmp/short.serial" 1
unplugged() {
    local port kept blocks lost status
    python3 tests/link/adapter.py serial "$here/port" "$tmp/short.serial" 200000 1.2 0.4 >"$tmp/port.txt" 2>&1 &
    port=$!
    await test -e "$here/port"
    timeout 60 $matrig log --listen --serial "serial:$here/port" --db "$tmp/port.db" >"$tmp/port.log" 2>"$tmp/port.err" &
    local logger=$!
    wait $port
    kill -INT $logger
    wait $logger
    status=$?
    read -r _ before _ after <"$tmp/port.txt"
    read -r kept blocks lost < <(python3 tests/link/lossy.py cut "$tmp/short.serial" "$before" "$after")
    cat "$tmp/port.txt" "$tmp/port.err"
    db port "select received, lost, bad from links"
    echo "whole $kept, of them blocks $blocks, not whole $lost"
    [ $status = 0 ] && [ "$lost" -gt 500 ] && [ "$(db port 'select received, lost from links')" = "$kept|$lost" ] &&
        [ "$(db port 'select count(*) from blocks')" = "$blocks" ] && says "port: went away: 1" "$tmp/port.err" && says "port: came back: 1" "$tmp/port.err"
}
the_landing_is_whole() { # as one landing, done; the hole has its cause
    cat "$tmp/port.log"
    says "^RUN 1: landing 1, done" "$tmp/port.log" && ! says "^RUN 2" "$tmp/port.log" && says "serial link  *went away 1, came back 1" "$tmp/port.log" &&
        [ "$(db port "select count(*), sum(count) from gaps where cause = 'away' and message = 'frame'")" = "1|$(db port 'select lost from links')" ]
}

check "an SLCAN adapter through a landing of more than a minute" a_minute_over_slcan
check "every frame is there" every_frame
check "its stamps, which begin again after a minute, twice, give the time" stamps_wrap
check "its status flags are told and recorded" status_flags
check "a serial port that is unplugged and plugged in again: what came is there, what did not is counted" unplugged
check "the landing goes on as one" the_landing_is_whole
finish
