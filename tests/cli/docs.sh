#!/usr/bin/env bash
# README.md and docs/: links lead somewhere, places of the glossary exist, README is short, the reference is what the tables make; and the
# checker finds each thing that is not so, in a small tree of its own.
. "$(dirname "$0")/tap.sh"
tree=$tmp/tree

# put FILE LINE...: a file of the small tree
put() {
    mkdir -p "$(dirname "$tree/$1")"
    printf '%s\n' "${@:2}" >"$tree/$1"
}
build() { # pages without a fault
    rm -rf "$tree"
    put common/mat.h 'struct mat;'
    put README.md '# Small' '[words](docs/glossary.md#the-mat)' '```sh' 'true' '```'
    put docs/glossary.md '# Glossary' '## The mat' '| term | meaning | where |' '|---|---|---|' '| mat | a panel | `common/mat.h`: `mat` |'
}
finds() { # PATTERN: exit 1 and one line, which fits
    local found status
    found=$(python3 tests/house/documentation.py "$tree")
    status=$?
    echo "exit $status: $found"
    [ $status -eq 1 ] && [ "$(wc -l <<<"$found")" -eq 1 ] && grep -Eq -- "$1" <<<"$found"
}
is_well() { build && [ -z "$(python3 tests/house/documentation.py "$tree")" ]; }
no_file() { build && put README.md '[a](docs/glossary.md)' '[b](docs/none.md)' && finds '^README\.md:2: .*there is no docs/none\.md$'; }
no_picture() { build && put README.md '[a](docs/glossary.md)' '![b](docs/none.png)' && finds '^README\.md:2: .*docs/none\.png$'; }
no_heading() { build && put README.md '[a](docs/glossary.md#the-mats)' && finds '^README\.md:1: .*no such heading$'; }
no_way() { build && put docs/lost.md '# Lost' && finds '^docs/lost\.md:1: no links lead here'; }
no_path() { build && put README.md '[a](docs/glossary.md)' 'see `common/none.h`' && finds '^README\.md:2: there is no common/none\.h$'; }
no_symbol() { build && sed -i 's/: `mat`/: `rug`/' "$tree/docs/glossary.md" && finds "^docs/glossary\.md:5: mat: common/mat\.h does not have 'rug'$"; }
no_place() { build && sed -i 's/ `common.*$/ somewhere |/' "$tree/docs/glossary.md" && finds '^docs/glossary\.md:5: mat: no place is named$'; }
no_mark() { build && put README.md '[a](docs/glossary.md)' '```sh later' 'true' '```' && finds "^README\.md:2: a block is marked 'sh later'"; }
too_long() { build && head -c 8200 /dev/zero | tr '\0' 'x' >>"$tree/README.md" && finds '^README\.md:1: [0-9]+ bytes; at most 8192$'; }

# The committed pages are what the tables make.
reference_is_current() {
    mkdir -p "$tmp/reference" && build/docs/reference/reference "$tmp/reference" || return 1
    local page
    for page in "$tmp"/reference/*.md; do
        diff -u "docs/reference/$(basename "$page")" "$page" || { echo "run: make reference"; return 1; }
    done
    diff <(cd docs/reference && ls ./*.md) <(cd "$tmp/reference" && ls ./*.md)
}

# HOUSE's words, each found at the first try: by a file's name, or as a word or a name in the sources.
terms="staircase|gage.survey|push.back|cleat|stiffener|diagonal|pretension|two.panel|unhing|zone|bow.wave|similitude|band.?design|lift.shear|TAD|touchdown|rivet|grit|slack|wheel.load"
terms_are_found() {
    local term IFS='|'
    for term in $terms; do
        find common firmware host hil -type f | grep -Eiq -- "$term" || grep -Eirq --include='*.[ch]' --include='*.def' -- "$term" common firmware host ||
            { echo "nobody finds $term"; return 1; }
        grep -Eiq -- "${term/unhing/unhinging}" docs/glossary.md || { echo "the glossary lacks $term"; return 1; }
    done
}

check "links, places, sizes and marks of README.md and docs/" python3 tests/house/documentation.py
check "the reference is what the tables make" reference_is_current
check "the twenty terms are found, and stand in the glossary" terms_are_found
check "small pages without a fault" is_well
check "a link to a file that is not there is found" no_file
check "a picture that is not there" no_picture
check "a link to a heading that is not there" no_heading
check "a page that no link leads to" no_way
check "a path of the sources that is not there" no_path
check "a place of the glossary without its symbol" no_symbol
check "a term without a place" no_place
check "a block with a mark that nobody knows" no_mark
check "a README that is too long" too_long
finish
