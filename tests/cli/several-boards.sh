#!/usr/bin/env bash
# Another board on the CAN bus: one matrig log keeps one board, as if it had been alone, and reports the other one. The bus is made here of
# two recordings: the second board's identifiers are moved by awk, not by matrig.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
elf=build/firmware/matrig.elf

played --elf $elf --can "file:$tmp/a.can" --serial "file:$tmp/a.serial" --rig tests/runs/landing5.run 2>"$tmp/a.err"
played --elf $elf --can "file:$tmp/b.can" --serial "file:$tmp/b.serial" --rig tests/runs/landing1.run 2>"$tmp/b.err"
moved() { # LOG BASE: every identifier so much higher
    awk -v base=$(($2)) 'function hex(text, n, i) { for (i = 1; i <= length(text); i++) n = 16 * n + index("0123456789ABCDEF", substr(text, i, 1)) - 1; return n }
        { split($3, part, "#"); printf "%s %s %03X#%s\n", $1, $2, hex(part[1]) + base, part[2] }' "$1"
}
moved "$tmp/b.can" 0x190 >"$tmp/b.moved"
# a stranger on neither's identifiers: 0x555 is 0x3c5 behind 0x190, no message either
sort -s -k1,1 "$tmp/a.can" "$tmp/b.moved" <(awk 'NR % 1000 == 500 {print $1, $2, "555#0102"}' "$tmp/a.can") >"$tmp/bus.can"

alone() { $matrig --quiet log --can "file:$tmp/b.can" --serial "file:$tmp/b.serial" --db "$tmp/b.db" >/dev/null; }
one_of_them() { # the other one is a stranger that shares no identifier
    $matrig log --all --can "file:$tmp/bus.can,base=0x190" --db "$tmp/one.db" >"$tmp/one.txt" 2>"$tmp/one.err" || return 1
    cat "$tmp/one.err"
    [ "$(sqlite3 "$tmp/one.db" 'select can_base, can_link from sessions')" = "400|file:$tmp/bus.can,base=0x190" ] || return 1
    local catalogue="(select can_id from (select distinct can_id from alone.frames where link = 0))"
    cmp <(sqlite3 "$tmp/one.db" "attach '$tmp/b.db' as alone" "select printf('%03X#', can_id) || hex(data) from frames where landing = 1 and can_id in $catalogue order by id") \
        <(sqlite3 "$tmp/b.db" "select printf('%03X#', can_id) || hex(data) from frames where landing = 1 and link = 0 order by id")
}
out_and_in() { # as on the bus, and back
    $matrig export "$tmp/one.db" 1 --format candump -o "$tmp/one.log" 2>"$tmp/export.err" || return 1
    grep -q 'base 0x190; to import the file, use matrig import --base 0x190' "$tmp/export.err" || return 1
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
        fails_with 2 'session 1 of .* already contains this file' $matrig --quiet import "$tmp/twice.db" "$tmp/bus.can" --base 400
}
told_once() { [ "$(grep -c "another board sends on this bus and is not logged: base 0x000 of file:$tmp/bus.can,base=0x190" "$tmp/one.err")" = 1 ]; }
refuses() { # REASON BASE: nothing is made
    fails_with 2 "$1" $matrig --quiet log --can "file:$tmp/bus.can,base=$2" --db "$tmp/refused.db" && [ ! -e "$tmp/refused.db" ]
}

check "a board alone" alone
check "the same out of the bus, 0x190 higher" one_of_them
check "the other one is reported, once" told_once
check "exported as it was on the bus, and imported with its base" out_and_in
check "both boards of one log are imported, one after the other" imports_both
check "a base beyond the identifiers is refused" refuses 'base 0x3ff is too large: file:.*,base=0x3ff; give at most 0x3fe' 0x3ff
check "so is one that is no number" refuses "not a base of CAN identifiers: '12ab' of .*; write a number such as 0x190" 12ab
check "and an empty one" refuses "not a base of CAN identifiers: ''" ""
finish
