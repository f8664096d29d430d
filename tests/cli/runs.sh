#!/usr/bin/env bash
# The committed landings are what their generator makes; each rests on those before, so landing 1 alone in make test, all in make long.
. "$(dirname "$0")/tap.sh"
made_again_the_same() {
    local run compared=0
    build/tests/runs/synthesise "$tmp" 67 40 "$(take 1 7)" || return 1
    for run in "$tmp"/landing*.run; do
        [ ! -e "tests/runs/${run##*/}" ] || { cmp "tests/runs/${run##*/}" "$run" && compared=$((compared + 1)); } || return 1
    done
    echo "$compared compared"
    [ $compared = "$(take 1 "$(ls tests/runs/*.run | wc -l)")" ]
}
check "synthesise makes the committed runs byte for byte" made_again_the_same
finish
