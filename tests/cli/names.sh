#!/usr/bin/env bash
# Libraries are archives: of two functions of one name in different folders the linker takes either, without a word.
. "$(dirname "$0")/tap.sh"
each_name_once() { # LIBRARY...
    nm -g --defined-only "$@" | awk 'NF == 3 && $2 ~ /[TDBRC]/ {print $3}' | sort | uniq -d >"$tmp/twice"
    cat "$tmp/twice"
    [ "$(nm -g --defined-only "$@" | wc -l)" -gt 100 ] && [ ! -s "$tmp/twice" ]
}
check "names of host and common" each_name_once build/host/libhost.a build/host/libcommon.a
check "names of the emulated board and common" each_name_once build/host/libhil.a build/host/libcommon.a
printf 'int twice(void) {return 1;}\n' | gcc -x c -c - -o "$tmp/a.o" && cp "$tmp/a.o" "$tmp/b.o" && ar rcs "$tmp/libtwo.a" "$tmp/a.o" "$tmp/b.o"
found() { each_name_once build/host/libhost.a "$tmp/libtwo.a"; [ "$(cat "$tmp/twice")" = twice ]; }
check "one that is there twice is found" found
# A newcomer looks for the field's words in the headers, each by itself: the one that defines the thing is among those that have it.
told_in() { # HEADER WORDS
    git grep -liwE "$2" -- '*.h' >"$tmp/headers" 2>/dev/null || grep -rliwE --include='*.h' "$2" common firmware host hil >"$tmp/headers"
    cat "$tmp/headers"
    grep -qx "$1" "$tmp/headers"
}
while read -r header words; do
    check "$words: $header" told_in "$header" "$words"
done <<'T'
common/staircase.h staircase
host/survey/survey.h gage survey
common/passage.h push-back
host/sim/elements/mods.h cleats?
host/sim/elements/mods.h stiffeners?
host/sim/elements/mods.h diagonal lay
common/bands.h pretension
host/landing_series/ensemble.h two-panel wave
host/landing_series/series.h unhinging
common/closure.h compression zone
host/sim/scene/result.h bow_wave
host/sim/models/model.h lift shear
host/sim/elements/law.h TAD
common/gates.h touchdown
common/bands.h rivet
host/sim/elements/law.h grit
host/sim/elements/law.h slack
host/sim/elements/wheel.h wheel load
T
finish
