#!/usr/bin/env bash
# The committed landings are what their generator makes.
. "$(dirname "$0")/tap.sh"
made_again_the_same() {
    build/tests/runs/synthesise "$tmp" || return 1
    for run in tests/runs/*.run; do
        cmp "$run" "$tmp/$(basename "$run")" || return 1
    done
}
check "synthesise makes the committed runs byte for byte" made_again_the_same
finish
