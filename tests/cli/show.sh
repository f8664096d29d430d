#!/usr/bin/env bash
# matrig show: a campaign's landings at a glance, in the numbers of their summaries; a landing's summary again; a landing that is there twice.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/campaign.db
show() { $matrig --quiet show "$@"; }

played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run 2>/dev/null
$matrig --quiet log --all --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >"$tmp/log.txt"

# --- nothing yet ---
empty_says_what_to_do() {
    $matrig --quiet landing "$tmp/empty.db" --series one >/dev/null && sqlite3 "$tmp/empty.db" "delete from series" && show "$tmp/empty.db" >"$tmp/out" || return 1
    xargs <"$tmp/out" >"$tmp/line" # as lines were broken
    cat "$tmp/line"
    grep -q "no landing yet: $tmp/empty.db; record landings with matrig log --db $tmp/empty.db" "$tmp/line" &&
        grep -q "no series yet; begin one with matrig landing $tmp/empty.db --series NAME" "$tmp/line" && grep -q "no survey yet; begin one with matrig survey $tmp/empty.db" "$tmp/line" &&
        [ "$($matrig --json show "$tmp/empty.db")" = "{\"landings\":[],\"db\":\"$tmp/empty.db\",\"series\":0,\"surveys\":0}" ]
}
either_number() { # RUN, or the number that the board gave; an error names the other
    local called run
    run=1 called=$(sqlite3 "$db" 'select board_landing from landings')
    cmp <($matrig show "$db" "$run") <($matrig show "$db" "landing$called") && cmp <($matrig export "$db" "$run" --format csv) <($matrig export "$db" "landing$called" --format csv) &&
        fails_with 2 "no landing with board number 999: $db" $matrig show "$db" landing999 && cp "$db" "$tmp/other.db" &&
        sqlite3 "$tmp/other.db" "update landings set board_landing = 77 where id = $run" && fails_with 2 "no such landing: RUN 77 in .* .landing 77 of the board is RUN $run." $matrig show "$tmp/other.db" 77 &&
        sqlite3 "$tmp/other.db" "insert into landings(session, boot, board_landing, armed_us, state) select session, boot + 1, 77, armed_us, state from landings" &&
        fails_with 2 'more than one landing with board number 77' $matrig bundle "$tmp/other.db" landing77 -o "$tmp/none.db"
}
check "an empty campaign says what to do" empty_says_what_to_do
check "one that is not there is none" fails_with 3 "no such database: $tmp/none.db" $matrig show "$tmp/none.db"
check "a landing by its RUN or its board's number" either_number
check "nor a landing" fails_with 2 "no such landing: RUN 7 in $db" $matrig show "$db" 7

# --- the summary again ---
again() { show "$db" 1 >"$tmp/again.txt" && cmp "$tmp/log.txt" "$tmp/again.txt"; }
check "a landing in the words that log had" again
check "the temperature with its unit" grep -E '^  temperature +20\.[0-9]{2} \+- 0\.29 °C, ' "$tmp/log.txt"
emulated() { # in the heading, and in the list; a board of another lot is not
    cp "$db" "$tmp/other-lot.db" && sqlite3 "$tmp/other-lot.db" "update landings set board_uid = substr(board_uid, 1, 8) || '123456' || substr(board_uid, 15)"
    grep -x 'RUN 1: landing 5, done, calibration unknown (emulated board, synthetic data)' "$tmp/log.txt" && show "$db" | grep ' 5, done, emulated ' &&
        $matrig --json show "$db" 1 | grep -q '"emulated":true' && $matrig --json show "$db" | grep -q '"emulated":true' && $matrig export "$db" 1 --format csv | head -n 1 | grep '(emulated, synthetic data)' &&
        ! { show "$tmp/other-lot.db"; show "$tmp/other-lot.db" 1; $matrig export "$tmp/other-lot.db" 1 --format csv; } | grep -e 'synthetic' -e ', emulated'
}
check "that a board was emulated" emulated
undated() { # read from a file without times
    show "$db" | grep -q '^ *1  no date ' && $matrig --json show "$db" | grep -q '"armed":null.*"uncalibrated":null' && show "$db" | grep 'calibration unknown$' && show "$db" 1 | grep 'done, calibration unknown ' && $matrig export "$db" 1 --format csv | grep '^# calibration unknown' && ! show "$db" | grep 1970 && $matrig report "$db" -o "$tmp/dates.html" 2>/dev/null && ! grep -q '1970-' "$tmp/dates.html"
}
check "a recording without times has no date" undated
who_says_so() { # the login name where no shell has set USER, an empty one too
    cp "$db" "$tmp/who.db" && env -u USER $matrig --quiet landing "$tmp/who.db" 1 --note a >/dev/null && USER= $matrig --quiet landing "$tmp/who.db" 1 --note b >/dev/null && USER=kl $matrig --quiet landing "$tmp/who.db" 1 --note c >/dev/null &&
        [ "$(sqlite3 "$tmp/who.db" 'select group_concat(who) from landing_changes')" = "$(id -un),$(id -un),kl" ]
}
check "who noted it, also without USER" who_says_so
said() {
    $matrig --quiet landing "$db" 1 --note "brakes pulled left" --who kl >/dev/null &&
        $matrig --quiet landing "$db" 1 --observe wave --station 88 >/dev/null && show "$db" 1 >"$tmp/said.txt" || return 1
    diff "$tmp/log.txt" "$tmp/said.txt" >"$tmp/more"
    cat "$tmp/more"
    ! grep '^<' "$tmp/more" | grep -qv '^<   outcome ' && grep -q '^>   outcome .*(evidence: observation' "$tmp/more" && grep -q '^>.* kl .*brakes pulled left$' "$tmp/more" && grep -q '^>.*wave .*88\.0' "$tmp/more"
}
check "and what was said of it since" said

# --- the list has the summaries' numbers ---
$matrig --quiet log --can "file:$tmp/can" --db "$tmp/can.db" >/dev/null
$matrig --quiet log --serial "file:$tmp/serial" --db "$tmp/serial.db" >/dev/null
head -c 480000 "$tmp/serial" >"$tmp/short" && $matrig --quiet log --serial "file:$tmp/short" --db "$tmp/short.db" >/dev/null 2>&1
awk '!/ can0 090#/ || n++ % 3' "$tmp/can" >"$tmp/edges" && $matrig --quiet log --can "file:$tmp/edges" --db "$tmp/edges.db" >/dev/null 2>&1
{ head -c 300000 "$tmp/serial"; tail -c +310000 "$tmp/serial"; } >"$tmp/hole" && $matrig --quiet log --serial "file:$tmp/hole" --db "$tmp/hole.db" >/dev/null 2>&1
$matrig --quiet export "$db" 1 --format csv -o "$tmp/run1.csv" && $matrig --quiet import "$tmp/import.db" "$tmp/run1.csv" --map tests/exchange/exported.json >/dev/null
same_numbers() { # NAME
    show=$($matrig --quiet --json show "$tmp/$1.db") summary=$($matrig --quiet --json show "$tmp/$1.db" 1) python3 - <<'P'
import json, os
row, s = json.loads(os.environ["show"])["landings"][0], json.loads(os.environ["summary"])
links = s["links"].values()
wanted = {"state": s["state"], "landing": s["landing"], "warned": s["zone"]["warned"], "all_heard": s["zone"]["all_heard"],
    "touchdown_speed_ft_s": s.get("touchdown_speed_ft_s"), "touchdown_speed_error_ft_s": s.get("touchdown_speed_error_ft_s"),
    "stop_station_ft": s.get("stop_station_ft"), "stop_station_error_ft": s.get("stop_station_error_ft"),
    "warning_t_s": s["zone"].get("t_s"), "warning_start_ft": s["zone"].get("most_start_ft"), "warning_end_ft": s["zone"].get("most_end_ft"), "lost": sum(l["lost"] for l in links),
    "silent": any(l["silent"] for l in links), "torn": s["torn"]}
print(row, wanted, sep="\n")
assert all(row[k] == v for k, v in wanted.items()), [(k, row[k], v) for k, v in wanted.items() if row[k] != v]
P
}
for name in campaign can serial short edges hole import; do check "as in its summary: $name" same_numbers $name; done
some_lack() { # so that the cases are what they are called
    [ "$($matrig --json show "$tmp/short.db" | grep -c '"stop_station_ft":null')" = 1 ] && $matrig --json show "$tmp/hole.db" | grep -Eq '"lost":[1-9]' &&
        $matrig show "$tmp/import.db" | grep -q imported
}
check "of a record that is cut or holed, too" some_lack

# --- what people see ---
long=$(printf 'word %.0s' $(seq 30))
# Where the zone warned of starts and ends is the record's: by the phase of the board's blocks to the landing, which any other start-up of an image moves.
a_row() {
    local start end zone_m
    read -r start end zone_m < <(sqlite3 -separator ' ' "$db" "select printf('%.1f', start_ft), printf('%.1f', end_ft), printf('%.1f to %.1f', start_ft * 0.3048, end_ft * 0.3048) from zones where warning = 1 order by mats desc, block limit 1")
    $matrig --quiet landing "$tmp/can.db" --series bare --pattern standard >/dev/null 2>&1
    $matrig --quiet landing "$db" 1 --note "$long" >/dev/null && show "$db" >"$tmp/out" || return 1
    cat "$tmp/out"
    [ "${end%.*}" -gt 100 ] && grep -Eq "^ +1  .*5, done, emulated +35\.489 \+- 0\.007 +90\.830 \+- 0\.702  $start to $end" "$tmp/out" && grep -q 'word wo\.\.\.; 2 notes; 1 seen$' "$tmp/out" &&
        $matrig --si show "$db" | grep -Eq "5, done, emulated +10\.8170 \+- 0\.0022 +27\.68[0-9]{2} \+- 0\.21[0-9]{2}  $zone_m"
}
check "speed, stop, warning, losses and notes in a row" a_row
voided() { cp "$db" "$tmp/void.db" && $matrig --quiet landing "$tmp/void.db" 1 --void --reason "a trial" >/dev/null && show "$tmp/void.db" | grep -q '5, done, VOID' && show "$tmp/void.db" 1 | grep -q 'the landing is void'; }
check "a landing that does not count" voided

# --- twice ---
logged_twice() {
    cp "$db" "$tmp/twice.db" && $matrig log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/twice.db" 2>&1 >/dev/null | grep 'RUN 2 is the same landing as RUN 1: .*matrig landing .*twice.db 2 --void' &&
        $matrig --json --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/third.db" | grep -q '"same_as":null' && $matrig --json --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/third.db" | grep -q '"same_as":1' &&
        show "$tmp/twice.db" | grep -q 'the same landing as RUN 1$' && show "$tmp/twice.db" 2 | grep -q 'RUN 1 is the same landing$' && ! show "$tmp/twice.db" 1 | grep 'the same landing'
}
check "one that is logged twice" logged_twice
imported_twice() { # the log of one link of it, and another instrument's readings of it
    cp "$db" "$tmp/again.db" && $matrig import "$tmp/again.db" "$tmp/can" >"$tmp/out" &&
        $matrig --json import "$tmp/again.db" "$tmp/run1.csv" --map tests/exchange/exported.json --like 1 >"$tmp/out" && [ "$(show "$tmp/again.db" | grep -c 'the same landing as RUN 1')" = 2 ]
}
check "one that is imported, too" imported_twice
void_is_not_the_same() { $matrig --quiet landing "$tmp/twice.db" 1 --void --reason twice >/dev/null && ! show "$tmp/twice.db" | grep 'the same landing'; }
check "not when the other one is void" void_is_not_the_same
another_is_not() { # number and board alone are no proof: a board that lost its memory counts from 1 again
    cp "$tmp/again.db" "$tmp/other.db" && sqlite3 "$tmp/other.db" "update edges set tick = tick + 7 where landing = 2 and count = 5" && ! show "$tmp/other.db" | grep '^ *2 .*the same landing' &&
        $matrig --json show "$tmp/other.db" 2 | grep -q '"same_as":null'
}
check "nor when a switch was captured at another time" another_is_not

# --- many ---
many() {
    cp "$db" "$tmp/many.db" && python3 tests/report/grow.py "$tmp/many.db" "$(take 60 400)" && (ulimit -v 150000; show "$tmp/many.db") >"$tmp/out" && tail -n 3 "$tmp/out" && [ "$(grep -c ', done' "$tmp/out")" = "$(take 60 400)" ]
}
check "many take little memory" many
finish
