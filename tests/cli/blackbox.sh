#!/usr/bin/env bash
# The black box from the host: a landing is recorded by a board whose serial link is down, and comes out of its memory later.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
run=tests/runs/landing5.run
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

# at_board ARGUMENTS...: matrig against a board that idles with the memory; its exit code
at_board() { with_board --serial "unix:$sockets/serial" --nor "$tmp/nor" -- build/matrig "$@"; }
box() { at_board --json --quiet board --serial "unix:$sockets/serial" "$@"; }
one() { python3 -c 'import json,sys; print(json.load(open(sys.argv[1]))'"$2"')' "$1"; }
blocks() { sqlite3 "$1" "select hex(record) from blocks where landing = 1 and idx >= $2 order by idx"; }

a_landing_is_recorded() {
    build/matrig-board --elf $elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig $run --nor "$tmp/nor" --for 9.4 &&
        build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/whole.db" &&
        build/matrig --quiet log --can "file:$tmp/can" --db "$tmp/can.db"
}
it_is_listed() {
    box list >"$tmp/list.json" || return 1
    cat "$tmp/list.json"
    [ "$(one "$tmp/list.json" "['records'][0]['landing']")" = 5 ] && [ "$(one "$tmp/list.json" "['records'][0]['complete']")" = True ] &&
        [ "$(one "$tmp/list.json" "['records'][0]['lost']")" = 0 ] && [ "$(one "$tmp/list.json" "['state']")" = ready ]
}
gaps_are_filled() { # a log with CAN alone has no block; one with serial has lost some; both get the same blocks
    local first
    sqlite3 "$tmp/whole.db" ".backup $tmp/holes.db"
    sqlite3 "$tmp/holes.db" "delete from blocks where idx between 3000 and 3999 or idx % 7 = 3; delete from edges where count in (2, 9)"
    box read 1 --db "$tmp/holes.db" >"$tmp/read.json" && box read 1 --db "$tmp/can.db" >"$tmp/read2.json" || return 1
    cat "$tmp/read.json" "$tmp/read2.json"
    first=$(sqlite3 "$tmp/whole.db" "select min(idx) from blocks where landing = 1")
    [ "$(one "$tmp/read.json" "['first_block']")" -le "$first" ] || return 1 # the box reaches back as far
    blocks "$tmp/whole.db" "$first" >"$tmp/whole.txt"
    blocks "$tmp/holes.db" "$first" >"$tmp/holes.txt"
    blocks "$tmp/can.db" "$first" >"$tmp/can.txt"
    [ "$(wc -l <"$tmp/whole.txt")" -gt 6000 ] && cmp "$tmp/holes.txt" "$tmp/can.txt" || return 1
    # the box goes on from what serial had first to what it had last, block for block
    head -n "$(wc -l <"$tmp/whole.txt")" "$tmp/holes.txt" | cmp - "$tmp/whole.txt" &&
        [ "$(one "$tmp/read.json" "['new_landing']")" = False ] && [ "$(one "$tmp/read.json" "['filled_edges']")" = 2 ] &&
        [ "$(sqlite3 "$tmp/holes.db" "select count(*) from edges where links = 4")" = 2 ] &&
        [ "$(sqlite3 "$tmp/holes.db" "select group_concat(ended_by) from sessions")" = "end,black box" ] &&
        [ "$(sqlite3 "$tmp/holes.db" "select max(abs(h.board_us - c.board_us)) < 1.0 from edges h join edges c using(count) where h.links = 4" 2>&1)" = 1 ]
}
a_database_without_it_gets_it() {
    box read 1 --db "$tmp/new.db" >"$tmp/read3.json" || return 1
    cat "$tmp/read3.json"
    [ "$(one "$tmp/read3.json" "['new_landing']")" = True ] && [ "$(sqlite3 "$tmp/new.db" "select count(*) from channels")" = 24 ] &&
        [ "$(sqlite3 "$tmp/new.db" "select count(*) from switches")" = 24 ]
}
# What the log of both links has of the landing, the black box brings to a database without it: by the rows, but for which links they
# came by.
it_lacks_nothing_that_the_log_has() {
    local table columns
    build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/log.db" >/dev/null || return 1
    for table in calibration channels switches slack results motion zones bands band_events quality edges temperatures; do
        columns=$(sqlite3 "$tmp/log.db" "select group_concat(name) from pragma_table_info('$table') where name <> 'links'")
        for db in log new; do
            sqlite3 "$tmp/$db.db" "select $columns from $table" >"$tmp/$db.rows"
        done
        case $table in calibration | channels | switches | slack | results | motion | zones | bands | quality | edges)
            [ -s "$tmp/log.rows" ] || { echo "$table: the log has none"; return 1; } ;;
        esac
        cmp "$tmp/log.rows" "$tmp/new.rows" || { echo "$table differs"; return 1; }
    done
    for db in log new; do
        sqlite3 "$tmp/$db.db" "select kind, board_us, code, detail, value from events where landing = 1 and kind not in ('blackbox', 'order') order by 1, 2, 3, 5" >"$tmp/$db.rows"
        sqlite3 "$tmp/$db.db" "select state, armed_block, board_uid, firmware, image_crc, config_crc, touchdown_ft, switch_error_ft, image_commit from landings" >>"$tmp/$db.rows"
    done
    [ "$(sqlite3 "$tmp/new.db" "select count(*) from configurations join landings on crc = config_crc")" = 1 ] || return 1
    grep -q "^state" "$tmp/log.rows" && diff "$tmp/log.rows" "$tmp/new.rows"
}
reading_takes_less_than_10_s() { # of the board's time: parts on serial, a byte 5 us
    local parts
    parts=$((2 * $(one "$tmp/read3.json" "['pages']")))
    echo "$parts parts of 144 bytes at 1 per ms"
    [ "$parts" -lt 10000 ]
}
it_is_freed() {
    box free 1 && box list >"$tmp/list2.json" && [ "$(one "$tmp/list2.json" "['records']")" = "[]" ]
}

check "a landing is recorded" a_landing_is_recorded
check "board list tells it" it_is_listed
check "board read fills the gaps of a landing" gaps_are_filled
check "board read makes a landing that the database has not" a_database_without_it_gets_it
check "and lacks nothing that the log has" it_lacks_nothing_that_the_log_has
check "ten seconds of landing are read within ten" reading_takes_less_than_10_s
check "board free gives the space back" it_is_freed
check "board read of a record that is not there" fails_with 2 "no record 9 in the black box: unix:.*list the records with matrig board list" \
    bash -c "$(declare -f with_board at_board box); elf=$elf sockets=$sockets tmp=$tmp; box read 9 --db $tmp/x"
check "board read without a place to put it" fails_with 2 "no campaign: matrig board read needs --db DB" \
    build/matrig board --serial unix:x read 1
check "board without a verb it knows" fails_with 2 "unknown word after matrig board: 'erase'; see matrig board --help" build/matrig board --serial unix:x erase 1
check "board list takes no number" fails_with 2 "list takes no number: '3'" build/matrig board --serial unix:x list 3
finish
