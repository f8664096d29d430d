#!/usr/bin/env bash
# The board's predictor on this computer (tests/again): landings 1 and 5 of tests/runs, played to the emulated board and logged. Every field of
# every statement follows from the record, to the last bit; a record that is another one is found out.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
db=$tmp/campaign.db

again() { # DB RUN: its exit status; the answer in again.json
    build/tests/again/again "$1" "$2" >"$tmp/again.json"
    local status=$?
    cat "$tmp/again.json"
    return $status
}
of() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/again.json') as text), '\$.$1')"; }
is() { # NAME VALUE...
    while [ $# -gt 0 ]; do
        [ "$(of "$1")" = "$2" ] || { echo "$1: $(of "$1"), wanted $2"; return 1; }
        shift 2
    done
}
board_said_what_follows() {
    again "$db" 1 && is possible 1 differ 0 first_warning_block "" && again "$db" 2 && is possible 1 differ 0 && [ "$(of fields)" -gt 3000 ] &&
        [ "$(of first_warning_block)" = "$(sqlite3 "$db" 'select min(block) from zones where landing = 2 and warning = 1')" ]
}
changed() { # NAME SQL: a database that says something else
    sqlite3 "$db" "vacuum into '$tmp/$1.db'" && sqlite3 "$tmp/$1.db" "$2"
}
another_record_differs() { # a joint, 0.01 mil wider
    changed joint "update runways set state = cast(substr(state, 1, 1042) || x'00000000' as blob) where landing = 2; update predict_items set value = value * 1.001 where landing = 2 and item = 8" || return 1
    again "$tmp/joint.db" 2 2>"$tmp/joint.err"
    grep -q 'the runway of RUN 2 is damaged' "$tmp/joint.err" || return 1
    changed grit "update predict_items set value = value * 1.002 where landing = 2 and item = 8"
    again "$tmp/grit.db" 2
    [ $? = 1 ] && [ "$(of differ)" -gt 100 ] && [ "$(of first.block)" -gt 1000 ]
}
what_lacks_is_named() { changed bare "delete from runways" && again "$tmp/bare.db" 2 && is possible 0 lacks 'the runway it was armed with'; }
# A gap that the record declares is none of the board's making; one that it does not declare is. So is what the board said beyond that.
middle='(select min(block) from predictions where landing = 2 and block % 50 = 0 and block > 2000)'
what_was_lost_is_no_difference() {
    changed lost "delete from predictions where landing = 2 and block = $middle; delete from zones where landing = 2 and block = $middle + 50"
    again "$tmp/lost.db" 2
    [ $? = 1 ] && is differ 2 first.field statement first.board "" || return 1
    sqlite3 "$tmp/lost.db" "insert into gaps(session, landing, link, message, channels, cause, count, from_block, to_block)
        select session, 2, 1, 'frame', 'all', 'link', 12, 1990, 2200 from landings where id = 2"
    again "$tmp/lost.db" 2 && is lost 2 differ 0
}
what_the_board_said_besides_is_a_difference() {
    changed besides "insert into zones select landing, block + 10, mats, start_ft, end_ft, lead_s, wheel_ft, 1, inferred_percent, links from zones where landing = 2 and block = $middle"
    again "$tmp/besides.db" 2
    [ $? = 1 ] && is differ 1 first.field statement first.board 1 first.host ""
}
blocks_that_lack_end_it() {
    changed hole "delete from blocks where landing = 2 and idx between 1512 and 1513; insert into gaps(session, landing, link, message, channels, cause,
        count, from_block, to_block) select session, 2, 1, 'block', 'all', 'board', 1, 1512, 1512 from landings where id = 2"
    again "$tmp/hole.db" 2 && is lacks_block 1513 differ 0 || return 1
    changed late "delete from blocks where landing = 2 and idx < 1500" && again "$tmp/late.db" 2 && is possible 0 lacks 'block records from arming on' || return 1
    changed edge "delete from edges where landing = 2 and count = 3" && again "$tmp/edge.db" 2 && is possible 0 lacks 'an edge'
}
check "landings 1 and 5 are played and logged" campaign_of "$db" 1 5
check "the board said what follows from its record, to the last bit" board_said_what_follows
check "what does not follow is found out" another_record_differs
check "what a record lacks is named" what_lacks_is_named
check "what was lost on the way is no difference" what_was_lost_is_no_difference
check "what the board said besides is one" what_the_board_said_besides_is_a_difference
check "blocks and edges that lack are named" blocks_that_lack_end_it
check "a RUN that is not there" fails_with 2 'RUN 9' build/tests/again/again "$db" 9
finish
