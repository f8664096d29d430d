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
finish
