#!/usr/bin/env bash
# A row of another table, an integer too few, a value that is no integer, real or text, a field that does not suit its column: none compiles.
. "$(dirname "$0")/tap.sh"
cc=${CC:-gcc}

# compiles CODE [FLAG...]: CODE is the body of a function that has store, error, run, edge and zone
compiles() {
    local code=$1
    shift
    cat >"$tmp/code.c" <<END
#include "host/store/table.h"
enum mr_status probe(struct store *store, int64_t run, const struct store_edge *edge, struct store_zone *zone, float f, struct error *error);
enum mr_status probe(struct store *store, int64_t run, const struct store_edge *edge, struct store_zone *zone, float f, struct error *error)
{
    (void)store, (void)run, (void)edge, (void)zone, (void)f, (void)error;
    $code
}
END
    "$cc" -std=c11 -Wall -Wextra -Werror -fsyntax-only "$@" -I. "$tmp/code.c"
}
# refused PATTERN CODE: does not compile, and for this reason
refused() {
    local pattern=$1
    ! compiles "$2" 2>"$tmp/why" || return 1
    cat "$tmp/why"
    grep -Eq "$pattern" "$tmp/why"
}
good() {
    compiles 'return STORE_PUT(store, error, edge, edge, run);' &&
        compiles 'return STORE_READ_ONE(store, error, RESULT_GET, (struct store_result *)0, STORE_BIND(run));' &&
        compiles 'return STORE_RUN_STATEMENT(store, error, EDGE_REJECT, STORE_BIND(run), STORE_BIND(3));'
}
# describes SED: tables.def as SED changes it, described by table.c
describes() {
    mkdir -p "$tmp/changed/host/store"
    sed "$1" host/store/tables.def >"$tmp/changed/host/store/tables.def"
    "$cc" -std=c11 -Wall -Wextra -Werror -fsyntax-only -I"$tmp/changed" -I. host/store/table.c
}
field_of_another_kind() {
    describes 's/no such line//' || return 1
    ! describes 's/^    REAL(edge, step_codes, /    COLUMN(edge, step_codes, double step_codes, step_codes, INTEGER, /; s/^\(    COLUMN(edge, step_codes.*KEEP\))/\1, TEXT, "")/' \
        2>"$tmp/why" || return 1
    cat "$tmp/why"
    grep -q 'the field of column step_codes of struct store_edge is no INTEGER' "$tmp/why"
}

check "what is right compiles" good
check "a row of another table is not put" refused 'pointer' 'return STORE_PUT(store, error, edge, zone, run);'
check "a row that is not said whose is not put" refused 'negative|size of array' 'return STORE_PUT(store, error, edge, edge);'
check "rows are not read into another struct" refused 'pointer' 'return STORE_READ_ONE(store, error, RESULT_GET, zone, STORE_BIND(run));'
check "a statement takes no pointer to a row" refused '_Generic' 'return STORE_RUN_STATEMENT(store, error, EDGE_REJECT, STORE_BIND(run), STORE_BIND(edge));'
check "a statement takes no float, which would be rounded unseen" refused '_Generic' 'return STORE_RUN_STATEMENT(store, error, EDGE_REJECT, STORE_BIND(run), STORE_BIND(f));'
check "a field that cannot hold its column does not compile" field_of_another_kind
finish
