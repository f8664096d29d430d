#!/usr/bin/env bash
# The slow log: a row a minute of tension and temperature is logged and drawn; the temperature of a landing.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf

rows_are_logged_as_they_are_made() { # once, though both links carry them
    build/matrig-board --elf $elf --can "file:$tmp/can" --serial "file:$tmp/serial" --temperature 12.5,-60 --for 125 &&
        build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/live.db" || return 1
    sqlite3 "$tmp/live.db" "select block, temperature_c, t1_lb, t14_lb, time_us from slow_log"
    [ "$(sqlite3 "$tmp/live.db" "select group_concat(block) from slow_log")" = "60000,120000" ] &&
        [ "$(sqlite3 "$tmp/live.db" "select count(*) from slow_log where abs(temperature_c - 12.5 + block / 60000.0) < 0.06 and t1_lb is not null and t14_lb is not null")" = 2 ]
}
can_alone_has_them() { # a minute apart by the frames' own time
    build/matrig --quiet log --can "file:$tmp/can" --db "$tmp/can.db" && [ "$(sqlite3 "$tmp/can.db" "select group_concat(block) from slow_log")" = "60000,120000" ] &&
        [ "$(sqlite3 "$tmp/can.db" "select round((max(time_us) - min(time_us)) / 1e6, 1) from slow_log")" = 60.0 ]
}
serial_alone_has_them() {
    build/matrig --quiet log --serial "file:$tmp/serial" --db "$tmp/serial.db" && [ "$(sqlite3 "$tmp/serial.db" "select group_concat(block) from slow_log")" = "60000,120000" ]
}
a_night_is_drawn() { # 12 h of rows
    cp "$tmp/live.db" "$tmp/night.db"
    sqlite3 "$tmp/night.db" "delete from slow_log; with recursive n(i) as (select 1 union all select i + 1 from n where i < 720)
        insert into slow_log(board_uid, block, time_us, temperature_c, t1_lb, t2_lb)
        select 'A', 60000 * i, 1700000000000000 + 60000000 * i, 20 - i / 60.0, 100, 100 - i / 72.0 from n"
    build/matrig --quiet report "$tmp/night.db" -o "$tmp/night.html" || return 1
    grep -q 'Tension and temperature between landings' "$tmp/night.html" && grep -q 'mean tension (lb)' "$tmp/night.html" &&
        grep -q 'temperature (°C)' "$tmp/night.html" && grep -q 'time since the first row (h)' "$tmp/night.html" || return 1
    build/matrig --quiet report "$tmp/landing.db" -o "$tmp/none.html" && ! grep -q 'Tension and temperature between landings' "$tmp/none.html"
}
a_landing_has_its_temperature() { # in its summary and its rows
    build/matrig-board --elf $elf --can "file:$tmp/can2" --serial "file:$tmp/serial2" --rig tests/runs/landing5.run --temperature -3.2 --for 9.4 &&
        build/matrig --quiet log --all --can "file:$tmp/can2" --serial "file:$tmp/serial2" --db "$tmp/landing.db" >"$tmp/log.txt" || return 1
    grep temperature "$tmp/log.txt"
    grep -q '  temperature   -3\.19 +- 0\.58 °C' "$tmp/log.txt" &&
        [ "$(sqlite3 "$tmp/landing.db" "select count(*) >= 5, min(links), max(temperature_c) from temperatures where landing = 1")" = "1|2|-3.1875" ] # serial is the record
}

check "rows are logged as they are made" rows_are_logged_as_they_are_made
check "and over CAN alone" can_alone_has_them
check "and over serial alone" serial_alone_has_them
check "a landing has its temperature" a_landing_has_its_temperature
check "the report draws a night" a_night_is_drawn
finish
