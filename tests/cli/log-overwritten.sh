#!/usr/bin/env bash
# Somebody writes over the campaign while it is logged, in a landing: the file keeps its inode and gets another content (cp, a truncation),
# or sqlite3 puts another content into it. Told within 2 s; what came is in a campaign beside it, and the log goes on there. Those who only
# use the campaign alarm nobody. tests/soak_host/sender.c counts what was sent.
. "$(dirname "$0")/tap.sh"
matrig=${MATRIG:-build/matrig}
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
dbs=$(mktemp -d /dev/shm/matrig.XXXXXX 2>/dev/null) || dbs=$tmp # in memory: how long a busy disk takes is not what is tried
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$sockets"; [ "$dbs" = "$tmp" ] || rm -rf "$dbs"' EXIT
only=${ONLY:-.} # a pattern of the cases to try

# begin NAME SECONDS: sender and logger in the background, into NAME.db, of which NAME.backup is made before the landing, which is from 1.2 to
# 7.6 s
begin() {
    build/tests/soak_host/sender "$sockets/$1.can" "$sockets/$1.serial" "$2" 0 >"$tmp/$1.sent" 2>"$tmp/$1.sender" &
    sender=$!
    $matrig --json log --listen --can "unix:$sockets/$1.can" --serial "unix:$sockets/$1.serial" --db "$dbs/$1.db" \
        >"$tmp/$1.json" 2>"$tmp/$1.err" &
    logger=$!
    await has_come "$1" 1000 && sqlite3 "$dbs/$1.db" ".backup $dbs/$1.backup" && await has_come "$1" 15000
}
db() { sqlite3 -cmd '.timeout 5000' "$dbs/$1.db" "$2"; }
fills() { db "$1" "select count(*) from frames where link = 0 and can_id = 1365"; }
has_come() { [ "$(fills "$1")" -ge "$2" ]; }
told() { grep -Eq "$2" "$tmp/$1.err"; }
sent() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/$1.sent') as text), '\$.$2')"; }
json() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/$1.json') as text), '\$.$2')"; }
ends() { # STATUS: the logger's, and the sender's is 0
    local status sender_status
    wait $logger
    status=$?
    wait $sender
    sender_status=$?
    echo "exit $status, sender $sender_status"
    [ $status = "$1" ] && [ $sender_status = 0 ]
}
all_there() { # NAME DB: what was sent is in the campaign, to the frame, and the landing is one
    echo "sent $(cat "$tmp/$1.sent"); fills in $2: $(fills "$2"), links $(db "$2" 'select group_concat(received || "/" || lost || "/" || bad) from links')"
    [ "$(fills "$2")" = "$(sent "$1" fills)" ] && [ "$(db "$2" 'select sum(lost + bad) from links')" = 0 ] &&
        [ "$(db "$2" 'select received from links where link = 0')" = "$(sent "$1" can_sent)" ] &&
        [ "$(db "$2" 'select received from links where link = 1')" = "$(sent "$1" serial_sent)" ] &&
        [ "$(db "$2" 'select group_concat(state) from landings')" = 4 ] && [ "$(db "$2" 'pragma integrity_check')" = ok ]
}
# lost NAME WHAT COMMAND...: by the command the campaign is no longer what was logged
lost() {
    local name=$1 what=$2 saved from at
    shift 2
    begin "$name" 10 || return 1
    "$@" || return 1
    from=$EPOCHREALTIME
    await told "$name" "^matrig: $dbs/$name\.db $what while it was logged: all data received since [0-9:]+ was saved in .*, and the log continues there" ||
        { cat "$tmp/$name.err"; ends 3; return 1; }
    at=$EPOCHREALTIME
    ends 3 || { cat "$tmp/$name.err"; return 1; }
    cat "$tmp/$name.err"
    awk -v from="${from/,/.}" -v at="${at/,/.}" 'BEGIN { printf "told after %.2f s\n", at - from }'
    saved=$(json "$name" db)
    [[ $saved == $dbs/$name-saved-*.db ]] && [ "$(grep -c 'while it was logged:' "$tmp/$name.err")" = 1 ] &&
        all_there "$name" "$(basename "$saved" .db)"
}
over="was overwritten by another program"
# cp writes piece by piece: a page that the log has checked and writes in between would stay in the copy, or behind its end. Only checkpoints
# write into the file, under a lock of its index (https://sqlite.org/walformat.html, 2.3.1), so that is held meanwhile.
cat >"$tmp/alone.py" <<'P'
import fcntl, subprocess, sys
index = open(sys.argv[1] + "-shm", "r+b")
fcntl.lockf(index, fcntl.LOCK_EX, 1, 121)
subprocess.run(sys.argv[2:], check=True)
P
alone() { python3 "$tmp/alone.py" "$dbs/$1.db" "${@:2}"; }
copy() { alone "$1" cp "$dbs/$1.backup" "$dbs/$1.db"; }
copied() { # and stays what it was made: the journal of the one before is not put into it
    lost copied "$over" copy copied && cmp "$dbs/copied.db" "$dbs/copied.backup" && [ ! -e "$dbs/copied.db-wal" ] &&
        [ "$(db copied 'pragma integrity_check')" = ok ] && [ -s "$(echo "$dbs"/copied-journal-*.wal)" ]
}
cat >"$tmp/hold.py" <<'P'
import sqlite3, subprocess, sys, time
db = sqlite3.connect(sys.argv[1], timeout=20, isolation_level=None)
db.execute("BEGIN IMMEDIATE")
subprocess.run(["cp", sys.argv[2], sys.argv[1]], check=True)
time.sleep(1)
db.execute("ROLLBACK")
P
copy_under_lock() { python3 "$tmp/hold.py" "$dbs/$1.db" "$dbs/$1.backup"; }
locked() { lost locked "$over" copy_under_lock locked; }
truncate_it() { alone "$1" truncate -s 0 "$dbs/$1.db"; }
truncated() { lost truncated "$over" truncate_it truncated && [ ! -s "$dbs/truncated.db" ]; }
restore() { # by one transaction, when the log leaves room for it
    local i
    for i in {1..50}; do sqlite3 -cmd '.timeout 5000' "$dbs/$1.db" ".restore $dbs/$1.backup" 2>"$tmp/$1.restore" && [ ! -s "$tmp/$1.restore" ] && return; done
    cat "$tmp/$1.restore"
    return 1
}
restored() { # and stays what it was made
    lost restored "lost the logged data" restore restored && has_come restored 1000 && ! has_come restored 15000 &&
        [ "$(db restored 'pragma integrity_check')" = ok ]
}
copied_last() { # at the very end, before anybody could have noticed
    local saved
    begin last 30 && copy last && kill -INT $logger && ends 3
    local good=$?
    cat "$tmp/last.err"
    saved=$(basename "$(json last db)" .db)
    [ $good = 0 ] && [[ $saved == last-saved-* ]] && has_come "$saved" 15000 && [ "$(db "$saved" "select ended_by from sessions")" = signal ]
}
copied_after() { # all is logged, and its summary is not read yet; no landing, whose own would be waited for before
    mkfifo "$tmp/after.out"
    exec 8<>"$tmp/after.out"
    head -c 65536 /dev/zero >&8
    build/tests/soak_host/sender "$sockets/after.can" "$sockets/after.serial" 1 0 >/dev/null 2>&1 &
    stdbuf -o0 $matrig --json log --listen --can "unix:$sockets/after.can" --serial "unix:$sockets/after.serial" --db "$dbs/after.db" >"$tmp/after.out" 2>"$tmp/after.err" &
    logger=$!
    await has_come after 1000 && sqlite3 "$dbs/after.db" ".backup $dbs/after.backup" || return 1
    await eval '[ "$(db after "select ended_by from sessions")" = end ]' && copy after || return 1
    timeout 60 cat <&8 >/dev/null &
    wait $logger
    local status=$?
    exec 8>&-
    cat "$tmp/after.err"
    [ $status = 3 ] && cmp "$dbs/after.db" "$dbs/after.backup" && [ ! -e "$dbs/after.db-wal" ] && [ -s "$(echo "$dbs"/after-journal-*.wal)" ] &&
        told after "^matrig: $dbs/after.db was overwritten by another program before it was closed; its journal is $dbs/after-journal-"
}
# Notes, checkpoints, a vacuum, readers, a backup: all by SQLite.
used() {
    begin used 10 || return 1
    local i
    for i in 1 2 3 4 5; do
        $matrig landing "$dbs/used.db" 1 --note "note $i" && db used 'pragma wal_checkpoint(passive)' || return 1
        db used 'pragma wal_checkpoint(truncate)'
    done
    await db used vacuum || return 1 # a logger leaves little room
    sqlite3 "$dbs/used.db" ".backup $dbs/used.backup" && chmod g+r "$dbs/used.db" && $matrig --quiet report "$dbs/used.db" -o "$tmp/used.html" || return 1
    ends 0 && cat "$tmp/used.err" && all_there used used && [ "$(db used "select count(*) from landing_changes where field = 'note'")" = 5 ] &&
        ! grep -q 'while it was logged' "$tmp/used.err"
}
check_case() { # NAME TEXT
    [[ $1 =~ $only ]] || return
    check "$2" "$1"
    [ -z "${VERBOSE:-}" ] || sed 's/^/# /' "$tmp/check.out"
}
check_case copied "a backup is copied over the campaign in a landing: told, what came is saved, gone on with, exit 3"
check_case locked "and while another program holds it: likewise"
check_case truncated "it is truncated: likewise"
check_case restored "a backup is restored into it by sqlite3: likewise"
check_case copied_last "a backup is copied over it just before the end: likewise"
check_case copied_after "and while its summary waits to be read: told, the copy stays what it is, exit 3"
check_case used "who uses the campaign by SQLite alarms nobody"
finish
