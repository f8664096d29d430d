#!/usr/bin/env bash
# firmware/schedule.def is the only place that says what runs when: every row is asked for by the file that it names, and no other file has a
# block or a phase of its own.
. "$(dirname "$0")/tap.sh"
table=firmware/schedule.def

# rows TABLE: "NAME WHO PERIOD" of each
rows() { sed -nE 's/^(BLOCKS|TICKS)\((\w+), *(\w+), *[0-9]+, *([01], *)?"([^"]+)".*/\2 \5 \3/p' "$1"; }
each_row_is_asked_for() { # TABLE
    local name who period count=0 missing=0
    while read -r name who period; do
        count=$((count + 1))
        case $who in
        common/*) grep -q "% $period ==" "$who" || { echo "$name: no $period in $who"; missing=1; } ;; # which the host runs too
        *) grep -Eq "(DUE|BLOCKS_UNTIL)\($name, " "firmware/$who" || { echo "$name: firmware/$who does not ask for it"; missing=1; } ;;
        esac
    done < <(rows "$1")
    [ $missing = 0 ] && [ $count -ge 35 ] && [ $count = "$(grep -Ec '^(BLOCKS|TICKS)\(' "$1")" ]
}
finds_a_row_that_nobody_asks_for() {
    { cat $table; echo 'BLOCKS(IDLENESS, 100, 9, 0, "app.c", "nobody")'; } >"$tmp/more.def"
    ! each_row_is_asked_for "$tmp/more.def" && echo 'IDLENESS: firmware/app.c does not ask for it' | diff - <(each_row_is_asked_for "$tmp/more.def")
}
# a remainder by a number of blocks; those of rings of four and of rounds are places, not times
remainders() { grep -nE '(index|block|phase|tick)s?(_[a-z_]+)? *% *([0-9]{2,}|[A-Z_]*(PERIOD|BLOCKS|EVERY|TICKS)[A-Z_]*)' "$@"; }
# The two exceptions are places in a ring of blocks, and of channels.
no_other_file_has_a_phase() { ! remainders firmware/*.c | grep -v "APP_NEWEST_BLOCKS\|QUALITY_ROUND_BLOCKS" | grep .; }
finds_a_phase_elsewhere() { echo 'if (index % 1000 == 313)' >"$tmp/phase.c" && remainders "$tmp/phase.c"; }

check "each row is asked for by the file that it names" each_row_is_asked_for $table
check "a row that nobody asks for is found" finds_a_row_that_nobody_asks_for
check "no other file of the firmware has a phase of its own" no_other_file_has_a_phase
check "a phase elsewhere is found" finds_a_phase_elsewhere
finish
