#!/usr/bin/env bash
# The figures of the 1973 report come out of the scenes, row by row, as host/sim/FIGURES.md states.
. "$(dirname "$0")/tap.sh"
figures=(python3 tests/cli/figures.py build/matrig)
check "R* has the values of the page, and reproduces what it states" "${figures[@]}" host/scenes host/sim/FIGURES.md
cp -r host/scenes "$tmp"
sed -i 's/"KL": 16000000.0/"KL": 16000000.0, "v0": 3/' "$tmp/scenes/rstar_fig3_6.json"
check "a scene that is not R* is found" fails_with 1 'row 13' "${figures[@]}" "$tmp/scenes" host/sim/FIGURES.md
sed 's/| 40 \(.*\) | both |$/| 40 \1 | best |/' host/sim/FIGURES.md >"$tmp/page.md"
check "so is a page that states otherwise what is reproduced" fails_with 1 'row 40' "${figures[@]}" host/scenes "$tmp/page.md"
finish
