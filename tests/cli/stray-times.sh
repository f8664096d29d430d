#!/usr/bin/env bash
# One time that cannot belong to a landing (a damaged frame, a damaged campaign) in the campaign: what is measured stays as it was, the
# wrong time is left out, counted and told, and costs no memory. Memory is bounded by ulimit, in kB: without the bound a time one
# hour off took 560,000 to 1,800,000.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
db=$tmp/campaign.db
m() { (ulimit -v 200000 && exec build/matrig "$@"); }

played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run >/dev/null 2>&1
build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >/dev/null
build/matrig --quiet log --can "file:$tmp/can" --db "$tmp/can.db" >/dev/null
all() { # DB PREFIX: everything that reads a landing
    m report "$1" -o "$2.html" 2>"$2.err" && m --json compare "$1" 1 >"$2.json" 2>>"$2.err" &&
        m export "$1" 1 --format csv -o "$2.csv" 2>>"$2.err"
}
readings() { grep -v '^#' "$1"; }
whole() { all "$db" "$tmp/whole" && all "$tmp/can.db" "$tmp/can" && ! grep 'left out' "$tmp/whole.csv" "$tmp/can.csv"; }
stray() { # WHOLE WHAT SQL: the same readings and figures, and what was left out is told
    local from=$db
    [ "$1" = whole ] || from=$tmp/$1.db
    rm -f "$tmp/stray.db"
    sqlite3 "$from" "vacuum into '$tmp/stray.db'" && sqlite3 "$tmp/stray.db" "$3" && all "$tmp/stray.db" "$tmp/stray" || { cat "$tmp/stray.err"; return 1; }
    cmp <(readings "$tmp/$1.csv") <(readings "$tmp/stray.csv") || return 1
    cmp <(sed 's/"run_ms":[^,]*//g; s/"file":[^,]*//g' "$tmp/$1.json") <(sed 's/"run_ms":[^,]*//g; s/"file":[^,]*//g' "$tmp/stray.json") || return 1
    cat "$tmp/stray.err"
    grep -q "^# readings from .*; $2 left out: their times are far from the landing (first: board time " "$tmp/stray.csv" && grep -q "$2 left out" "$tmp/stray.html" &&
        [ "$(grep -c "RUN 1: $2 left out" "$tmp/stray.err")" = 1 ] # compare
}
frame() { # OFFSET: a message of displacements, so many us off
    echo "insert into frames(session, landing, link, direction, seq, board_us, host_us, can_id, dlc, data) select session, landing, link, direction, seq,
        board_us + $1, host_us, can_id, dlc, data from frames where landing = 1 and can_id = 256 and link = 0 order by id desc limit 1"
}
# A block record whose number inside is another; its place in the campaign is that of the one before the first.
block() { # NUMBER in hexadecimal, little-endian
    echo "insert into blocks(session, boot, idx, landing, host_us, record, link) select session, boot, idx - 1, landing, host_us,
        cast(x'$1' || substr(record, 5) as blob), link from blocks where landing = 1 order by idx limit 1"
}
check "the landing as it is, within the bound of memory" whole
check "a message an hour later" stray whole '1 CAN message' "$(frame 3500000000)"
check "a message an hour before" stray whole '1 CAN message' "$(frame -3500000000)"
check "a message at the end of time" stray whole '1 CAN message' "$(frame 9000000000000000000)"
check "three messages, without serial" stray can '3 CAN messages' "$(frame 3500000000);$(frame 2000000000);$(frame 1000000000)"
check "a block record an hour later" stray whole '1 block record' "$(block 2A893500)"
seen() { m --json show "$1" 1 | grep -o '"switches_seen":[0-9]*' | cut -d: -f2; }
an_edge() { # its switch is missing then, as if it had not been seen
    rm -f "$tmp/stray.db"
    sqlite3 "$db" "vacuum into '$tmp/stray.db'" && sqlite3 "$tmp/stray.db" "update edges set board_us = board_us + 3500000000 where count = 10" &&
        all "$tmp/stray.db" "$tmp/stray" && grep -q '; 1 switch edge left out' "$tmp/stray.csv" &&
        [ "$(($(seen "$db") - $(seen "$tmp/stray.db")))" = 1 ]
}
check "an edge an hour later costs its switch, no more" an_edge
finish
