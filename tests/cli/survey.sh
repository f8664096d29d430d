#!/usr/bin/env bash
# A survey of the mat as it is taken: typed at full speed, doubted, cut off, resumed, from a sheet, and given to the emulated board, which says what it holds.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT
readings() { awk -v n="$1" -v add="${2:-0}" 'BEGIN {for (i = 0; i < n; i++) printf "%.3f\n", 33.6 + 0.02 * (i % 7) + add}'; }
kept() { sqlite3 "$1" "select count(*) from gage_readings where value_in is not null ${2:-}"; }

full_speed() {
    local begin end
    begin=$(date +%s%N)
    readings 168 | USER=jk $matrig survey "$tmp/a.db" --edges none >"$tmp/a.txt" 2>"$tmp/a.err" || return 1
    end=$(date +%s%N)
    echo "168 readings in $(((end - begin) / 1000000)) ms"
    cat "$tmp/a.txt" | head -n 3
    [ "$(kept "$tmp/a.db")" = 168 ] && grep -q '^survey  *1, ended$' "$tmp/a.txt" && grep -q '^read  *168 of 168, 0 confirmed$' "$tmp/a.txt" &&
        [ "$(sqlite3 "$tmp/a.db" "select value_in from gage_readings where kind='gap' and line=1 and place=8")" = 33.62 ] &&
        [ "$(sqlite3 "$tmp/a.db" "select value_in from gage_readings where kind='gap' and line=2 and place=41")" = 33.6 ]
}

# The prompt n/181 comes when n readings are on disk. Killed at any moment, all of them are there, and at most one more.
killed() {
    local prompts i killed_at survey keys
    for killed_at in 3 40 97; do
        rm -f "$tmp"/k.db* "$tmp/k.keys"
        mkfifo "$tmp/k.keys"
        $matrig survey "$tmp/k.db" --edges none <"$tmp/k.keys" >/dev/null 2>"$tmp/k.err" &
        survey=$!
        for i in $(seq 168); do
            echo 33.61
            sleep 0.002
        done >"$tmp/k.keys" 2>/dev/null &
        keys=$!
        for i in $(seq 500); do
            grep -qa "$killed_at/168" "$tmp/k.err" 2>/dev/null && break
            sleep 0.01
        done
        kill -9 $survey
        kill $keys 2>/dev/null
        wait $survey $keys
        prompts=$(tr ' ' '\n' <"$tmp/k.err" | grep -ao '^[0-9]*/168' | tail -n 1 | cut -d/ -f1)
        i=$(kept "$tmp/k.db")
        echo "killed after prompt $prompts: $i readings on disk"
        [ "$prompts" -ge "$killed_at" ] && [ "$i" -ge "$prompts" ] && [ "$i" -le $((prompts + 1)) ] || return 1
        [ "$(sqlite3 "$tmp/k.db" 'pragma integrity_check')" = ok ] || return 1
    done
    # and it goes on where it was
    echo 33.62 | $matrig survey "$tmp/k.db" --edges none >"$tmp/k.txt" 2>"$tmp/k.err"
    grep -q "continuing survey 1, $i of 168 points read" "$tmp/k.err" && grep -q "^survey  *1, in progress$" "$tmp/k.txt" && grep -q "^read  *$((i + 1)) of 168, " "$tmp/k.txt"
}

doubts() {
    printf '33.6\n34.0\n33.7\n34.2\n34.201\nx\nu\n33.55\nn dirt\ns\nq\n' | $matrig survey "$tmp/d.db" --edges none >"$tmp/d.txt" 2>"$tmp/d.err" || return 1
    cat "$tmp/d.err"
    [ "$(grep -c 'Type the same value again' "$tmp/d.err")" = 2 ] && grep -q 'not a reading' "$tmp/d.err" && grep -q 'undone: line 1' "$tmp/d.err" || return 1
    # 34.0 was doubted and 33.7 read instead; 34.2 and 34.201 agree and were kept, then undone; 33.55 came in their place
    [ "$(sqlite3 "$tmp/d.db" 'select group_concat(coalesce(value_in, "-")||"/"||skipped||"/"||confirmed||coalesce(note,""), " ") from gage_readings')" = \
        "33.6/0/0 33.7/0/0 34.201/0/1 -/0/0 33.55/0/0 33.55/0/0dirt -/1/0" ]
}

by_mistake() { # it counts no more, stays, and the one before is the newest
    printf '33.51\nq\n' | $matrig --quiet survey "$tmp/w.db" --edges none >/dev/null && $matrig survey "$tmp/w.db" --end | grep 'survey  *1, ended' || return 1
    fails_with 2 'no unfinished survey' $matrig survey "$tmp/w.db" --end && $matrig --quiet survey "$tmp/w.db" --new </dev/null >/dev/null || return 1
    fails_with 2 'no readings: survey 2 of .*--withdraw 2' $matrig survey "$tmp/w.db" --end && fails_with 2 'only work together' $matrig survey "$tmp/w.db" --withdraw 2 &&
        $matrig survey "$tmp/w.db" --withdraw 2 --reason 'no mat there' && $matrig survey "$tmp/w.db" --show | grep 'survey  *1, ended' || return 1
    fails_with 2 'survey 2 was withdrawn: .*matrig landing' $matrig survey "$tmp/w.db" --withdraw 2 --reason again && $matrig landing "$tmp/w.db" | grep 'survey  *2 .*no mat there$' && [ "$(sqlite3 "$tmp/w.db" 'select count(*) from gage_surveys')" = 2 ]
}

millimetres() {
    printf '851.2048\n33.6 in\n' | $matrig --si survey "$tmp/mm.db" --edges none >"$tmp/mm.txt" 2>"$tmp/mm.err" || return 1
    [ "$(sqlite3 "$tmp/mm.db" "select group_concat(printf('%.4f', value_in)) from gage_readings")" = 33.5120,33.6000 ] &&
        grep -Eq '^ +m +mm +mm +mm +mm +mm$' "$tmp/mm.txt" && grep -q ' 851.205 ' "$tmp/mm.txt"
}

sheet() {
    $matrig survey "$tmp/a.db" --edges both --sheet "$tmp/sheet.csv" || return 1
    [ "$(wc -l <"$tmp/sheet.csv")" = 195 ] && grep -q '^gap,1,8,,33.6200,' "$tmp/sheet.csv" || return 1
    # every gap 0.01 in closed on line 1, 0.02 in on line 2; stations where they were
    awk -F, 'NR == 1 {print; next} $1 == "gap" {$4 = $5 - 0.01 * $2} $1 == "station" {$4 = 0} {printf "%s,%s,%s,%s,,,\n", $1, $2, $3, $4}' \
        "$tmp/sheet.csv" >"$tmp/filled.csv"
    printf '\357\273\277' | cat - "$tmp/filled.csv" >"$tmp/marked.csv" # as a spreadsheet's "CSV UTF-8" begins
    $matrig --json survey "$tmp/a.db" --new --edges both --from "$tmp/marked.csv" >"$tmp/sheet.json" || return 1
    python3 - "$tmp/sheet.json" <<'EOF'
import json, sys
o = json.load(open(sys.argv[1]))
assert o["read"] == 194 and o["ended"] and o["since"] == 1, o["read"]
for line in range(4):
    assert all(abs(c + 0.01 * (line + 1)) < 1e-6 for c in o["change"]["gap"][line])
# line 2 against the edges: nothing anchors it but its first row: 42 spans of 0.02 in
assert abs(o["moved"][1][42][0] + 42 * 0.02) < 1e-6, o["moved"][1][42]
assert o["worst_bow"]["verdict"] == "not known" or o["worst_bow"]["limit"] == 1.57143
EOF
}

sheet_faults() {
    sed 's/^gap,1,8,[^,]*,/gap,1,8,34.9,/' "$tmp/filled.csv" >"$tmp/far.csv"
    $matrig survey "$tmp/f.db" --new --edges both --from "$tmp/far.csv" >/dev/null 2>"$tmp/far.err"
    [ $? = 1 ] && grep -q 'not accepted, because it differs by +1.400 in from the design distance: line 1 .*mats 81 to 90' "$tmp/far.err" &&
        [ "$(kept "$tmp/f.db")" = 193 ] || return 1
    $matrig survey "$tmp/f.db" --edges both --from "$tmp/far.csv" --doubtful >/dev/null 2>&1 && [ "$(kept "$tmp/f.db" "and confirmed")" = 1 ] || return 1
    fails_with 1 'all 194 readings are equal to those of survey' $matrig --quiet survey "$tmp/a.db" --new --edges both --from "$tmp/marked.csv" || return 1
    printf 'kind,line,place,reading_in\ngap,5,0,33.5\n' >"$tmp/bad.csv"
    fails_with 4 'no gage point .gap. 5 0: .*bad.csv, line 2' $matrig --quiet survey "$tmp/b.db" --from "$tmp/bad.csv" || return 1
    printf 'kind,line,place,reading_in\ngap,1,0,33.5\ngap,1,0,33.5\n' >"$tmp/bad.csv"
    fails_with 4 'occurs twice: .*line 3' $matrig --quiet survey "$tmp/b.db" --from "$tmp/bad.csv" || return 1
    printf 'kind,line,place,reading_in\ngap,1,0,33.5x\n' >"$tmp/bad.csv"
    fails_with 4 'not a reading: .33.5x.' $matrig --quiet survey "$tmp/b.db" --from "$tmp/bad.csv" || return 1
    printf 'kind,line,place,reading_in\r\ngap,1,0,33.5\rgap,1,1,33.5\r\n' >"$tmp/bad.csv" # a carriage return alone hides no reading
    fails_with 4 'more cells than .*bad.csv, line 2' $matrig --quiet survey "$tmp/b.db" --from "$tmp/bad.csv" || return 1
    printf 'kind,line,where\n' >"$tmp/bad.csv"
    fails_with 4 'no column place' $matrig --quiet survey "$tmp/b.db" --from "$tmp/bad.csv" && [ ! -e "$tmp/b.db" ]
}

board() { # can|serial...
    local link links=()
    for link in "$@"; do links+=("--$link" "unix:$sockets/$link"); done
    timeout 600 build/matrig-board --elf build/firmware/matrig.elf "${links[@]}" --speed max --for 3000 >/dev/null 2>&1 &
    board=$!
}
# Somebody else listens on CAN: the segment's slack is the mean of its four lines beyond 33.5 in, in ten thousandths.
loaded() { # SEGMENTS
    grep -q "^loaded  *$1 segments\$" "$tmp/load.txt" && grep -q '^read back  *42 segments$' "$tmp/load.txt" && grep -q '^different  *0$' "$tmp/load.txt"
}
loads() {
    local status=0 log
    board can serial
    timeout 600 $matrig --quiet log --listen --can "unix:$sockets/can" --db "$tmp/log.db" >/dev/null 2>&1 &
    log=$!
    $matrig survey "$tmp/a.db" --survey 1 --load "unix:$sockets/serial" >"$tmp/load.txt" 2>&1 || status=1
    kill $board
    wait $board $log
    cat "$tmp/load.txt"
    loaded 42 || status=1
    [ "$(sqlite3 "$tmp/a.db" 'select segments from gage_loads where survey=1')" = 42 ] || status=1
    sqlite3 "$tmp/log.db" "select distinct substr(hex(data),1,8) from frames where can_id=0x1f8 and substr(hex(data),5,4)<>'FFFF'" |
        awk '{print substr($1, 1, 4) substr($1, 7, 2) substr($1, 5, 2)}' | sort >"$tmp/said.txt"
    sqlite3 "$tmp/a.db" "select printf('%02X0A%04X', place, cast(round(10000*(avg(value_in)-33.5)) as integer)) from gage_readings where kind='gap' and survey=1 group by place" |
        sort >"$tmp/wanted.txt"
    echo "$(wc -l <"$tmp/said.txt") segments told"
    cmp "$tmp/said.txt" "$tmp/wanted.txt" && return $status
}
loads_over_can_a_part() {
    local status=0
    board can
    $matrig survey "$tmp/k.db" --load "unix:$sockets/can" --can >"$tmp/load.txt" 2>&1 || status=1
    cat "$tmp/load.txt"
    loaded 42 || status=1
    kill $board
    wait $board
    board can
    printf '33.601\r33.602\r\nq\n' | $matrig survey "$tmp/c.db" --edges none >"$tmp/c.txt" 2>&1 # carriage returns, as a caliper's
    $matrig survey "$tmp/c.db" --load "unix:$sockets/can" --can >"$tmp/load.txt" 2>&1 || status=1
    cat "$tmp/load.txt"
    loaded 2 && grep -q '^not surveyed  *40$' "$tmp/load.txt" || status=1
    kill $board
    wait $board
    return $status
}

report_has_them() {
    awk -F, 'NR == 1 {print; next} {$4 = $1 == "gap" ? $5 + 0.005 : 0; printf "%s,%s,%s,%s,,,\n", $1, $2, $3, $4}' "$tmp/sheet.csv" >"$tmp/next.csv"
    $matrig survey "$tmp/a.db" --new --edges both --note '<script>alert(1)</script>' --from "$tmp/next.csv" >/dev/null || return 1
    $matrig report "$tmp/a.db" -o "$tmp/a.html" && grep -q '<section id="survey">' "$tmp/a.html" &&
        grep -q 'opening of joints, movement and in-plane bow' "$tmp/a.html" && ! grep -q '<script>alert' "$tmp/a.html" &&
        [ "$(sed -n '/<section id="survey">/,/<.section>/p' "$tmp/a.html" | grep -o '"k":"marks"' | wc -l)" -ge 11 ] || return 1
    # every gap 0.005 in wider than in the first survey, before that 0.01 to 0.04 in narrower by line: as much from point to point
    sed -n '/"total movement (in)"/,/"bow (in)"/p' "$tmp/a.html" | grep -o '"n":"survey.*' |
        sed 's/.*"n":"\(survey [0-9]*\)","x":.*"y":\[\([45]\),0,\([-0-9,]*\)\].*/\1 \2 \3/' | tr , '\n' | sort -u | tee "$tmp/moved"
    [ "$(tr '\n' ' ' <"$tmp/moved")" = "-250 500 survey 2 4 -250 survey 3 5 500 " ]
}

# The board that begins again has no survey, and says so; the landing was armed with one.
outlives_a_power_cut() {
    printf 'matrig-faults 1\nat 4.7 power-cut 30\n' >"$tmp/cut.faults" &&
        build/matrig-board --elf build/firmware/matrig.elf --rig tests/runs/landing5.run --faults "$tmp/cut.faults" --can "file:$tmp/cut.can" \
            --serial "file:$tmp/cut.serial" 2>"$tmp/cut.board" && $matrig --quiet log --all --can "file:$tmp/cut.can" --serial "file:$tmp/cut.serial" --db "$tmp/cut.db" >"$tmp/cut.txt"
    sqlite3 "$tmp/cut.db" 'select count(slack_in) from slack' | grep -x 42 && build/tests/again/again "$tmp/cut.db" 1 | grep '"possible":true.*"differ":0,'
}

check "168 readings at full speed" full_speed
check "killed at any moment, at most one is lost, and it goes on" killed
check "doubts, undo, skip, notes" doubts
check "millimetres" millimetres
check "a sheet, written and read" sheet
check "a sheet with faults" sheet_faults
check "given to a board and read back" loads
check "over CAN, and a part" loads_over_can_a_part
check "a partial one ends" bash -c "$matrig survey $tmp/d.db --edges none --end | grep -q ', ended'"
check "of a landing in which the board lost its power, it stays" outlives_a_power_cut
check "the report shows them, and runs nothing" report_has_them
check "one that nothing was read of does not end; one begun by mistake is withdrawn" by_mistake
check "no such survey" fails_with 2 'no survey 9: .*a.db; the campaign has surveys 1 to 3' $matrig survey "$tmp/a.db" --show --survey 9
check "silly words" fails_with 2 'accepts only one of' $matrig survey "$tmp/a.db" --show --end
finish
