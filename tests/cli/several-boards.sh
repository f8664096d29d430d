#!/usr/bin/env bash
# Boards that share a CAN bus: one matrig log keeps each on its own, as if it had been alone. The bus is made here of two recordings:
# the second board's identifiers are moved by awk, not by matrig.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
elf=build/firmware/matrig.elf
trap 'kill $(jobs -p) 2>/dev/null' EXIT

played --elf $elf --can "file:$tmp/a.can" --serial "file:$tmp/a.serial" --rig tests/runs/landing5.run 2>"$tmp/a.err"
played --elf $elf --can "file:$tmp/b.can" --serial "file:$tmp/b.serial" --rig tests/runs/landing1.run 2>"$tmp/b.err"
moved() { # LOG BASE: every identifier so much higher
    awk -v base=$(($2)) 'function hex(text, n, i) { for (i = 1; i <= length(text); i++) n = 16 * n + index("0123456789ABCDEF", substr(text, i, 1)) - 1; return n }
        { split($3, part, "#"); printf "%s %s %03X#%s\n", $1, $2, hex(part[1]) + base, part[2] }' "$1"
}
moved "$tmp/b.can" 0x190 >"$tmp/b.moved"
# a stranger on neither's identifiers: 0x555 is 0x3c5 behind 0x190, no message either
sort -s -k1,1 "$tmp/a.can" "$tmp/b.moved" <(awk 'NR % 1000 == 500 {print $1, $2, "555#0102"}' "$tmp/a.can") >"$tmp/bus.can"

frames_of() { # DB SESSION LINK
    sqlite3 "$1" "select printf('%03X#', can_id) || hex(data) from frames where session = $2 and link = $3 and can_id <> 1365 and can_id <> 965 order by id"
}
told_of() { # DB SESSION: what was made of it
    sqlite3 "$1" "select board_landing, state, touchdown_ft from landings where session = $2" \
        "select e.* from edges e join landings l on l.id = e.landing where l.session = $2 order by 2" \
        "select m.* from motion m join landings l on l.id = m.landing where l.session = $2 order by 2" \
        "select r.* from results r join landings l on l.id = r.landing where l.session = $2" \
        "select received, lost, dropped, bad from links where session = $2 and link = 0" | cut -d'|' -f2-
}
alone() { $matrig --quiet log --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --db "$tmp/$1.db" >/dev/null; }
both() { # DB
    $matrig --json --quiet log --can "file:$tmp/bus.can@0,0x190" --serial "file:$tmp/a.serial,file:$tmp/b.serial" --db "$1" >"$1.json"
}
as_alone() { # SESSION NAME
    for link in 0 1; do
        [ "$(frames_of "$tmp/$2.db" 1 $link | wc -l)" -gt 1000 ] || return 1
        cmp <(frames_of "$tmp/both.db" "$1" $link) <(frames_of "$tmp/$2.db" 1 $link) || return 1
    done
    diff <(told_of "$tmp/both.db" "$1") <(told_of "$tmp/$2.db" 1) || return 1
    cmp <(sqlite3 "$tmp/both.db" "select hex(record) from blocks where session = $1 order by idx") <(sqlite3 "$tmp/$2.db" "select hex(record) from blocks order by idx")
}
sessions_say() {
    sqlite3 "$tmp/both.db" 'select id, can_base, can_link, serial_link from sessions' >"$tmp/sessions"
    cat "$tmp/sessions"
    cmp "$tmp/sessions" - <<EOF
1|0|file:$tmp/bus.can@0x000|file:$tmp/a.serial
2|400|file:$tmp/bus.can@0x190|file:$tmp/b.serial
EOF
}
told_by_base() { # the counts of each board, and all landings
    jq -e '(.landings | length) == 2 and .boards["0x190"].session == 2 and .boards["0x190"].base == 400 and
        .boards["0x190"].links.can.lost == 0 and .boards["0x000"].links.can.lost == 0 and .boards["0x190"].links.serial.lost == 0' "$tmp/both.db.json"
}
strangers_once() { # with the first board, by its identifiers
    local sent
    sent=$(grep -c ' 555#' "$tmp/bus.can")
    [ "$sent" -gt 10 ] && [ "$(sqlite3 "$tmp/both.db" 'select group_concat(outside) from links where link = 0')" = "$sent,0" ] &&
        [ "$(sqlite3 "$tmp/both.db" 'select count(*) from frames where session = 1 and can_id = 1365')" = "$sent" ] &&
        [ "$(sqlite3 "$tmp/both.db" 'select count(*) from events where kind = "stranger"')" = 0 ]
}
one_of_them() { # the other one is a stranger that shares no identifier
    $matrig --quiet log --can "file:$tmp/bus.can@0x190" --db "$tmp/one.db" >/dev/null || return 1
    local catalogue="(select can_id from (select distinct can_id from alone.frames where link = 0))"
    cmp <(sqlite3 "$tmp/one.db" "attach '$tmp/b.db' as alone" "select printf('%03X#', can_id) || hex(data) from frames where landing = 1 and can_id in $catalogue order by id") \
        <(sqlite3 "$tmp/b.db" "select printf('%03X#', can_id) || hex(data) from frames where landing = 1 and link = 0 order by id")
}
out_and_in() { # as on the bus, and back
    $matrig export "$tmp/one.db" 1 --format candump -o "$tmp/one.log" 2>"$tmp/export.err" || return 1
    grep -q 'base 0x190; matrig import --base 0x190' "$tmp/export.err" || return 1
    diff <(awk '{print $3}' "$tmp/one.log" | sort | uniq -c) \
        <(sqlite3 "$tmp/one.db" "select printf('%03X#', (can_id + 400) % 2048) || hex(data) from frames where landing = 1 and board_us is not null" | sort | uniq -c) || return 1
    $matrig --quiet import "$tmp/back.db" "$tmp/one.log" --base 0x190 >/dev/null &&
        $matrig --quiet export "$tmp/b.db" 1 --format candump -o "$tmp/b.log" && $matrig --quiet import "$tmp/ref.db" "$tmp/b.log" >/dev/null &&
        [ "$(sqlite3 "$tmp/ref.db" 'select count(*) from edges')" -gt 5 ] &&
        diff <(sqlite3 "$tmp/back.db" 'select * from edges' 'select * from results') <(sqlite3 "$tmp/ref.db" 'select * from edges' 'select * from results')
}
imports_both() { # of one log, one after the other; each once
    $matrig --quiet import "$tmp/twice.db" "$tmp/bus.can" --base 0x190 >/dev/null && $matrig --quiet import "$tmp/twice.db" "$tmp/bus.can" >/dev/null || return 1
    [ "$(sqlite3 "$tmp/twice.db" 'select group_concat(board_landing) from landings')" = 1,5 ] &&
        fails_with 2 'imported already, as session 1' $matrig --quiet import "$tmp/twice.db" "$tmp/bus.can" --base 400
}
nobody_there() { # 0x1a0: the other one speaks, and is kept
    fails_with 3 'no board at base 0x1a0: file:.*bus.can@0x1a0' $matrig --quiet log --can "file:$tmp/bus.can@0,0x1a0" --db "$tmp/nobody.db" &&
        [ "$(sqlite3 "$tmp/nobody.db" 'select count(*) from landings')" = 1 ]
}
refuses() { # REASON ARGUMENTS...: nothing is made
    local reason=$1
    shift
    fails_with 2 "$reason" $matrig --quiet log "$@" --db "$tmp/refused.db" && [ ! -e "$tmp/refused.db" ]
}
killed_and_gone_on() { # 1 s before the end of the landings; then all of it again
    head -c 1500000 "$tmp/bus.can" >"$tmp/part.can"
    $matrig --quiet log --can "file:$tmp/part.can@0,0x190" --db "$tmp/again.db" >/dev/null 2>&1
    $matrig --quiet log --can "file:$tmp/bus.can@0,0x190" --db "$tmp/again.db" >/dev/null 2>"$tmp/again.err" || return 1
    cat "$tmp/again.err"
    [ "$(sqlite3 "$tmp/again.db" 'select count(*) from landings where state = 4')" = 2 ]
}

one_is_spoken_with() {
    fails_with 2 'one board is spoken with: can0@0,0x190 names 2' $matrig board --can can0@0,0x190 arm
}

check "each board alone" alone a
check "the other one" alone b
check "one log of both, with their serial lines" both "$tmp/both.db"
check "the first is kept as if it had been alone: frames, records, edges, motion, results, counts" as_alone 1 a
check "and so is the second, 0x190 higher on the bus" as_alone 2 b
check "each in a session of its own, which says where it was" sessions_say
check "what the log came to is told by base" told_by_base
check "what is of no board is kept once" strangers_once
check "one of them alone, out of the same bus" one_of_them
check "exported as it was on the bus, and imported with its base" out_and_in
check "no board at a base: told, and the other one kept" nobody_there
check "cut off, and the same bus again" killed_and_gone_on
check "both boards of one log are imported, one after the other" imports_both
check "boards that would share identifiers are refused" refuses 'share identifiers \(0x100\)' --can "file:$tmp/bus.can@0,0x80"
check "more serial lines than boards" refuses 'more serial lines than boards' --can "file:$tmp/bus.can@0,0x190" --serial "file:$tmp/a.serial,file:$tmp/b.serial,file:$tmp/b.serial"
check "serial lines of several boards need their bases" refuses 'serial lines of several boards: .*--can can0@0,0x190' --serial "file:$tmp/a.serial,file:$tmp/b.serial"
check "the live view is of one board" refuses '--live shows one board' --can "file:$tmp/bus.can@0,0x190" --live 0
check "a command speaks with one board" one_is_spoken_with
finish
