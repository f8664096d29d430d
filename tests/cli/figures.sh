#!/usr/bin/env bash
# The figures of the 1973 report come out of the scenes, and every number they are held to is met.
. "$(dirname "$0")/tap.sh"
check "every number the scenes are held to is met" build/tests/figures/figures "$tmp"
seven_figures() {
    [ "$(find "$tmp" -name 'fig3_*.svg' -size +5k | wc -l)" -eq 7 ] && grep -q '</svg>' "$tmp/figures.html" &&
        ! grep -qi 'nan' "$tmp"/*.svg
}
check "seven figures, without holes" seven_figures
check "no such folder" fails_with 3 none build/tests/figures/figures "$tmp/none"
finish
