#!/usr/bin/env bash
# The figures of the 1973 report come out of the scenes, and every number they are held to is met.
. "$(dirname "$0")/tap.sh"
check "every number the scenes are held to is met" build/tests/figures/figures "$tmp"
seven_figures() {
    [ "$(find "$tmp" -name 'fig3_*.svg' -size +3k | wc -l)" -eq 7 ] && grep -q '</svg>' "$tmp/figures.html" &&
        ! grep -qi 'nan' "$tmp"/*.svg
}
check "seven figures, without holes" seven_figures
# A picture opened on its own is shown only when it says what it is.
check "pictures that open on their own" test "$(grep -l 'xmlns="http://www.w3.org/2000/svg"' "$tmp"/fig3_*.svg | wc -l)" -eq 7
# Numbers that the text states: 3.6, 3.7, 3.8 (two), 3.11, 3.12; over 1 ft is a line.
stated() {
    cat "$tmp"/fig3_*.svg >"$tmp/all"
    [ "$(grep -o 'class="stated"' "$tmp/all" | wc -l)" -eq 6 ] && [ "$(grep -o 'class="bound"' "$tmp/all" | wc -l)" -eq 1 ]
}
check "what the text states is marked" stated
check "every text is inside its picture" python3 tests/report/texts_inside.py "$tmp"/fig3_*.svg "$tmp/figures.html"
check "no such folder" fails_with 3 none build/tests/figures/figures "$tmp/none"
finish
