#!/usr/bin/env bash
# What `make lint` compiles with is red on what each compiler should warn of. Run by make lint.
. "$(dirname "$0")/../cli/tap.sh"

# put LINE...: a C file that is laid out well
put() { printf '%s\n' "$@" >"$tmp/wall.c"; }
compiled() { # MAKE-VARIABLE...
    rm -rf "$tmp/objects"
    MAKEFLAGS='' MAKELEVEL='' make -s B="$tmp/objects" for_this_computer="$tmp/wall.c" WERROR=-Werror "$@" objects
}
# warns OPTION MAKE-VARIABLE...
warns() { ! compiled "${@:2}" 2>"$tmp/err" && cat "$tmp/err" && grep -q -- "-Werror,\?=\?$1" "$tmp/err"; }

put '#include <math.h>' 'double wall_ft(void);' 'double wall_ft(void)' '{' '    return NAN;' '}'
check "gcc says nothing of a float that a double is returned from" compiled CFLAGS=-O1
check "clang does" warns ,-Wdouble-promotion CC=clang
put 'int wall(int a);' 'int wall(int a)' '{' '    int ft;' '    if (a)' '        ft = 1;' '    return ft;' '}'
check "clang says that a value may not be set" warns ,-Wsometimes-uninitialized CC=clang CFLAGS=-O0
put 'int *wall(void);' 'static int *door(int *at)' '{' '    return at;' '}' 'int *wall(void)' '{' '    int ft = 0;' '    return door(&ft);' '}'
check "gcc at -O0 says nothing of an address that outlives its place" compiled CFLAGS=-O0
check "gcc at -O1 does" warns dangling-pointer CFLAGS=-O1
check "gcc at -O3 does" warns return-local-addr CFLAGS=-O3
put 'int wall(int a);' 'int wall(int a)' '{' '    return a + 1;' '}'
check "a file in which all is well is compiled" compiled CFLAGS=-O3
check "and by clang" compiled CC=clang
finish
