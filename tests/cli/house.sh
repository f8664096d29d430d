#!/usr/bin/env bash
# What tests/house/layers.txt says of the folders holds; and the checker finds each thing that must not be.
. "$(dirname "$0")/tap.sh"

house=$tmp/house
table=$tmp/layers.txt

# put FILE LINE...: a file of the small house
put() {
    mkdir -p "$(dirname "$house/$1")"
    printf '%s\n' "${@:2}" >"$house/$1"
}

# A house in which all is well: low, then two rooms side by side, then the program.
build() {
    rm -rf "$house"
    put common/word.h '#pragma once'
    put inn/low/floor.h '#include "common/word.h"'
    put inn/low/floor.c '#include "inn/low/floor.h"' '#include <stdio.h>'
    put inn/left/wall.c '#include "inn/low/floor.h"'
    put inn/right/wall.c '#include "inn/low/floor.h"'
    put inn/right/key.h '#pragma once'
    put inn/main.c '#include "inn/low/floor.h"' '#include "inn/right/key.h"'
    printf '%s\n' '[inn]' 'lines 10 # short ones' 'uses common' 'level low/*' 'level left/* right/*' 'level *' \
        'private right/key.h right/* main.c' 'knot 1' >"$table"
}

look() { python3 tests/house/includes.py "$table" "$house"; }
is_well() { build && found=$(look) && [ -z "$found" ]; }

# finds PATTERN: exit 1 and one line, which fits
finds() {
    found=$(look)
    local status=$?
    echo "exit $status: $found"
    [ $status -eq 1 ] && [ "$(wc -l <<<"$found")" -eq 1 ] && grep -Eq -- "$1" <<<"$found"
}

goes_up() { build && put inn/left/wall.c '' && put inn/low/floor.c '' '#include "inn/left/wall.h"' && put inn/left/wall.h '' && finds '^inn/low/floor\.c:2: includes inn/left/wall\.h: low/\* is below left/\*$'; }
goes_aside() { build && put inn/left/wall.c '#include "inn/right/wall.h"' && put inn/right/wall.h '' && finds '^inn/left/wall\.c:1: .*left/\* is on the level of right/\*$'; }
goes_out() { build && put attic/old.h '' && put inn/main.c '#include "attic/old.h"' && finds '^inn/main\.c:1: includes attic/old\.h: inn/ may use common$'; }
uses_a_key() { build && put inn/left/wall.c '#  include "inn/right/../right/key.h"' && sed -i 's/^level left.*/level right\/*\nlevel left\/*/' "$table" && finds '^inn/left/wall\.c:1: includes inn/right/key\.h, which is private'; }
is_nowhere() { build && put inn/left/wall.c '#include "wall.h"' && finds '^inn/left/wall\.c:1: includes wall\.h, which is not there'; }
has_no_room() { build && put inn/cellar/deep/wine.c '' && finds '^inn/cellar/deep/wine\.c: in no room'; }
is_too_long() { build && put inn/left/wall.c $(seq 11) && finds '^inn/left/wall\.c: 11 lines; no file has more than 10'; }
just_fits() { build && put inn/left/wall.c $(seq 10) && found=$(look) && [ -z "$found" ]; }
goes_round() {
    build && put inn/low/a.h '#include "inn/low/b.h"' && put inn/low/b.h '#include "inn/low/c.h"' && put inn/low/c.c '#include "inn/low/a.h"' && put inn/low/c.h '' &&
        finds '^inn/: 3 modules include one another in a circle, at most 1 may: low/a low/b low/c$' &&
        sed -i 's/^knot.*/knot 3/' "$table" && found=$(look) && [ -z "$found" ]
}
# Three folders without levels, each of which uses the next.
rooms_go_round() {
    build && put inn/left/wall.c '#include "inn/right/key.h"' && put inn/right/wall.c '#include "inn/low/floor.h"' &&
        put inn/low/floor.c '#include "inn/left/wall.h"' && put inn/left/wall.h '' && printf '[inn]\n' >"$table" &&
        finds '^inn/: rooms in a circle: left low right \(inn/left/wall\.c:1, inn/low/floor\.c:1, inn/right/wall\.c:1\)$'
}
is_empty() { build && printf '[hall]\n' >>"$table" && finds '^hall/: no files'; }
table_is_wrong() { build && sed -i "s#.*$1.*#$2#" "$table" && fails_with 2 "layers.txt:$3: " python3 tests/house/includes.py "$table" "$house"; }

check "every arrow between the folders goes down, no file is too long" python3 tests/house/includes.py tests/house/layers.txt
check "a house in which all is well" is_well
check "an include of a higher room is found" goes_up
check "an include of another room of the level is found" goes_aside
check "an include of another top folder is found" goes_out
check "an include of a private header is found, however it is written" uses_a_key
check "an include that names no file from the top is found" is_nowhere
check "a file in no room is found" has_no_room
check "a file of one line too many is found" is_too_long
check "a file of just as many lines is not" just_fits
check "modules that include one another in a circle are found beyond the number that may" goes_round
check "rooms in a circle are found, without levels too" rooms_go_round
check "a folder that is not there is found" is_empty
check "a table with a word that is none is refused" table_is_wrong uses used 3
check "a table with a number that is none is refused" table_is_wrong lines 'lines many' 2
check "a table without a folder is refused" table_is_wrong '\[inn\]' 'uses common' 1
packages_first() { # whatever target one asks first: nothing is made before the packages that make it are there
    local target
    for target in all demo test; do
        make -n B="$tmp/bare-$target" ARM=/usr/bin/arm-none-eabi- $target >"$tmp/commands" 2>/dev/null
        awk '/dpkg-query/ { there = 1 } /^printf/ { exit } END { exit !there }' "$tmp/commands" || { echo "make $target"; return 1; }
    done
}
check "on a bare machine packages come before the first file that is made" packages_first
finish
