#!/usr/bin/env bash
# The slow log from the host: rows that a log saw, rows that nobody saw, and the temperature of a landing.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

# with_board ARGUMENTS...: matrig against a board that idles with the memory; its exit code
with_board() {
    local board status
    timeout 60 build/matrig-board --elf $elf --serial "unix:$sockets/serial" --nor "$tmp/${nor:-nor}" --temperature -5 --for 40 2>"$tmp/board.err" &
    board=$!
    timeout 60 build/matrig --quiet "$@"
    status=$?
    kill $board 2>/dev/null
    wait $board 2>/dev/null
    return $status
}
slow() { with_board --json board --serial "unix:$sockets/serial" slow "$@"; }
one() { python3 -c 'import json,sys; print(json.load(open(sys.argv[1]))'"$2"')' "$1"; }
columns="seq, boot, block, faults, state, temperature_c, d1_in, d8_in, t1_lb, t14_lb"

rows_are_logged_as_they_are_made() { # on both links, once; a minute apart by the frames' own time
    build/matrig-board --elf $elf --can "file:$tmp/can" --serial "file:$tmp/serial" --nor "$tmp/nor" --temperature 12.5,-60 --for 125 &&
        build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/live.db" &&
        build/matrig --quiet log --can "file:$tmp/can" --db "$tmp/can.db" || return 1 # bytes in a file have no times
    sqlite3 "$tmp/live.db" "select $columns, time_us from slow_log"
    [ "$(sqlite3 "$tmp/live.db" "select group_concat(seq || ' ' || boot || ' ' || block) from slow_log")" = "1 1 60000,2 1 120000" ] &&
        [ "$(sqlite3 "$tmp/can.db" "select round((max(time_us) - min(time_us)) / 1e6, 1) from slow_log")" = 60.0 ] &&
        [ "$(sqlite3 "$tmp/live.db" "select count(*) from slow_log where abs(temperature_c - 12.5 + block / 60000.0) < 0.06")" = 2 ] &&
        [ "$(sqlite3 "$tmp/live.db" "select count(*) from slow_log where abs(d1_in) < 0.01 and d8_in is not null and t14_lb is not null")" = 2 ]
}
what_nobody_saw_is_fetched() { # after a restart of the board: the same values, but nobody knows when that was
    slow --db "$tmp/new.db" >"$tmp/new.json" || return 1
    cat "$tmp/new.json"
    [ "$(one "$tmp/new.json" "['new']")" = 2 ] && [ "$(one "$tmp/new.json" "['held']")" = 2 ] && [ "$(one "$tmp/new.json" "['boot']")" = 2 ] &&
        [ "$(one "$tmp/new.json" "['missing']")" = 0 ] && [ "$(sqlite3 "$tmp/new.db" "select count(time_us) from slow_log")" = 0 ] &&
        [ "$(sqlite3 "$tmp/new.db" "select $columns, board_uid from slow_log")" = "$(sqlite3 "$tmp/live.db" "select $columns, board_uid from slow_log")" ]
}
only_what_is_missing_is_fetched() {
    sqlite3 "$tmp/live.db" "update slow_log set t1_lb = 77 where seq = 1; delete from slow_log where seq = 2"
    slow --db "$tmp/live.db" >"$tmp/more.json" || return 1
    cat "$tmp/more.json"
    [ "$(one "$tmp/more.json" "['new']")" = 1 ] && [ "$(sqlite3 "$tmp/live.db" "select count(*), count(time_us), max(t1_lb) from slow_log")" = "2|1|77.0" ]
}
all_go_to_a_file() {
    slow --csv "$tmp/slow.csv" || return 1
    cat "$tmp/slow.csv"
    [ "$(wc -l <"$tmp/slow.csv")" = 3 ] && [ "$(head -n 1 "$tmp/slow.csv" | tr , '\n' | wc -l)" = 29 ] &&
        sed -n 3p "$tmp/slow.csv" | grep -q '^2,1,120000,,[0-9]*,[0-9]*,10\.[45]' && [ "$(sed -n 3p "$tmp/slow.csv" | tr , '\n' | wc -l)" = 29 ]
}
a_night_is_drawn() { # 12 h of rows; the mat moves 3/16 in as it cools
    cp "$tmp/new.db" "$tmp/night.db"
    sqlite3 "$tmp/night.db" "delete from slow_log; with recursive n(i) as (select 1 union all select i + 1 from n where i < 720)
        insert into slow_log(board_uid, seq, boot, block, time_us, temperature_c, d1_in, d8_in, t1_lb, t2_lb)
        select 'A', i, 1, 60000 * i, 1700000000000000 + 60000000 * i, 20 - i / 60.0, 0.1 + 0.1875 * i / 720, null, 100, 100 - i / 72.0 from n"
    build/matrig --quiet report "$tmp/night.db" -o "$tmp/night.html" || return 1
    grep -q 'Between the landings' "$tmp/night.html" && grep -q 'moved, in' "$tmp/night.html" && grep -q 'mean tension, lb' "$tmp/night.html" &&
        grep -q 'temperature, C' "$tmp/night.html" && grep -q 'time since the first row, h' "$tmp/night.html" || return 1
    build/matrig --quiet report "$tmp/landing.db" -o "$tmp/none.html" && ! grep -q 'Between the landings' "$tmp/none.html"
}
wrong_usage_is_refused() {
    build/matrig board --serial unix:/nowhere slow 2>&1 | grep -q 'needs --db DB or --csv F' &&
        build/matrig board --serial unix:/nowhere slow 3 --csv x 2>&1 | grep -q 'takes no number' &&
        build/matrig board --serial unix:/nowhere list --csv x 2>&1 | grep -q "slow's"
}
a_landing_has_its_temperature() { # in its summary, its rows, and in the black box's record of it
    build/matrig-board --elf $elf --can "file:$tmp/can2" --serial "file:$tmp/serial2" --rig tests/runs/landing5.run --nor "$tmp/nor2" --temperature -3.2 --for 9.4 &&
        build/matrig --quiet log --can "file:$tmp/can2" --serial "file:$tmp/serial2" --db "$tmp/landing.db" >"$tmp/log.txt" || return 1
    grep temperature "$tmp/log.txt"
    grep -q '  temperature   -3\.19 +- 0\.58 C' "$tmp/log.txt" &&
        [ "$(sqlite3 "$tmp/landing.db" "select count(*) >= 5, min(links), max(temperature_c) from temperatures where landing = 1")" = "1|3|-3.1875" ] || return 1
    nor=nor2 with_board board --serial "unix:$sockets/serial" read 1 --db "$tmp/box.db" &&
        [ "$(sqlite3 "$tmp/box.db" "select count(*) >= 5, min(links), max(temperature_c) from temperatures where landing = 1")" = "1|4|-3.1875" ]
}

check "rows are logged as they are made" rows_are_logged_as_they_are_made
check "rows that nobody saw are fetched" what_nobody_saw_is_fetched
check "only rows that are missing are fetched" only_what_is_missing_is_fetched
check "all rows go to a CSV file" all_go_to_a_file
check "wrong usage is refused" wrong_usage_is_refused
check "a landing has its temperature" a_landing_has_its_temperature
check "the report draws a night" a_night_is_drawn
finish
