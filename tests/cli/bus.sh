#!/usr/bin/env bash
# matrig bus: who is on a CAN bus. The buses are made of one recorded board: awk adds to its identifiers, and gives it another chip.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT
played --elf build/firmware/matrig.elf --can "file:$tmp/first.log" --serial none --rig tests/runs/landing5.run --for 5 2>"$tmp/board.err"

# another BASE UID0: the board of first.log with that base; the four bytes are word 0 of its chip's identity, the low one first
another() {
    awk -v base="$1" -v uid0="$2" '
        function hex(s,  n, i) { for (i = 1; i <= length(s); i++) n = 16 * n + index("0123456789ABCDEF", substr(s, i, 1)) - 1; return n }
        { split($3, f, "#"); if (f[1] == "1F1") f[2] = uid0 substr(f[2], 9); printf "%s %s %03X#%s\n", $1, $2, hex(f[1]) + base, f[2] }' "$tmp/first.log"
}
bus() { sort -s -k 1,1 "$@"; } # one log of several
another 400 27003500 >"$tmp/second.log" && another 0 27003500 >"$tmp/same.log" && another 16 27003500 >"$tmp/near.log"
bus "$tmp/first.log" "$tmp/second.log" >"$tmp/two.log" && bus "$tmp/first.log" "$tmp/same.log" >"$tmp/same-base.log" &&
    bus "$tmp/first.log" "$tmp/near.log" >"$tmp/overlap.log"
# of no board: 123 every hundredth, 1F4 of two bytes, extended, asking
awk '{ print } NR % 100 == 0 { print $1, $2, "123#00" } NR == 500 { print $1, $2, "1F4#0001"; print $1, $2, "00012345#00"; print $1, $2, "124#R" }' \
    "$tmp/two.log" >"$tmp/others.log"

# told CODE LOG WORD...: exit code; what it says in $tmp/said, as JSON in $tmp/said.json
told() {
    local code=$1 log=$2
    shift 2
    $matrig bus "file:$log" "$@" >"$tmp/said" 2>"$tmp/said.err"
    [ $? -eq "$code" ] || { cat "$tmp/said" "$tmp/said.err"; return 1; }
    $matrig --json bus "file:$log" "$@" >"$tmp/said.json"
    [ $? -eq "$code" ] && cat "$tmp/said" "$tmp/said.json"
}
in_json() { python3 -c "import json, sys; d = json.load(open('$tmp/said.json')); print(d); sys.exit(not ($1))"; }

two_boards() {
    told 0 "$tmp/two.log" &&
        grep -Eq '^  0x000 +003100425847500F20343635 +[0-9.]+ +[0-9]+ ' "$tmp/said" && grep -Eq '^  0x190 +003500275847500F20343635 ' "$tmp/said" &&
        in_json '[(b["base"], b["board"]) for b in d["boards"]] == [(0, "003100425847500F20343635"), (400, "003500275847500F20343635")]' &&
        in_json 'd["others"] == [] and d["collisions"] == [] and d["good"] and d["free"][:4] == [0x3c0, 0x3d0, 0x3e0, 0x3f0]' || return 1
    # as many frames as the logs have in their first 3 s
    local count
    count=$(awk -F '[().]' 'NR == 1 { first = $2 + $3 / 1e6 } $2 + $3 / 1e6 <= first + 3' "$tmp/first.log" | wc -l)
    in_json "[b['frames'] for b in d['boards']] == [$count, $count] and d['frames'] == 2 * $count"
}
so_long_as_said() { # and no longer than the log
    local count
    told 0 "$tmp/two.log" --for 1.5 && count=$(awk -F '[().]' 'NR == 1 { first = $2 + $3 / 1e6 } $2 + $3 / 1e6 <= first + 1.5' "$tmp/two.log" | wc -l) &&
        in_json "d['frames'] == $count" && told 0 "$tmp/two.log" --for 60 && in_json "d['frames'] == $(wc -l <"$tmp/two.log") and 4 < d['heard_s'] < 5.1"
}
a_base_is_held_against_all() {
    told 0 "$tmp/two.log" --base 0x3c0 && grep -q '^base  *0x3c0 is free' "$tmp/said" && in_json 'd["asked"] == {"base": 0x3c0, "free": True, "taken": []}' &&
        # temperature and slow_row would be the command and config_word of the first board, which nobody has sent
        told 1 "$tmp/first.log" --base 800 && in_json 'd["asked"]["taken"] == [0x400, 0x401] and not d["good"] and d["collisions"] == []' &&
        grep -q '^base  *0x320 is not free: 0x400 temperature (command of the board at 0x000), 0x401 slow_row (config_word of the board at 0x000)$' "$tmp/said" &&
        told 1 "$tmp/two.log" --base 400 && told 0 "$tmp/first.log" --base 400 && told 0 "$tmp/first.log" --base 0x190
}
one_base_twice() {
    told 1 "$tmp/same-base.log" && grep -q 'two boards have it: give one of them another, over its serial port' "$tmp/said" &&
        in_json 'sorted(b["board"] for b in d["boards"]) == ["003100425847500F20343635", "003500275847500F20343635"]' &&
        in_json '[(c["kind"], c["base"]) for c in d["collisions"]] == [("base", 0)] and not d["good"]'
}
# As they come out of the box, switched on together: their frames spoil each other (hil/board/canbus.h). Whose chips: uid of their seeds.
two_new_boards() {
    played --elf build/firmware/matrig.elf --can "file:$tmp/new.log" --serial none --for 4 --board-seed 1 --and --board-seed 2 2>"$tmp/new.err" &&
        grep 'sent the same identifier at the same time' "$tmp/new.err" && told 1 "$tmp/new.log" &&
        in_json 'sorted(b["board"] for b in d["boards"]) == ["005100363736330332343933", "00C700EF3937341331363738"] and [c["kind"] for c in d["collisions"]] == ["base"]'
}
# Three and four: few of their rounds are whole.
more_new_boards() {
    local more=(--and --board-seed 5 --and --board-seed 6) count
    for count in 3 4; do
        [ $count = 3 ] || more+=(--and --board-seed 7)
        played --elf build/firmware/matrig.elf --can "file:$tmp/more.log" --serial none --for 4 "${more[@]}" 2>"$tmp/more.err" && told 1 "$tmp/more.log" &&
            grep -q "^  0x000  $count boards have it: give all but one another, over their serial ports$" "$tmp/said" &&
            in_json "len(set(b['board'] for b in d['boards'])) == $count and [(c['kind'], c['base']) for c in d['collisions']] == [('base', 0)] and not d['good']" || return 1
    done
}
bases_too_near() { # of 92 identifiers 32 are 0x10 beyond another one
    told 1 "$tmp/overlap.log" && in_json '[(c["kind"], c["base"], c["identifiers"]) for c in d["collisions"]] == [("identifiers", 0, 32), ("identifiers", 16, 32)]'
}
of_no_board() {
    local hundredth
    told 1 "$tmp/others.log" --for 60 && hundredth=$(($(wc -l <"$tmp/two.log") / 100)) &&
        in_json "[(o['id'], o['frames']) for o in d['others']] == [(0x123, $hundredth), (0x124, 1), (0x1f4, 1)] and (d['extended'], d['remote']) == (1, 1)" &&
        in_json '[(c["kind"], c["base"], c["identifiers"]) for c in d["collisions"]] == [("identifiers", 0, 1)]' && grep -q '0x1f4 site (1 frame of no board)' "$tmp/said" &&
        # 0x123 is vouched for by nobody: 0x123 - 0x070 is the base that would have it as sync
        told 1 "$tmp/others.log" --base 0xb3 && in_json '0x123 in d["asked"]["taken"]'
}
silence() {
    : >"$tmp/empty.log"
    fails_with 3 'no hello from a board: file:.*empty.log; no frame at all' $matrig bus "file:$tmp/empty.log" &&
        told 0 "$tmp/empty.log" --base 0x190 && grep -q 'nothing was heard in 0.0 s: if the bus is in use, are rate and cable right?' "$tmp/said" &&
        in_json 'd["asked"]["free"] and d["boards"] == []'
}
no_hello() {
    grep -v ' 1F0#' "$tmp/first.log" >"$tmp/mute.log"
    told 0 "$tmp/mute.log" && grep -q 'no hello from a board' "$tmp/said" && in_json 'd["boards"] == [] and 0x180 in [o["id"] for o in d["others"]] and d["note"] == "no hello from a board"' &&
        told 1 "$tmp/mute.log" --base 0
}
another_layout() {
    sed 's/ 1F0#../ 1F0#03/' "$tmp/first.log" >"$tmp/older.log"
    told 0 "$tmp/older.log" && tr '\n' ' ' <"$tmp/said" | grep -q 'the board at 0x000 speaks layout 3, this matrig layout [0-9]*: ' &&
        in_json '[(b["layout"], b["same_layout"]) for b in d["boards"]] == [(3, False)]'
}
a_board_that_speaks() {
    local began=$SECONDS
    with_board --speed real --can "unix:$sockets/can" -- $matrig --json bus "unix:$sockets/can" --for 1.5 >"$tmp/said.json" && cat "$tmp/board.err" &&
        in_json '[b["base"] for b in d["boards"]] == [0] and 1.5 <= d["heard_s"] < 3' && [ $((SECONDS - began)) -lt 20 ]
}
wrong_words() {
    fails_with 2 "base 0x3ff: --base; 0x3fe at most, or identifiers would be beyond 0x7ff" $matrig bus "file:$tmp/two.log" --base 0x3ff &&
        fails_with 2 'one board.s: file:.*@0x190; give the bus without @BASE' $matrig bus "file:$tmp/two.log@0x190" &&
        fails_with 2 "for --for" $matrig bus "file:$tmp/two.log" --for 0.5 && fails_with 2 LINK $matrig bus &&
        fails_with 3 'cannot open .*none.log' $matrig bus "file:$tmp/none.log" &&
        { head -c 1000 "$tmp/two.log" >"$tmp/cut.log" && fails_with 4 'the log ends inside a line' $matrig bus "file:$tmp/cut.log"; }
}

check "two boards, their bases and frames" two_boards
check "so long as said, of the log's own time" so_long_as_said
check "a base is held against all that is there, also unheard" a_base_is_held_against_all
check "two boards of one base are a collision" one_base_twice
check "and two new boards on one emulated bus" two_new_boards
check "three and four of them, too" more_new_boards
check "two bases that share identifiers are one" bases_too_near
check "what is of no board is counted, and may be one" of_no_board
check "a silent bus" silence
check "boards that say no hello are of no board" no_hello
check "another layout is told" another_layout
check "a board that speaks" a_board_that_speaks
check "wrong words are refused" wrong_words
finish
