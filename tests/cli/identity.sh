#!/usr/bin/env bash
# Host and board, bit for bit: seeded landings (tests/identity/draw.c) played to the emulated board, which carries what it knows of the
# runway from landing to landing itself; every field of each of its statements against what the host computes from the record.
# LANDINGS=3 SEED=1; `make identity` takes 20.
. "$(dirname "$0")/tap.sh"
trap 'kill $(jobs -p) 2>/dev/null' EXIT
matrig=build/matrig
elf=build/firmware/matrig.elf
landings=${LANDINGS:-3}
db=$tmp/identity.db

# A series begins: a board whose memory is blank, with the series' configuration.
configure() { # N.set
    rm -f "$tmp/nor.bin" "$tmp/flash.bin" "$tmp/board.sock"
    build/matrig-board --elf $elf --serial "unix:$tmp/board.sock" --flash "$tmp/flash.bin" 2>"$tmp/board.err" &
    local board=$! status
    $matrig board --serial "unix:$tmp/board.sock" config get -o "$tmp/built-in.cfg" >"$tmp/get.txt" &&
        awk 'NR == FNR { new[$1] = $0; next } $1 in new { $0 = new[$1] } 1' "$1" "$tmp/built-in.cfg" >"$tmp/wanted.cfg"
    kill -TERM $board && wait $board
    rm -f "$tmp/board.sock"
    build/matrig-board --elf $elf --serial "unix:$tmp/board.sock" --flash "$tmp/flash.bin" 2>"$tmp/board.err" &
    board=$!
    $matrig board --serial "unix:$tmp/board.sock" config set "$tmp/wanted.cfg" >"$tmp/set.txt"
    status=$?
    kill -TERM $board && wait $board
    return $status
}
play() { # N
    build/matrig-board --elf $elf --flash "$tmp/flash.bin" --nor "$tmp/nor.bin" --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" \
        --rig "$tmp/$1.run" --faults "$tmp/$1.faults" --seed "$1" 2>"$tmp/$1.err" &&
        $matrig --quiet log --all --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$db" >"$tmp/$1.txt" 2>"$tmp/$1.log"
}
ask() { sqlite3 "$db" "$1"; }
again() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/$1.json') as text), '\$.$2')"; }
# A landing in which the board saw a gear, by switches or, without any, by mats that moved at two transducers.
met() { # N
    grep -q '^  touchdown' "$tmp/$1.txt" || [ "$(awk 'NF == 9 && $4 == "+-" && ($3 > 0.02 || $3 < -0.02)' "$tmp/$1.txt" | wc -l)" -ge 2 ]
}
# One landing and what is known of the runway before it: from the board's own memory, of as many landings as it has seen a gear in.
same() { # N LANDING-OF-ITS-SERIES
    if [ "$2" = 1 ]; then rolled=0; configure "$tmp/$1.set" || return 1; fi
    play "$1" && build/tests/again/again "$db" "$1" >"$tmp/$1.json"
    tail -n 20 "$tmp/$1.json"
    ask "select 'runway of', landings, 'rolled in', $rolled from runways where landing = $1"
    [ "$(again "$1" possible)$(again "$1" differ)" = 10 ] && [ "$(again "$1" statements)" -gt 20 ] &&
        [ "$(ask "select landings from runways where landing = $1")" = $rolled ] || return 1
    if met "$1"; then rolled=$((rolled + 1)); fi
    statements=$((statements + $(again "$1" statements))) fields=$((fields + $(again "$1" fields)))
}

statements=0 fields=0 rolled=0
check "$landings landings are drawn" eval 'build/tests/identity/draw "$tmp" "$landings" "${SEED:-1}" >"$tmp/drawn.txt"'
while read -r number of_series; do
    check "landing $number, $of_series of its series: the same to the last bit" same "$number" "$of_series"
done <"$tmp/drawn.txt"
levels() { ask "select group_concat(n) from (select level || ': ' || count(*) as n from predictions group by level)"; }
charted() { ask 'select count(distinct landing) from risk_items where item = 2 and value is not null'; }
planned() { ask 'select count(distinct landing) from risk_items where item = 1 and value is not null'; }
doubted() { ask 'select count(distinct landing) from trust where doubts > 0'; }
echo "# $statements statements, $fields fields; statements by level $(levels); landings with a transducer in doubt: $(doubted), a plan: $(planned), a chart: $(charted)"
finish
