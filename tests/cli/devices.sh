#!/usr/bin/env bash
# A serial port on a pseudo-terminal (tests/link/unplugged.py) that is unplugged in the middle of a landing and plugged in again, also as an
# adapter that gets another name (tests/link/ports.c). Real ports, CAN cards and SLCAN adapters: tests/linux.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
here=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$here"' EXIT
db() { sqlite3 "$tmp/$1.db" "$2"; }
says() { grep -Eq -- "$1" "$2"; }

# A landing of 7 s, played in three; its middle happens while the port is away.
build/tests/link/longlanding "$tmp/short.can" "$tmp/short.serial" 1
unplugged() { # USB RETURNS OTHER, or nothing
    local port kept blocks lost status
    rm -f "$tmp"/port.*
    python3 tests/link/unplugged.py "$here/port" "$tmp/short.serial" 200000 1.2 0.4 "$@" >"$tmp/port.txt" 2>&1 &
    port=$!
    await test -e "$here/port"
    PORTS=$here ${1:+env LD_PRELOAD=build/tests/link/ports.so} timeout 600 \
        $matrig log --all --listen --serial "serial:$here/port" --db "$tmp/port.db" >"$tmp/port.log" 2>"$tmp/port.err" &
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

check "a serial port that is unplugged and plugged in again: what came is there, what did not is counted" unplugged
check "the landing goes on as one" the_landing_is_whole
rm "$here/port"
check "an adapter that returns by another name is taken by its USB identity, not the one that has its name" \
    unplugged "0403 6001 A50285BI" "$here/port1" "0403 6001 A5XK3RJT"
check "and the landing goes on as one" the_landing_is_whole
not_another_one() { # the same kind, without serial numbers: it may be anybody's
    rm -f "$here"/port*
    echo "- 1a86 7523 -" >"$here/port2"
    python3 tests/link/unplugged.py "$here/port" "$tmp/short.serial" 200000 0.3 1e9 "1a86 7523 -" >"$tmp/port.txt" 2>&1 &
    local port=$!
    await test -e "$here/port"
    PORTS=$here LD_PRELOAD=build/tests/link/ports.so fails_with 3 'waited 0.5 s for the device; now: no serial port \(No such file or directory\): serial:.*/port; there are .*/port2' \
        $matrig --quiet log --listen --serial "serial:$here/port" --db "$tmp/other.db" --wait 0.5
    local status=$?
    kill $port
    return $status
}
check "of two adapters that nothing tells apart the other one is not taken" not_another_one
not_there_yet() { # --wait counts from the first open on; without it, a port that is not there is told at once
    rm -f "$here"/port* "$tmp"/first.db
    fails_with 3 '^matrig: no serial port \(No such file or directory\): serial:' $matrig log --serial "serial:$here/port" --db "$tmp/first.db" || return 1
    timeout 600 $matrig log --all --listen --serial "serial:$here/port" --db "$tmp/first.db" --wait 300 >"$tmp/out" 2>"$tmp/err" &
    local log=$! status
    await grep -q '^matrig: no serial port .* (waiting 300 s for it)$' "$tmp/err" || return 1
    python3 tests/link/unplugged.py "$here/port" "$tmp/short.serial" 400000 1e9 0 >"$tmp/port.txt" 2>&1 || return 1
    kill -INT $log
    wait $log
    status=$?
    cat "$tmp/err"
    [ $status = 0 ] && [ "$(sqlite3 "$tmp/first.db" 'SELECT lost FROM links')" = 0 ] || return 1
    rm -f "$here/port" "$tmp/err"
    $matrig log --serial "serial:$here/port" --db "$tmp/none.db" --wait 300 >"$tmp/out" 2>"$tmp/err" &
    log=$!
    await grep -q waiting "$tmp/err" && kill -INT $log || return 1
    wait $log
    [ $? = 3 ] && [ ! -e "$tmp/none.db" ]
}
check "a port that is not there yet is waited for when asked, until Ctrl-C" not_there_yet
# One that does not come back: what was seen, how long it was waited for, and what there is in its place.
it_stays_away() {
    rm -f "$here/port"
    python3 - $matrig "$tmp/away.db" "$here/port" >"$tmp/away" 2>&1 <<'PYTHON'
import os, pty, sqlite3, subprocess, sys, time
main, port = pty.openpty()
os.symlink(os.ttyname(port), sys.argv[3]) # its number may be another program's soon
os.close(port)
log = subprocess.Popen([sys.argv[1], "--quiet", "log", "--serial", "serial:" + sys.argv[3], "--db", sys.argv[2], "--wait", "0.5"], stderr=subprocess.PIPE)
for _ in range(6000): # the port is open when the session has begun
    if os.path.exists(sys.argv[2]) and sqlite3.connect(sys.argv[2]).execute("SELECT name FROM sqlite_schema WHERE name='sessions'").fetchone():
        break
    time.sleep(0.01)
os.unlink(sys.argv[3])
os.close(main)
print(log.communicate()[1].decode(), log.returncode)
PYTHON
    cat "$tmp/away"
    says "the device was disconnected: serial:/tmp/.*/port; plug it in again \(waited 0.5 s for the device; now: no serial port \(No such file or directory\): .*; there (is none|are /dev/)" "$tmp/away" &&
        says '^ 3$' "$tmp/away"
}
check "one that stays away is told with the ports that there are" it_stays_away
finish
