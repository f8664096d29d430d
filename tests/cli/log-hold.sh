#!/usr/bin/env bash
# matrig log when its campaign takes nothing for a while, under full load of both links, in a landing: another program holds the lock, a
# disk that is slow or full, and a campaign that somebody moves, replaces or deletes. tests/soak_host/sender.c keeps a queue of 64 KiB a
# link, as an adapter has, and counts what is lost of it; tests/link/faults.c is the disk.
. "$(dirname "$0")/tap.sh"
matrig=${MATRIG:-build/matrig}
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
dbs=$(mktemp -d /dev/shm/matrig.XXXXXX 2>/dev/null) || dbs=$tmp # in memory: how long a busy disk takes is not what is tried
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$sockets"; [ "$dbs" = "$tmp" ] || rm -rf "$dbs"' EXIT
faults="LD_PRELOAD=build/tests/link/faults.so"
only=${ONLY:-.} # a pattern of the cases to try
longer="^(lock-32|stall-10|stall-2|lock-1|moved-last|full-end)$" # the same as others for longer: in make long alone

# begin NAME SECONDS [VARIABLE=VALUE...]: sender and logger in the background, into NAME.db
begin() {
    local name=$1 seconds=$2
    shift 2
    build/tests/soak_host/sender "$sockets/$name.can" "$sockets/$name.serial" "$seconds" 65536 "$tmp/$name.marks" >"$tmp/$name.sent" 2>"$tmp/$name.sender" &
    sender=$!
    env "$@" $matrig --json log --listen --can "unix:$sockets/$name.can" --serial "unix:$sockets/$name.serial" --db "$dbs/$name.db" \
        >"$tmp/$name.json" 2>"$tmp/$name.err" &
    logger=$!
    in_landing "$name" || return 1
}
db() { sqlite3 -cmd '.timeout 5000' "$dbs/$1.db" "$2"; }
has_come() { [ "$(db "$1" "select count(*) from frames where link = 0 and can_id = 1365")" -ge 12000 ]; } # the landing is from 1.2 to 7.6 s
in_landing() { await eval "has_come $1 || over $logger" && has_come "$1"; } # at once when the logger ended instead
told() { grep -Eq "$2" "$tmp/$1.err"; }
sent() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/$1.sent') as text), '\$.$2')"; }
json() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/$1.json') as text), '\$.$2') ${3:-}"; }
over() { ! kill -0 "$1"; }

# all_there NAME [DB]: what was sent is in the campaign, to the frame; nothing was lost anywhere.
all_there() {
    local name=$1 file=${2:-$1}
    echo "lost in the links' queues: CAN $(sent "$name" can_lost) + $(sent "$name" fills_lost), serial $(sent "$name" serial_lost);" \
        "in the campaign: $(db "$file" 'select group_concat(received || "/" || lost || "/" || bad) from links')"
    echo "sent: $(cat "$tmp/$name.sent"); fills kept $(db "$file" 'select count(*) from frames where link = 0 and can_id = 1365');" \
        "landings by state $(db "$file" 'select group_concat(state) from landings')"
    [ "$(sent "$name" can_lost)$(sent "$name" fills_lost)$(sent "$name" serial_lost)" = 000 ] &&
        [ "$(db "$file" 'select sum(lost + bad) from links')" = 0 ] &&
        [ "$(db "$file" 'select count(*) from frames where link = 0 and can_id = 1365')" = "$(sent "$name" fills)" ] &&
        [ "$(db "$file" 'select received from links where link = 0')" = "$(sent "$name" can_sent)" ] &&
        [ "$(db "$file" 'select received from links where link = 1')" = "$(sent "$name" serial_sent)" ] &&
        [ "$(db "$file" 'select group_concat(distinct state) from landings')" = 4 ] && [ "$(db "$file" 'pragma integrity_check')" = ok ]
}
ends() { # STATUS: the logger's, and the sender's is 0
    wait $logger
    local status=$?
    wait $sender
    local sender_status=$?
    echo "exit $status, sender $sender_status"
    [ $status = "$1" ] && [ $sender_status = 0 ]
}

# A logger is in a transaction nearly all the time: who wants to write tries often.
cat >"$tmp/hold.py" <<'P'
import sqlite3, sys, time
db = sqlite3.connect(sys.argv[1], timeout=0, isolation_level=None)
until = time.monotonic() + 300
while True:
    try:
        db.execute("BEGIN " + sys.argv[2])
        break
    except sqlite3.OperationalError:
        if time.monotonic() > until:
            sys.exit("never free")
        time.sleep(0.0005)
print("held", flush=True)
sys.stdin.read()
db.execute("ROLLBACK")
P
hold() { # NAME HOW: another program begins a transaction that writes
    mkfifo "$tmp/$1.orders"
    python3 "$tmp/hold.py" "$dbs/$1.db" "$2" <"$tmp/$1.orders" >"$tmp/$1.holder" 2>&1 &
    holder=$!
    exec 9>"$tmp/$1.orders"
    await grep -q held "$tmp/$1.holder"
}
let_go() { exec 9>&-; wait $holder; }

held() { # NAME SECONDS HOW: a lock
    begin "$1" $(($2 + 8)) && hold "$1" "$3" || return 1
    local from=$EPOCHREALTIME at
    await told "$1" "^matrig: another program has locked the campaign: waiting, queue [0-9]+ % full, nothing lost: $dbs/$1.db$" &&
        at=$EPOCHREALTIME && sleep "$(awk -v s="$2" -v from="${from/,/.}" -v now="${at/,/.}" 'BEGIN { print (s > now - from ? s - now + from : 0) }')"
    local early=$?
    let_go
    ends 0 && [ $early = 0 ] || { cat "$tmp/$1.err"; return 1; }
    awk -v from="${from/,/.}" -v at="${at/,/.}" 'BEGIN { printf "told after %.2f s\n", at - from }'
    cat "$tmp/$1.err"
    echo "queue $(json "$1" queue)"
    all_there "$1" && told "$1" "^matrig: the campaign can be written again after [0-9.]+ s; the queue was [0-9]+ % full, nothing lost$" &&
        [ "$(json "$1" queue.held_s.lock "> $2 - 0.5")" = 1 ]
}
stalled() { # NAME SECONDS: a write takes as long
    begin "$1" $(($2 + 8)) "$faults" "DISK_STALL=$tmp/$1.now:$2" || return 1
    touch "$tmp/$1.now"
    ends 0 || return 1
    cat "$tmp/$1.err"
    echo "queue $(json "$1" queue)"
    all_there "$1" && [ "$(json "$1" queue.held_s.slow_disk "> $2 - 0.1")" = 1 ] &&
        { [ "$2" = 1 ] || # it may be over before a busy computer gets to telling it
            { told "$1" "^matrig: the disk has been slow for [0-9.]+ s: waiting, queue [0-9]+ % full, nothing lost: $dbs/$1.db$" &&
                told "$1" "^matrig: the campaign can be written again after [0-9.]+ s; the queue was [0-9]+ % full, nothing lost$"; }; }
}
room_again() {
    begin room 12 "$faults" "DISK_FULL=$tmp/room.now:room.db" || return 1
    touch "$tmp/room.now"
    await told room "^matrig: the disk of the campaign is full: waiting for space, queue [0-9]+ % full, nothing lost: $dbs/room.db$"
    local early=$?
    rm "$tmp/room.now"
    ends 0 || return 1
    cat "$tmp/room.err"
    [ $early = 0 ] && all_there room && told room "^matrig: the campaign can be written again after [0-9.]+ s" &&
        [ "$(json room queue.held_s.full_disk "> 0")" = 1 ]
}

# More comes than the queue holds, over a wire that waits for nobody: the beginning is kept, the gap is one, is stated with its cause, and the
# log goes on.
overflows() {
    local name=wire lost came
    build/tests/link/longlanding "$tmp/wire.can" "$tmp/wire.serial" 2 && mkfifo "$tmp/wire.send" || return 1
    python3 tests/link/wire.py "$dbs/tty" <"$tmp/wire.send" >"$tmp/wire.sent" &
    local wire=$!
    exec 8>"$tmp/wire.send"
    await test -e "$dbs/tty" || return 1
    $matrig --json log --listen --serial "serial:$dbs/tty" --db "$dbs/wire.db" --wait 0.1 >"$tmp/wire.json" 2>"$tmp/wire.err" &
    logger=$!
    await test -s "$dbs/wire.db" || return 1 # made when the link is open
    echo "send $tmp/wire.serial 1" >&8
    await finished wire 1 && hold wire IMMEDIATE || return 1
    echo "send $tmp/wire.serial $((20000000 / $(stat -c %s "$tmp/wire.serial") + 2))" >&8 # 19.2 MB are held
    await told wire "queue [0-9]+ % full, lost so far in this session: [0-9]+ serial bytes: $dbs/wire.db$" && await all_sent 2
    local early=$?
    let_go
    await told wire "^matrig: the campaign can be written again after .*lost so far in this session: [0-9]+ serial bytes$" || early=1
    await told wire "frames or bytes that a full queue lost" || early=1 # which stands behind all that the queue held
    came=$(db wire "select count(*) from landings where state = 4")
    tail -c 300000 "$tmp/wire.serial" >"$tmp/wire.rest" # the end of the landing that was cut off
    echo "send $tmp/wire.rest 1" >&8
    await finished wire $((came + 1)) || early=1
    echo end >&8
    exec 8>&-
    wait $wire $logger
    cat "$tmp/wire.err"
    lost=$(db wire "select sum(detail) from events where kind = 'serial-link' and code = 19")
    echo "lost $lost bytes; gaps $(db wire "select group_concat(cause || ' ' || count) from gaps where message = 'frame'")"
    [ $early = 0 ] && [ "$lost" -gt 0 ] && [ "$(db wire "select count(*), sum(count) > 0 from gaps where cause = 'lock'")" = "1|1" ] && [ "$(grep -c "lost so far in this session: $lost serial bytes$" "$tmp/wire.err")" -ge 1 ] &&
        [ "$(json wire 'links.serial.troubles')" = "{\"went away\":1,\"frames or bytes that a full queue lost (another program held the campaign)\":$lost}" ] &&
        [ "$(db wire 'select sum(bad) <= 1 from links')" = 1 ] && [ "$(db wire 'pragma integrity_check')" = ok ]
}
finished() { [ "$(db "$1" "select count(*) from landings where state = 4")" -ge "$2" ]; }
all_sent() { [ "$(wc -l <"$tmp/wire.sent")" -ge "$1" ]; }

# Somebody ends the log while it waits: it ends soon, and all that the queues keep is in a campaign beside, landing and all.
ended_while() { # NAME
    local from=$SECONDS read status at_us saved kept
    at_us=$(($(date +%s%N) / 1000))
    kill -INT $logger
    await over $logger || return 1
    wait $logger
    status=$?
    wait $sender
    cat "$tmp/$1.err"
    echo "exit $status after $((SECONDS - from)) s"
    [ "$1" = given-up ] && let_go
    saved=$(json "$1" db)
    [ $status = 3 ] && [[ $saved == $dbs/$1-saved-*.db ]] &&
        [ "$(grep -c "^matrig: $dbs/$1\.db accepted no more data .*; the data logged is in $saved$" "$tmp/$1.err")" = 1 ] || return 1
    saved=$(basename "$saved" .db)
    read=$(awk -v at=$((at_us - 100000)) '$1 <= at { n = $2 } END { print n + 0 }' "$tmp/$1.marks")
    kept=$(db "$saved" "select count(distinct substr(data, 1, 4)) from frames where link = 0 and can_id = 1365")
    echo "read 100 ms before: $read; kept $kept"
    [ "$read" -gt 12000 ] && [ "$kept" -ge "$read" ] && [ "$(db "$1" 'pragma integrity_check')" = ok ] && [ "$(db "$saved" 'pragma integrity_check')" = ok ] &&
        landing_is_whole "$saved" && [ "$(db "$saved" 'select ended_by from sessions')" = signal ]
}
landing_is_whole() { # DB: it is in it from its arming, without a hole, on both links
    local readings="from frames where can_id = 256 and link = 0 and landing = 1" blocks="from blocks where landing = 1"
    db "$1" "select id, state, armed_block, (select count(*) || ' readings' $readings), (select count(*) || ' blocks, ' || min(idx) || ' to ' || max(idx) $blocks) from landings"
    [ "$(db "$1" "select count(*), min(armed_block) > 0 from landings")" = "1|1" ] &&
        [ "$(db "$1" "select count(*) - 1 - (max(board_us) - min(board_us)) / 2000 $readings")" = 0 ] &&
        [ "$(db "$1" "select count(*) - 1 - (max(idx) - min(idx)) $blocks")" = 0 ]
}
given_up() {
    begin given-up 30 && hold given-up IMMEDIATE && await told given-up "another program has locked" && ended_while given-up
}
full_to_the_end() {
    begin full-end 30 "$faults" "DISK_FULL=$tmp/full-end.now:full-end.db" || return 1
    touch "$tmp/full-end.now"
    await told full-end "the disk of the campaign is full" && ended_while full-end
}

# A write that hangs is not waited for, once the end was asked for.
hung() {
    begin hung 40 "$faults" "DISK_STALL=$tmp/hung.now:60" || return 1
    touch "$tmp/hung.now"
    await told hung "^matrig: the disk has been slow" || return 1
    local from=$SECONDS status
    kill -INT $logger
    await over $logger || return 1
    wait $logger
    status=$?
    wait $sender
    cat "$tmp/hung.err"
    echo "exit $status after $((SECONDS - from)) s"
    [ $status = 3 ] && told hung "^matrig: the disk has accepted no data for 1[0-9] s: $dbs/hung.db; check the disk; the newest [0-9]+ CAN frames and [0-9]+ serial bytes are not saved"
}

# The campaign is taken away: told, saved beside, gone on with; the exit code says so, and nothing of anybody's is overwritten.
taken() { # NAME WHAT COMMAND...
    local name=$1 what=$2 from at saved
    shift 2
    begin "$name" 12 || return 1
    from=$EPOCHREALTIME
    "$@" || return 1
    await told "$name" "^matrig: $dbs/$name\.db $what while it was logged: all data was saved in .*, and the log continues there$"
    at=$EPOCHREALTIME
    ends 3 || { cat "$tmp/$name.err"; return 1; }
    cat "$tmp/$name.err"
    awk -v from="${from/,/.}" -v at="${at/,/.}" 'BEGIN { printf "told after %.2f s\n", at - from }'
    saved=$(json "$name" db)
    echo "$saved"
    [[ $saved == $dbs/$name-saved-*.db ]] && [ "$(grep -c "while it was logged; the data logged is in $saved$" "$tmp/$name.err")" = 1 ] &&
        all_there "$name" "$(basename "$saved" .db)"
}
moved() { # its journal goes with it, so that it is whole
    taken moved "was moved to $dbs/elsewhere.db" mv "$dbs/moved.db" "$dbs/elsewhere.db" && [ ! -e "$dbs/moved.db-wal" ] &&
        $matrig landing "$dbs/elsewhere.db" | grep -q '^RUN 1'
}
deleted() { taken deleted "was deleted" rm "$dbs/deleted.db" "$dbs/deleted.db-wal" "$dbs/deleted.db-shm"; }
moved_last() { # at the very end, before anybody could have noticed
    local saved
    begin moved-last 30 || return 1
    mv "$dbs/moved-last.db" "$dbs/somewhere.db" && kill -INT $logger || return 1
    wait $logger
    local status=$?
    wait $sender
    cat "$tmp/moved-last.err"
    saved=$(json moved-last db)
    echo "exit $status, $saved"
    [ $status = 3 ] && [[ $saved == $dbs/moved-last-saved-*.db ]] && has_come "$(basename "$saved" .db)" &&
        [ "$(db "$(basename "$saved" .db)" "select ended_by from sessions")" = signal ]
}
put_another() {
    sqlite3 "$dbs/another" "pragma journal_mode = wal; create table somebodys (text); insert into somebodys values ('own')" >/dev/null &&
        cp "$dbs/another" "$dbs/another.copy" && mv "$dbs/another" "$dbs/replaced.db"
}
replaced() { # and nothing of the log's is beside it that SQLite would write into it
    taken replaced "was replaced by a different file" put_another && [ ! -e "$dbs/replaced.db-wal" ] &&
        [ "$(sqlite3 "$dbs/replaced.db" 'select text from somebodys')" = own ] && cmp "$dbs/replaced.db" "$dbs/another.copy"
}
journal() { taken journal "lost its journal \(-wal\)" rm "$dbs/journal.db-wal"; }
index() { taken index "lost its journal's index \(-shm\)" rm "$dbs/index.db-shm"; }

# Side by side: most of it is waiting.
declare -A process
start() { # NAME COMMAND...
    [[ $1 =~ $only ]] && { [ -n "${MATRIG_LONG:-}" ] || [[ ! $1 =~ $longer ]]; } || return
    local name=$1
    shift
    (
        trap 'kill $(jobs -p) 2>/dev/null' EXIT # of a case that failed, nothing goes on
        "$@" >"$tmp/$name.out" 2>&1
        echo $? >"$tmp/$name.code"
    ) &
    process[$name]=$!
}
outcome() { cat "$tmp/$1.out"; [ "$(cat "$tmp/$1.code")" = 0 ]; }
result() { # NAME TEXT
    [ -n "${process[$1]:-}" ] || return
    wait "${process[$1]}"
    check "$2" outcome "$1"
    [ -z "${VERBOSE:-}" ] || sed 's/^/# /' "$tmp/$1.out"
}
start lock-32 held lock-32 32 EXCLUSIVE
start lock-8 held lock-8 8 IMMEDIATE
start stall-10 stalled stall-10 10
start lock-1 held lock-1 1 EXCLUSIVE
result lock-1 "another program holds the campaign for 1 s: nothing lost"
start stall-1 stalled stall-1 1
start stall-2 stalled stall-2 2
result lock-8 "8 s: nothing lost, told while it lasts"
result stall-1 "the disk takes 1 s for a write: nothing lost"
result stall-2 "2 s: nothing lost, told while it lasts"
start room room_again
start wire overflows
start given-up given_up
start full-end full_to_the_end
start hung hung
result stall-10 "10 s"
result room "the disk is full, and has room again: nothing lost, told while it lasts"
result wire "more than the queue holds, over a wire that does not wait: one gap, with its cause, and the log goes on"
result hung "ended in a write that hangs: told what is not saved"
start moved moved
start moved-last moved_last
start deleted deleted
result given-up "ended while another program holds the campaign: soon, and all of it is in a campaign beside"
result full-end "ended while the disk is full: likewise"
start replaced replaced
start journal journal
start index index
result moved "the campaign is moved in a landing: told, saved, gone on with, exit 3"
result moved-last "moved just before the end: likewise"
result deleted "deleted: likewise"
result replaced "replaced by another file, which stays as it is: likewise"
result journal "its journal is deleted: likewise"
result index "the index of its journal is deleted: likewise"
result lock-32 "another program holds the campaign for 32 s: nothing lost"
finish
