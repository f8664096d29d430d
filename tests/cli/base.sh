#!/usr/bin/env bash
# A board gets another base on its CAN bus: the bus is listened to before, the board is found at its base behind. Who else is on the bus is a
# recording whose identifiers awk has moved, or frames that a relay puts between.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT
can=unix:$sockets/can serial=unix:$sockets/serial
played --elf build/firmware/matrig.elf --can "file:$tmp/first.log" --serial none --rig tests/runs/landing5.run --for 5 2>"$tmp/played.err"
moved() { # BASE UID0: the board of first.log with that base, another chip
    awk -v base=$(($1)) -v uid0="$2" '
        function hex(s,  n, i) { for (i = 1; i <= length(s); i++) n = 16 * n + index("0123456789ABCDEF", substr(s, i, 1)) - 1; return n }
        { split($3, f, "#"); if (f[1] == "1F1") f[2] = uid0 substr(f[2], 9); printf "%s %s %03X#%s\n", $1, $2, hex(f[1]) + base, f[2] }' "$tmp/first.log"
}
moved 0x190 27003500 >"$tmp/second.log"

over_can() { with_board --jumper --speed real --can "$can" -- $matrig board --can "$can$1" config "${@:2}"; }
# over_serial CAN-LOG WORD...: that is the bus that is heard
over_serial() { with_board --serial "$serial" -- $matrig board --serial "$serial" --can "file:$1" config "${@:2}"; }
with_base() { # BASE [REVISION]: the board's text with that base
    sed -e "s/^\(site\.can_base = \)[0-9]*/\1$(($1))/" -e "s/^\(site\.revision = \)[0-9]*/\1${2:-0}/" "$tmp/rig.cfg" >"$tmp/base.cfg" && grep -q "^site.can_base = $(($1))" "$tmp/base.cfg"
}
forget() { rm -f "$tmp/flash"; } # a new board: base 0, revision 0

the_text() { over_can '' get -o "$tmp/rig.cfg" && grep -q '^site.can_base = 0' "$tmp/rig.cfg"; }
over_can_the_board_is_followed() {
    with_base 0x190 && over_can '' set "$tmp/base.cfg" >"$tmp/said" 2>"$tmp/said.err" || { cat "$tmp/said.err"; return 1; }
    cat "$tmp/said" "$tmp/said.err"
    grep -qx 'site.can_base: 0 -> 400' "$tmp/said" && grep -q '^1 field changed, stored and read back: revision 1' "$tmp/said" &&
        [ "$(tail -n 1 "$tmp/said")" = "the board now uses $can,base=0x190" ] && [ ! -s "$tmp/said.err" ]
}
there_it_is() { # after its power was off, too; and not where it was
    over_can ,base=0x190 get >"$tmp/back.cfg" && grep -q '^site.can_base = 400' "$tmp/back.cfg"
}
and_back() {
    with_base 0 1 && over_can ,base=0x190 set "$tmp/base.cfg" >"$tmp/said" && cat "$tmp/said" && [ "$(tail -n 1 "$tmp/said")" = "the board now uses $can,base=0x000" ] &&
        over_can '' get >"$tmp/back.cfg" && grep -q '^site.can_base = 0' "$tmp/back.cfg"
}
a_base_that_is_taken_is_refused() { # in one line, and the board keeps its own
    forget
    with_base 0x190 && fails_with_set 1 "^matrig: another board already uses base 0x190 of file:$tmp/second.log; give this board a different base\$" \
        over_serial "$tmp/second.log" set "$tmp/base.cfg" && over_can '' get | grep -q '^site.revision = 0'
}
fails_with_set() { # CODE PATTERN COMMAND...: as fails_with, of a function
    local code=$1 pattern=$2 status
    shift 2
    "$@" >"$tmp/said" 2>"$tmp/said.err"
    status=$?
    echo "exit $status"
    cat "$tmp/said" "$tmp/said.err"
    [ "$status" -eq "$code" ] && [ "$(wc -l <"$tmp/said.err")" -eq 1 ] && grep -Eq -- "$pattern" "$tmp/said.err"
}
a_free_base_is_taken_without_a_word() {
    forget
    with_base 0x3c0 && over_serial "$tmp/second.log" set "$tmp/base.cfg" >"$tmp/said" 2>"$tmp/said.err" && cat "$tmp/said" "$tmp/said.err" && [ ! -s "$tmp/said.err" ]
}
another_change_does_not_listen() { # nor does it warn
    forget
    sed 's/^\(site\.touchdown_ft = \).*/\14.25/' "$tmp/rig.cfg" >"$tmp/other.cfg"
    with_board --serial "$serial" -- $matrig board --serial "$serial" config set "$tmp/other.cfg" >"$tmp/said" 2>"$tmp/said.err" && [ ! -s "$tmp/said.err" ] &&
        ! grep -q 'the board now uses' "$tmp/said" && over_serial "$tmp/none.log" set "$tmp/other.cfg"
}
words() {
    fails_with 2 'matrig board config get needs one link' $matrig board --serial unix:/a --can unix:/b config get && fails_with 4 'site.can_base cannot be .1023.: .*; give 0 to 1022' \
        $matrig board config check <(sed 's/^\(site\.can_base = \)[0-9]*/\11023/' "$tmp/rig.cfg")
}

check "a board tells its base" the_text
check "over CAN the board is followed to its new base, and read there" over_can_the_board_is_followed
check "there it is from then on" there_it_is
check "and back" and_back
check "a base that another board has is refused" a_base_that_is_taken_is_refused
check "a base that is free is taken" a_free_base_is_taken_without_a_word
check "a change of anything else does not listen" another_change_does_not_listen
check "wrong words are refused" words
finish
