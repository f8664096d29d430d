#!/usr/bin/env bash
# Frames on the bus that are not the board's, in mid-landing. Serial is the record: beside it they change nothing. On CAN alone a time that
# cannot follow is not obeyed. And orders that are not the log's.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
played --elf build/firmware/matrig.elf --can "file:$tmp/all.can" --serial "file:$tmp/all.serial" \
    --rig tests/runs/landing5.run 2>"$tmp/board.err"

# inject FRAME LINE OUT: the frame after that line of the log, with its stamp
inject() { awk -v frame="$1" -v at="$2" '{ print } NR == at { print $1, $2, frame }' "$tmp/all.can" >"$3"; }
log() { # NAME LOG [--serial LINK]
    local name=$1 can=$2
    shift 2
    rm -f "$tmp/$name.db"*
    $matrig log --all --can "file:$can" "$@" --db "$tmp/$name.db" >"$tmp/$name.txt" 2>"$tmp/$name.err"
}
both=(--serial "file:$tmp/all.serial")
motion() { grep -E '^  (touchdown|deceleration|stop) ' "$1"; }

hello_of_another_layout() { # ended the log, exit 4
    inject 1F0#0300010000000100 12000 "$tmp/hello.can"
    log hello "$tmp/hello.can" "${both[@]}" || return 1
    cat "$tmp/hello.err" "$tmp/hello.txt"
    [ "$(grep -c '^RUN ' "$tmp/hello.txt")" = 1 ] && grep -q '^RUN 1: landing 5, done' "$tmp/hello.txt"
}
hello_of_another_layout_on_can_alone() {
    log alone "$tmp/hello.can" && cat "$tmp/alone.txt" && grep -q '^RUN 1: landing 5, done' "$tmp/alone.txt"
}
hello_before_the_board() { # serial will say whose board it is
    { sed -n 1p "$tmp/all.can" | awk '{ print $1, $2, "1F0#0300010000000100" }'; cat "$tmp/all.can"; } >"$tmp/first.can"
    log first "$tmp/first.can" "${both[@]}" || return 1
    cat "$tmp/first.err"
    grep -q '^RUN 1: landing 5, done' "$tmp/first.txt" && fails_with 4 'uses layout 3, but this matrig uses layout' \
        $matrig --quiet log --can "file:$tmp/first.can" --db "$tmp/refused.db"
}
landing_from_elsewhere() { # split the landing, and stated 37.988 +- 0.112 ft/s
    inject 0A0#0000000000000000 7000 "$tmp/landing.can"
    log plain "$tmp/all.can" "${both[@]}" && log landing "$tmp/landing.can" "${both[@]}" || return 1
    cat "$tmp/landing.txt"
    [ "$(grep -c '^RUN ' "$tmp/landing.txt")" = 1 ] && cmp <(motion "$tmp/plain.txt") <(motion "$tmp/landing.txt")
}
# The log begins after the 8th edge: what would have to be guessed is not stated.
beginning_is_missing() {
    local at
    at=$(grep -n ' 090#' "$tmp/all.can" | sed -n 8p | cut -d: -f1)
    tail -n +"$((at + 1))" "$tmp/all.can" >"$tmp/late.can"
    log late "$tmp/late.can" || return 1
    cat "$tmp/late.txt"
    grep -Eq 'incomplete  *the switch edges before edge [0-9]+ were not received' "$tmp/late.txt" && ! grep -q '^  touchdown ' "$tmp/late.txt" &&
        grep -q '^  motion  *not known: the first switch edges were not received' "$tmp/late.txt"
}
everything_of_the_catalogue() { mkdir -p "$tmp/each" && python3 tests/link/strangers.py "$tmp/all.can" "$tmp/all.serial" "$tmp/each" $matrig; }
# A stranger's orders, one for three frames of the board: told a line a second, kept, and the record replays for all that.
cat >"$tmp/stranger.py" <<'P'
import itertools, socket, struct, sys, time
board, door = socket.socket(socket.AF_UNIX), socket.socket(socket.AF_UNIX)
door.bind(sys.argv[2])
door.listen(1)
host = door.accept()[0]
while board.connect_ex(sys.argv[1]):
    time.sleep(0.02)
left, orders, n = b"", itertools.cycle([6, 7, 15, 18, 4]), 0 # bootrom, reset, backlog, box-free, mark
while data := board.recv(65536):
    host.sendall(data)
    whole = (len(left) + len(data)) // 16
    left = (left + data)[16 * whole:]
    for n in range(n + 1, n + 1 + whole):
        if 4000 < n < 16000 and n % 3 == 0:
            board.sendall(struct.pack("<IB3x8s", 0x400, 8, bytes([next(orders), 0, n & 255, n >> 8 & 255, 9, 0, 0, 0])))
P
orders_of_a_stranger() {
    local board bus
    python3 "$tmp/stranger.py" "$tmp/board" "$tmp/bus" &
    bus=$!
    build/matrig-board --elf build/firmware/matrig.elf --can "unix:$tmp/board" --serial "unix:$tmp/serial" --rig tests/runs/landing5.run --for 9.2 2>"$tmp/board.err" &
    board=$!
    await test -S "$tmp/bus" && await test -S "$tmp/serial" || return 1
    timeout 600 $matrig log --can "unix:$tmp/bus" --serial "unix:$tmp/serial" --db "$tmp/orders.db" >"$tmp/out" 2>"$tmp/told"
    wait $board $bus
    cat "$tmp/told"
    grep -q 'another program sent "backlog"; the board refused it: accepted only in a replay' "$tmp/told" && [ "$(grep -c '"bootrom"; the board refused it' "$tmp/told")" -lt 12 ] &&
        [ "$(sqlite3 "$tmp/orders.db" "select count(*) > 2000, sum(code <> 4 and detail = 0) from events where kind = 'ack' and code in (4, 6, 7, 15, 18)")" = '1|0' ] &&
        $matrig replay "$tmp/orders.db" 1 >"$tmp/again" && tail -n 3 "$tmp/again" && grep -Eq 'result +0 of [0-9]+ fields differ' "$tmp/again"
}

check "a hello of another layout in mid-landing is told, and the log goes on" hello_of_another_layout
check "and on CAN alone" hello_of_another_layout_on_can_alone
check "one before the board has spoken is refused on CAN alone" hello_before_the_board
check "a state of the landing that serial did not say changes nothing" landing_from_elsewhere
check "a landing without its beginning states no speed" beginning_is_missing
check "each message of the catalogue, not the board's, beside serial" everything_of_the_catalogue
check "orders of a stranger: refused, told, kept, and the record replays to the last field" orders_of_a_stranger
finish
