#!/usr/bin/env bash
# What happens beside the runway while matrig log is at work under full load: killed, disk full, clock set, a second one. What the
# database has and what the user is told; tests/soak_host/sender.c knows what was sent, and what had been read.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
# In memory where that can be: how long a busy disk takes to write is not what is tried here.
dbs=$(mktemp -d /dev/shm/matrig.XXXXXX 2>/dev/null) || dbs=$tmp
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$sockets"; [ "$dbs" = "$tmp" ] || rm -rf "$dbs"' EXIT
faults="LD_PRELOAD=build/tests/link/faults.so"

# begin NAME SECONDS [VARIABLE=VALUE...]: sender and logger in the background, into NAME.db
begin() {
    local name=$1 seconds=$2
    shift 2
    build/tests/soak_host/sender "$sockets/$name.can" "$sockets/$name.serial" "$seconds" 0 "$tmp/$name.marks" >"$tmp/$name.sent" 2>"$tmp/$name.sender" &
    sender=$!
    env "$@" $matrig log --listen --can "unix:$sockets/$name.can" --serial "unix:$sockets/$name.serial" --db "$dbs/$name.db" \
        >"$tmp/$name.txt" 2>"$tmp/$name.err" &
    logger=$!
}
db() { sqlite3 "$dbs/$1.db" "$2"; }
fills_in() { db "$1" "select count(*) from frames where link = 0 and can_id = 1365"; }
sent() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/$1.sent') as text), '\$.$2')"; }
has_come() { [ "$(fills_in "$1")" -ge "$2" ]; } # 6,600 a second; the landing is from 1.2 to 7.6 s
intact() { [ "$(db "$1" 'pragma integrity_check')" = ok ]; }

# Killed in mid-landing: of what the logger had read 100 ms before, and waited for a processor since, nothing is lost.
kept_but_100_ms() { # TRY
    local before delay_us killed_us read kept
    begin "kill$1" 30
    await has_come "kill$1" $((15000 + 2700 * $1)) || return 1
    before=$(waited_us $logger)
    sleep 0.25
    delay_us=$(($(waited_us $logger) - before))
    killed_us=$(($(date +%s%N) / 1000))
    kill -9 $logger
    wait $logger $sender 2>/dev/null
    read=$(awk -v at=$((killed_us - 100000 - delay_us)) '$1 <= at { n = $2 } END { print n + 0 }' "$tmp/kill$1.marks")
    kept=$(fills_in "kill$1")
    echo "read 100 ms before the kill: $read; in the campaign: $kept; waited for a processor $delay_us us"
    [ "$read" -gt 5000 ] && [ "$kept" -ge "$read" ] && intact "kill$1" && [ "$(db "kill$1" 'select state from landings')" = 2 ] &&
        [ "$(db "kill$1" 'select max(substr(hex(data), 7, 2) || substr(hex(data), 5, 2) || substr(hex(data), 3, 2) || substr(hex(data), 1, 2)) from frames where can_id = 1365')" = \
            "$(printf %08X $((kept - 1)))" ]
}
killed_three_times() { kept_but_100_ms 1 && kept_but_100_ms 2 && kept_but_100_ms 3; }
the_next_log_goes_on() { # into the same campaign, and the landing that was cut off is told
    mv "$dbs/kill1.db" "$dbs/next.db" && { mv "$dbs/kill1.db-wal" "$dbs/next.db-wal"; rm -f "$dbs/kill1.db-shm"; } 2>/dev/null
    begin next 9
    wait $logger && wait $sender && $matrig --quiet report "$dbs/next.db" -o "$tmp/next.html" && grep -q 'RUN 1: landing 1' "$tmp/next.html" &&
        grep -q '^RUN 2: landing 1, done' "$tmp/next.txt" && intact next
}

# The disk is full in the middle of a landing, and the log is ended while it waits for room; tests/cli/log-hold.sh has more of waiting.
disk_full() {
    local status read
    begin full 30 "$faults" "DISK_FULL=$tmp/full.now:full.db"
    await has_come full 15000 || return 1
    local before at_us
    before=$(waited_us $logger)
    sleep 0.25
    at_us=$(($(date +%s%N) / 1000 - $(waited_us $logger) + before))
    touch "$tmp/full.now"
    await grep -q "^matrig: the disk of the campaign is full: waiting for space" "$tmp/full.err" || return 1
    kill -INT $logger
    await bash -c "! kill -0 $logger" || return 1
    wait $logger
    status=$?
    rm "$tmp/full.now"
    wait $sender
    cat "$tmp/full.err"
    read=$(awk -v at=$((at_us - 100000)) '$1 <= at { n = $2 } END { print n + 0 }' "$tmp/full.marks")
    echo "exit $status; read 100 ms before: $read; kept $(fills_in full)"
    [ $status = 3 ] &&
        grep -Eq "^matrig: .*/full.db accepted no more data \(cannot write \(database or disk is full; [a-z0-9.]+ at /[^)]*\): .*full.db; free space on the disk\); the data logged is in .*/full-saved-.*\.db$" "$tmp/full.err" &&
        [ "$read" -gt 3000 ] && [ "$(fills_in full)" -ge "$read" ] && intact full
}
after_that_it_goes_on() { # with room again, the same campaign takes the next landing, and shows what it has of the other
    begin full 9
    wait $logger && wait $sender && intact full && grep -q '^RUN 2: landing 1, done' "$tmp/full.txt" &&
        $matrig --quiet report "$dbs/full.db" -o "$tmp/full.html" && grep -q 'RUN 1: landing 1' "$tmp/full.html"
}

# Somebody sets this computer's clock by an hour, back or forward, in a landing; and a second one starts to log into the campaign.
clock_set() { # NAME SECONDS
    begin "$1" 9 "$faults" "CLOCK_JUMP=$tmp/$1.now:$2"
    await has_come "$1" 20000 || return 1
    touch "$tmp/$1.now"
    wait $logger
    local status=$?
    wait $sender
    cat "$tmp/$1.err"
    db "$1" "select kind, landing, value from events where kind = 'clock-set'"
    [ $status = 0 ] && grep -Eq "^matrig: the clock of this computer was changed by \\$3 s: times of day before and after" "$tmp/$1.err" &&
        [ "$(db "$1" "select count(*), abs(value - ($2) * 1000000) < 1000, landing from events where kind = 'clock-set'")" = "1|1|1" ] &&
        [ "$(fills_in "$1")" = "$(sent "$1" fills)" ] && [ "$(db "$1" 'select sum(lost + bad) from links')" = 0 ] &&
        grep -q "^RUN 1: landing 1, done" "$tmp/$1.txt" && grep -q "^  stop  *79\.56[0-9] " "$tmp/$1.txt" # 3 + 35^2 / 16
}
back() { clock_set back -3600 "-3600\.000"; }
forward() { clock_set forward 3600 "+3600\.000"; }

second_writer() {
    begin first 9
    await has_come first 12000 || return 1
    fails_with 3 "^matrig: another program writes to this campaign .matrig log.: .*first.db; end that program first, or give a different database" \
        $matrig log --can "file:$tmp/nothing" --db "$dbs/first.db" || return 1
    $matrig landing "$dbs/first.db" 1 --note "a note beside it" || return 1 # people go on writing
    wait $logger && wait $sender || return 1
    cat "$tmp/first.err"
    [ "$(fills_in first)" = "$(sent first fills)" ] && [ "$(db first 'select sum(lost + bad) from links')" = 0 ] && intact first &&
        [ "$(db first 'select count(*) from sessions')" = 1 ] && grep -q "^RUN 1: landing 1, done" "$tmp/first.txt"
}

# What is said goes to a terminal that was stopped (Ctrl-S) until the landing is over: the campaign does not wait, and the summary comes.
cat >"$tmp/stopped.py" <<'P'
import os, pty, subprocess, sys, termios, threading, time
master, terminal = pty.openpty()
termios.tcflow(terminal, termios.TCOOFF)
logger = subprocess.Popen(sys.argv[3:], stdin=subprocess.DEVNULL, stdout=terminal, stderr=terminal)
until = time.monotonic() + 60
while not os.path.exists(sys.argv[1]) and time.monotonic() < until:
    time.sleep(0.05)
os.path.exists(sys.argv[1]) or logger.kill()
said = open(sys.argv[2], "wb")
def read():
    while True:
        said.write(os.read(master, 4096))
        said.flush()
threading.Thread(target=read, daemon=True).start()
termios.tcflow(terminal, termios.TCOON)
code = logger.wait(30)
time.sleep(0.3)
sys.exit(code)
P
stopped_terminal() {
    build/tests/soak_host/sender "$sockets/stop.can" "$sockets/stop.serial" 12 0 >"$tmp/stop.sent" 2>&1 &
    TERM=xterm python3 "$tmp/stopped.py" "$tmp/stop.go" "$tmp/stop.said" $matrig log --listen --can "unix:$sockets/stop.can" --serial "unix:$sockets/stop.serial" \
        --db "$dbs/stop.db" &
    logger=$!
    await eval '[ "$(db stop "select state from landings")" = 4 ]' && touch "$tmp/stop.go" && wait $logger && grep -q '^RUN 1: landing 1, done' "$tmp/stop.said" &&
        intact stop
}

# The three that take longest side by side: most of it is waiting.
(killed_three_times >"$tmp/killed.out" 2>&1; echo $? >"$tmp/killed.code") &
killed=$!
check "ended while the disk is full: one clear error, and what was received 100 ms before is kept" disk_full
check "with room again the campaign goes on" after_that_it_goes_on
outcome() { cat "$tmp/$1.out"; [ "$(cat "$tmp/$1.code")" = 0 ]; }
wait $killed
check "killed with -9 in mid-landing, three times: what was received 100 ms before is kept" outcome killed
(second_writer >"$tmp/second.out" 2>&1; echo $? >"$tmp/second.code") &
second=$!
(back >"$tmp/backward.out" 2>&1; echo $? >"$tmp/backward.code") &
backward=$!
(stopped_terminal >"$tmp/stopped.out" 2>&1; echo $? >"$tmp/stopped.code") &
stopped=$!
(forward >"$tmp/forward.out" 2>&1; echo $? >"$tmp/forward.code") &
ahead=$!
check "the next log goes on in the campaign of a killed one" the_next_log_goes_on
wait $second $backward $ahead $stopped
check "a second log into the campaign is refused, the first unharmed, notes go on" outcome second
check "the clock set back an hour in a landing: told, recorded, nothing else" outcome backward
check "the clock set forward an hour in a landing: told, recorded, nothing else" outcome forward
check "its terminal is stopped: it goes on, and the summary comes later" outcome stopped
finish
