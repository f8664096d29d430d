#!/usr/bin/env bash
# matrig board runway, on the emulated board: show, load, forget; what survives a restart of the board; a damaged memory is told.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
trap 'kill $(jobs -p) 2>/dev/null' EXIT

board() { # OPTION...: runs until it is stopped, keeps its memory in nor.bin
    rm -f "$tmp/board.sock"
    build/matrig-board --elf build/firmware/matrig.elf --serial "unix:$tmp/board.sock" --nor "$tmp/nor.bin" "$@" 2>"$tmp/board.err" &
    board=$!
}
stop() { kill -TERM $board 2>/dev/null; wait $board 2>/dev/null; }
runway() { $matrig --json board --serial "unix:$tmp/board.sock" runway "$@" >"$tmp/$out.json"; }
in_json() { sqlite3 :memory: "select json_extract(cast(readfile('$tmp/$1.json') as text), '\$.$2')"; }
make_file() { # FILE: joints that open and close, 7 landings
    { printf 'mats 420\nlandings 7\nresistance 1.25\n'; awk 'BEGIN { for (j = 1; j <= 421; j++) printf "joint %d %.5f\n", j, j * 7 % 3001 / 1e5 }'; } >"$1"
}
with_board() { # OUT WORD...: on a board of its own, which ends with the link
    out=$1
    shift
    board
    runway "$@"
    local status=$?
    stop
    return $status
}
new_board() { with_board new && [ "$(in_json new source)" = 'not measured' ] && [ "$(in_json new landings)" = 0 ] && [ "$(in_json new copy_a)" = blank ]; }
loaded() {
    make_file "$tmp/seven.txt"
    with_board loaded load "$tmp/seven.txt" -o "$tmp/back.txt" && [ "$(in_json loaded landings)" = 7 ] &&
        [ "$(in_json loaded source)" = 'from the host' ] && [ "$(in_json loaded copy_a)" = intact ] &&
        diff <(grep -v '^#' "$tmp/back.txt") "$tmp/seven.txt"
}
after_restart() { with_board again && [ "$(in_json again source)" = 'from memory, copy A' ] && [ "$(in_json again crc)" = "$(in_json loaded crc)" ] && [ "$(in_json again landings)" = 7 ]; }
damaged() { # a bit of copy A, sector 4094 of the memory
    printf '\x55' | dd of="$tmp/nor.bin" bs=1 seek=$((4094 * 4096 + 300)) conv=notrunc 2>/dev/null
    with_board damaged && [ "$(in_json damaged source)" = 'not measured' ] && in_json damaged copy_a | grep -q '^damaged'
}
forgotten() {
    with_board give load "$tmp/seven.txt" && with_board forget forget && [ "$(in_json forget landings)" = 0 ]
}
other_mats() { sed 's/^mats 420/mats 419/; /^joint 421 /d' "$tmp/seven.txt" >"$tmp/short.txt" && board && fails_with 1 "the file has a runway of 419 mats, but the board has one of 420" $matrig board --serial "unix:$tmp/board.sock" runway load "$tmp/short.txt"; local s=$?; stop; return $s; }
too_wide() { sed 's/^joint 9 .*/joint 9 0.03100/' "$tmp/seven.txt" >"$tmp/wide.txt" && board && fails_with 4 'no opening exceeds the slack' $matrig board --serial "unix:$tmp/board.sock" runway load "$tmp/wide.txt"; local s=$?; stop; return $s; }

check "a new board knows no runway" new_board
check "one is given, kept and told back, each joint" loaded
check "it is there after a restart" after_restart
check "a damaged copy is told, and the runway is one that nobody has measured" damaged
check "the board is made to forget" forgotten
check "a runway of other mats is refused" other_mats
check "one with a joint wider than its slack is refused" too_wide
sed -i 's/^joint 9 .*/joint 9 wide/' "$tmp/seven.txt"
check "a line that is none is named" fails_with 4 'seven.txt:12' $matrig board --serial unix:x runway load "$tmp/seven.txt"
check "no verb it knows" fails_with 2 "unknown action of runway: 'keep'" $matrig board --serial unix:x runway keep
check "load without a file" fails_with 2 'no file to load' $matrig board --serial unix:x runway load
check "no link" fails_with 2 'needs --serial' $matrig board runway
finish
