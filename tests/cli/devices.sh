#!/usr/bin/env bash
# A serial port on a pseudo-terminal (tests/link/unplugged.py) that is unplugged in the middle of a landing and plugged in again. Real ports,
# CAN cards and SLCAN adapters: tests/linux.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
here=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$here"' EXIT
db() { sqlite3 "$tmp/$1.db" "$2"; }
says() { grep -Eq -- "$1" "$2"; }

# A landing of 7 s, played in three; its middle happens while the port is away.
build/tests/link/longlanding "$tmp/short.can" "$tmp/short.serial" 1
unplugged() {
    local port kept blocks lost status
    python3 tests/link/unplugged.py "$here/port" "$tmp/short.serial" 200000 1.2 0.4 >"$tmp/port.txt" 2>&1 &
    port=$!
    await test -e "$here/port"
    timeout 600 $matrig log --listen --serial "serial:$here/port" --db "$tmp/port.db" >"$tmp/port.log" 2>"$tmp/port.err" &
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
# One that does not come back: what was seen, how long it was waited for, and what there is in its place.
it_stays_away() {
    python3 - $matrig "$tmp/away.db" >"$tmp/away" 2>&1 <<'PYTHON'
import os, pty, sqlite3, subprocess, sys, time
main, port = pty.openpty()
name = os.ttyname(port)
os.close(port)
log = subprocess.Popen([sys.argv[1], "--quiet", "log", "--serial", "serial:" + name, "--db", sys.argv[2], "--wait", "0.5"], stderr=subprocess.PIPE)
for _ in range(6000): # the port is open when the session has begun
    if os.path.exists(sys.argv[2]) and sqlite3.connect(sys.argv[2]).execute("SELECT name FROM sqlite_schema WHERE name='sessions'").fetchone():
        break
    time.sleep(0.01)
os.close(main)
print(log.communicate()[1].decode(), log.returncode)
PYTHON
    cat "$tmp/away"
    says "the device is gone: serial:/dev/pts/[0-9]*; plug it in again \(waited 0.5 s for it; now: no serial port \(No such file or directory\): .*; there (is none|are /dev/)" "$tmp/away" &&
        says '^ 3$' "$tmp/away"
}
check "one that stays away is told with the ports that there are" it_stays_away
finish
