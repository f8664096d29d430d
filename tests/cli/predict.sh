#!/usr/bin/env bash
# matrig predict: landings 1 and 5 of tests/runs, played to the emulated board and logged. Their truth comes from a chain that shares
# no code with the predictor (tests/runs/README.md) and is written in the run files; the tolerances are the intervals it states.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/campaign.db

record() { # RUNFILE
    played --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --rig "$1" --seed 13 \
        2>"$tmp/board.err" &&
        $matrig --quiet log --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$db" >"$tmp/log.txt"
}
predict() { $matrig predict "$db" 1 >"$tmp/1.txt" && $matrig predict "$db" 2 >"$tmp/5.txt" && $matrig --json predict "$db" 2 >"$tmp/5.json"; }
truth() { sed -n "s/^truth $1 //p" tests/runs/landing5.run; }
in_json() { sqlite3 :memory: "select $1 from json_each(json_extract(cast(readfile('$tmp/5.json') as text), '$.statements'))"; }
stated() { in_json "json_extract(value, '\$.$1')" | tail -n 1; }
within() { awk -v a="$1" -v b="$2" -v most="$3" 'BEGIN { d = a - b; print a, b; exit !(d <= most && d >= -most) }'; }

last_zone_holds() {
    tail -n 5 "$tmp/5.txt"
    within "$(stated start_ft)" "$(truth zone_at_end_start_station_ft)" 2.0 && within "$(stated end_ft)" "$(truth zone_at_end_end_station_ft)" 6.7
}
longest_zone_holds() {
    within "$(in_json "max(json_extract(value, '\$.mats'))")" "$(truth zone_ahead_longest_mats)" 20
}
warned_in_time() { # after braking is known, before the wheel stands in 50 mats
    grep '^  predictor' "$tmp/5.txt"
    awk '/^  predictor  *first warning/ { t = $5; found = 1; exit } END { exit !(found && t > 1 && t < 3.5) }' "$tmp/5.txt"
}
one_is_quiet() { ! grep -q '  warning[, ]' "$tmp/1.txt" && grep -q '^  predictor  *no warning' "$tmp/1.txt"; }
json_agrees() {
    local rows
    rows=$(grep -c '[0-9]  \(quiet\|advisory\|warning\)' "$tmp/5.txt")
    [ "$rows" -gt 20 ] && [ "$rows" -eq "$(in_json 'count(*)')" ]
}

check "landings 1 and 5 are played and logged" eval 'record tests/runs/landing1.run && record tests/runs/landing5.run'
check "both are predicted" predict
check "landing 5: the zone at the end lies where it is stated" last_zone_holds
check "landing 5: the longest zone ahead" longest_zone_holds
check "landing 5 is warned of" warned_in_time
check "landing 1 is not" one_is_quiet
check "JSON has the same rows" json_agrees
# +- is one standard error, here as in the log, where the board said the same of its first warning; JSON has it too.
one_error() {
    local in_log text
    in_log=$(grep -m 1 'to station' "$tmp/log.txt" | sed 's/.*+- \([0-9.]*\) .*/\1/')
    text=$(grep -m 1 '  warning[, ]' "$tmp/5.txt" | sed 's/^[^+]*+- *[0-9.]*[^+]*+- *\([0-9.]*\) .*/\1/')
    echo "log $in_log, predict $text, JSON $(in_json "json_extract(value, '\$.end_error_ft')" | head -n 3 | tr '\n' ' ')"
    grep -q '+- is one standard error' "$tmp/5.txt" && within "$text" "$in_log" 0.15 &&
        [ "$(in_json "json_extract(value, '\$.verdict') = 'warning' and abs(json_extract(value, '\$.end_error_ft') - $in_log) < 0.15" | grep -c 1)" -ge 1 ] &&
        [ "$(in_json "typeof(json_extract(value, '\$.start_error_ft'))" | grep -c real)" -gt 20 ]
}
in_one_table() { # with --si, too: each column in the first one
    $matrig --si predict "$db" 2 >"$tmp/si.txt" && sed -n '2,4p' "$tmp/si.txt" && grep -c ' basis$' "$tmp/si.txt" | grep -x 1 && grep '^ *time .*basis\|^ *s  *m .*basis' "$tmp/si.txt" &&
        ! grep -v '^ \{16\}[a-z]\|^  the longest\|^  [a-z]' "$tmp/si.txt" | awk 'length > 100' | grep .
}
check "with --si it is one table, too" in_one_table
check "+- is one standard error, and JSON has it" one_error
# Both in order: the second begins with the zone that the first has left, which the landing by itself does not know of.
several() { $matrig predict "$db" 1 2 >"$tmp/both.txt" && $matrig --json predict "$db" 1 2 >"$tmp/both.json"; }
of_both() { sqlite3 :memory: "select $1 from json_each(json_extract(cast(readfile('$tmp/both.json') as text), '$.runs')) where json_extract(value, '$.run') = $2"; }
first_is_the_same() { # and the second is not
    [ -s "$tmp/both.txt" ] && diff <(sed '/^RUN 2/,$d' "$tmp/both.txt") "$tmp/1.txt" && ! diff -q <(sed -n '/^RUN 2/,$p' "$tmp/both.txt") "$tmp/5.txt"
}
second_is_surveyed() { # read anew by the landing's own script, so taken over
    [ "$(of_both "json_extract(value, '$.segments_surveyed')" 1)" -gt 30 ] && [ "$(of_both "json_extract(value, '$.segments_surveyed')" 2)" -gt 30 ]
}
check "two landings in order" several
check "the first is as by itself, the second is not" first_is_the_same
second_reads_the_same() { # and that is news: the board has forgotten the first reading. Exit 1: it has not had this one
    sqlite3 "$db" "vacuum into '$tmp/same.db'" && sqlite3 "$tmp/same.db" "update slack set slack_in = (select o.slack_in from slack o join surveys v on
        v.id = o.survey where v.landing = 1 and o.segment = slack.segment) where survey = (select id from surveys where landing = 2)" &&
        { $matrig --json predict "$tmp/same.db" 1 2 >"$tmp/same.json"; [ $? -le 1 ]; } && grep -o '"segments_surveyed":4[0-2]' "$tmp/same.json" | wc -l | grep -x 2
}
check "both were surveyed" second_is_surveyed
check "a reading that is the same is news" second_reads_the_same
# The board's own run from what it recorded: every field of every statement; and a record that is another is found out.
again() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.again.$2')"; }
board_said_what_follows() {
    grep 'computed again' "$tmp/1.txt" "$tmp/5.txt"
    [ "$(grep -c 'all the same to the last bit' "$tmp/1.txt")$(grep -c 'all the same to the last bit' "$tmp/5.txt")" = 11 ] &&
        [ "$(again "$tmp/5.json" possible)" = 1 ] && [ "$(again "$tmp/5.json" differ)" = 0 ] && [ "$(again "$tmp/5.json" fields)" -gt 3000 ]
}
changed() { # NAME SQL: a database that says something else
    sqlite3 "$db" "vacuum into '$tmp/$1.db'" && sqlite3 "$tmp/$1.db" "$2"
}
another_record_differs() { # a joint, 0.01 mil wider
    changed joint "update runways set state = cast(substr(state, 1, 1042) || x'00000000' as blob) where landing = 2; update predict_items set value = value * 1.001 where landing = 2 and item = 8" || return 1
    ! $matrig predict "$tmp/joint.db" 2 >"$tmp/joint.txt" 2>"$tmp/joint.err"
    grep -q 'the runway of RUN 2 is damaged' "$tmp/joint.err" || return 1
    changed grit "update predict_items set value = value * 1.001 where landing = 2 and item = 8"
    $matrig --json predict "$tmp/grit.db" 2 >"$tmp/grit.json"
    [ $? = 1 ] && [ "$(again "$tmp/grit.json" differ)" -gt 100 ] && [ "$(again "$tmp/grit.json" first.block)" -gt 1000 ]
}
what_lacks_is_named() {
    changed bare "delete from runways" && $matrig predict "$tmp/bare.db" 2 >"$tmp/bare.txt" && grep -q 'lacks the runway it was armed with' "$tmp/bare.txt"
}
# A gap that the record declares is none of the board's making; one that it does not declare is. So is what the board said beyond that.
middle='(select min(block) from predictions where landing = 2 and block % 50 = 0 and block > 2000)'
what_was_lost_is_no_difference() {
    changed lost "delete from predictions where landing = 2 and block = $middle; delete from zones where landing = 2 and block = $middle + 50"
    ! $matrig predict "$tmp/lost.db" 2 >"$tmp/lost.txt" && grep -q 'computed again from the record: 2 of .* DIFFER.*statement: board nothing' "$tmp/lost.txt" || return 1
    sqlite3 "$tmp/lost.db" "insert into gaps(session, landing, link, message, channels, cause, count, from_block, to_block)
        select session, 2, 1, 'frame', 'all', 'link', 12, 1990, 2200 from landings where id = 2"
    $matrig predict "$tmp/lost.db" 2 >"$tmp/lost.txt" && grep 'not compared: 2 fields' "$tmp/lost.txt" && grep -q 'all the same to the last bit' "$tmp/lost.txt"
}
what_the_board_said_besides_is_a_difference() {
    changed besides "insert into zones select landing, block + 10, mats, start_ft, end_ft, lead_s, wheel_ft, 1, inferred_percent, links from zones where landing = 2 and block = $middle"
    ! $matrig predict "$tmp/besides.db" 2 >"$tmp/besides.txt" && grep '1 of .* DIFFER; first block 2[0-9]*, statement: board 1, host nothing' "$tmp/besides.txt"
}
blocks_that_lack_end_it() {
    changed hole "delete from blocks where landing = 2 and idx between 1512 and 1513; insert into gaps(session, landing, link, message, channels, cause,
        count, from_block, to_block) select session, 2, 1, 'block', 'all', 'board', 1, 1512, 1512 from landings where id = 2"
    $matrig predict "$tmp/hole.db" 2 >"$tmp/hole.txt" && grep 'computed again up to block 1513, which the record lacks' "$tmp/hole.txt" &&
        grep -q 'all the same to the last bit' "$tmp/hole.txt" || return 1
    changed late "delete from blocks where landing = 2 and idx < 1500" && $matrig predict "$tmp/late.db" 2 >"$tmp/late.txt" &&
        grep 'lacks block records from arming on' "$tmp/late.txt" || return 1
    changed edge "delete from edges where landing = 2 and count = 3" && $matrig predict "$tmp/edge.db" 2 >"$tmp/edge.txt" && grep 'lacks an edge' "$tmp/edge.txt"
}
check "what was lost on the way is no difference" what_was_lost_is_no_difference
check "what the board said besides is one" what_the_board_said_besides_is_a_difference
check "blocks and edges that lack are named" blocks_that_lack_end_it
check "the board said what follows from its record, to the last bit" board_said_what_follows
check "what does not follow is found out" another_record_differs
check "what a record lacks is named" what_lacks_is_named
changed boards "update landings set board_uid = '000000000000000000000000' where id = 2"
check "landings of two boards" fails_with 2 'RUN 2 is of board 0*, those before of [0-9A-F]*: give the landings of one runway' $matrig predict "$tmp/boards.db" 1 2
check "out of order" fails_with 2 'out of order: RUN 1 after 2' $matrig predict "$db" 2 1
check "a RUN that is not there, after one that is" fails_with 2 'RUN 9' $matrig predict "$db" 1 9
check "a RUN that is not there" fails_with 2 'RUN 9' $matrig predict "$db" 9
check "no RUN" fails_with 2 'DB RUN' $matrig predict "$db"
finish
