#!/usr/bin/env bash
# What serial lost of a landing, CAN fills at its own rate, and the black box completes it; every sample says where it came from. What
# is expected is worked out by tests/link/lossy.py from the two recorded streams.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
matrig=build/matrig
lossy="python3 tests/link/lossy.py"
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

build/matrig-board --elf $elf --can "file:$tmp/all.can" --serial "file:$tmp/all.serial" --rig tests/runs/landing5.run \
    --nor "$tmp/nor" --for 9.4 2>"$tmp/board.err"
$matrig --quiet log --all --can "file:$tmp/all.can" --serial "file:$tmp/all.serial" --db "$tmp/all.db" >"$tmp/all.txt"
$matrig export "$tmp/all.db" 1 --format csv -o "$tmp/all.csv"
stretches() { # JSON-FILE SOURCE
    sqlite3 :memory: "with s as (select value as v from json_each(cast(readfile('$1') as text), '\$.landings[0].stretches'))
        select group_concat(json_extract(v, '\$.from_block') || '-' || json_extract(v, '\$.to_block'), ' ') from s
        where json_extract(v, '\$.source') = '$2'"
}

losses_are_made() {
    $lossy lose "$tmp/all.serial" "$tmp/all.can" "$tmp/lossy.serial" "$tmp/lossy.can" &&
        $matrig --json --quiet log --can "file:$tmp/lossy.can" --serial "file:$tmp/lossy.serial" --db "$tmp/lossy.db" >"$tmp/lossy.json"
}
can_fills() {
    $matrig export "$tmp/lossy.db" 1 --format csv -o "$tmp/lossy.csv" && $lossy check "$tmp/all.csv" "$tmp/lossy.serial" "$tmp/lossy.can" "$tmp/lossy.csv"
}
can_fills_rows() { # what the board said of the landing
    local table query=
    for table in edges motion zones predictions risks trust temperatures bands results; do query+="select '$table', count(*) from $table;"; done
    diff <(sqlite3 "$tmp/all.db" "$query") <(sqlite3 "$tmp/lossy.db" "$query")
}
# Displacements come every 2 ms on CAN: their newest are of the last block, or of the one before; or of the one before that, where with the
# last block the slower rate of the rest began.
it_is_told() {
    local can none last
    last=$(tail -n 1 "$tmp/all.csv" | cut -d, -f2)
    can=$(stretches "$tmp/lossy.json" can)
    none=$(stretches "$tmp/lossy.json" none)
    echo "CAN $can; none $none"
    # Messages of displacement that end in 3400 to 3420 were lost, and of tension in 3401, 3405 ... 3417: nobody has 3399 to 3417.
    [[ $can == "3000-3398 3418-3999 4001-4001 "*" 4963-4963 7500-$last" ||
        $can == "3000-3398 3418-3999 4001-4001 "*" 4963-4963 7500-$((last - 1))" ||
        $can == "3000-3398 3418-3999 4001-4001 "*" 4963-4963 7500-$((last - 2))" ]] && [ "$(wc -w <<<"$can")" = 30 ] &&
        [ "$none" = 3399-3417 ] || return 1
    $matrig --quiet report "$tmp/lossy.db" -o "$tmp/lossy.html" &&
        grep -q 'serial block records, 1 kHz; [0-9]* of [0-9]* ms from CAN (displacements at 500 Hz, tensions at 250 Hz), [0-9]* stretches' "$tmp/lossy.html"
}
peaks_hold() { # transducer by transducer, against those of the whole landing
    paste <(awk 'NF == 9 && $4 == "+-"' "$tmp/all.txt") <($matrig --quiet report "$tmp/lossy.db" -o /dev/null; \
        $matrig --quiet log --all --can "file:$tmp/lossy.can" --serial "file:$tmp/lossy.serial" --db "$tmp/again.db" | awk 'NF == 9 && $4 == "+-"') |
        awk '{ print; rows++; d = $3 - $12; if (d < 0) d = -d; if ($1 != $10 || d > 0.002) bad = 1 } END { exit bad || rows != 8 }'
}
the_campaign_knows() { # each block record says how it came
    [ "$(sqlite3 "$tmp/all.db" "select group_concat(distinct link) from blocks")" = 1 ]
}
the_box_completes() {
    local board
    timeout 600 build/matrig-board --elf $elf --serial "unix:$sockets/serial" --nor "$tmp/nor" --for 40 2>"$tmp/board.err" &
    board=$!
    timeout 600 $matrig --json --quiet board --serial "unix:$sockets/serial" read 1 --db "$tmp/lossy.db" >"$tmp/read.json" || return 1
    kill $board
    wait $board
    cat "$tmp/read.json"
    $matrig export "$tmp/lossy.db" 1 --format csv -o "$tmp/box.csv" && $lossy whole "$tmp/all.csv" "$tmp/box.csv" &&
        [ "$(sqlite3 "$tmp/lossy.db" "select group_concat(distinct link) from (select link from blocks order by link)")" = 1,2 ] &&
        grep -Eq '^# readings from serial block records, 1 kHz; [0-9]+ of [0-9]+ ms from the black box, [0-9]+ stretches' "$tmp/box.csv"
}
a_new_calibration_is_not_mixed_with_the_old() { # what CAN brought was computed by the old one: it fills nothing then
    $matrig --quiet bundle "$tmp/again.db" 1 -o "$tmp/anew.db" &&
        sqlite3 "$tmp/anew.db" "insert into recalibrations(landing, idx, item, was, value, made_us) values(1, 0, -1, 1, 1, 0)" &&
        $matrig --quiet export "$tmp/anew.db" 1 --format csv -o "$tmp/anew.csv" && ! grep -v '^#' "$tmp/anew.csv" | grep -q ',[SBC-]*C'
}

check "serial loses a second, single blocks and the end; CAN a little" losses_are_made
check "CAN fills what serial lost, sample by sample, and says so" can_fills
check "and what the board said meanwhile" can_fills_rows
check "summary and report tell the stretches" it_is_told
check "peak movements are those of the whole landing" peaks_hold
check "each record in the campaign says how it came" the_campaign_knows
check "the black box completes the landing, sample by sample" the_box_completes
check "a landing that is calibrated anew is not filled from CAN" a_new_calibration_is_not_mixed_with_the_old
finish
