#!/usr/bin/env bash
# The figures of the 1973 report come out of the scenes, and every number they are held to is met.
. "$(dirname "$0")/tap.sh"
check "every number the scenes are held to is met" sh -c "build/tests/figures/figures '$tmp' >'$tmp/table.md'"
seven_figures() {
    [ "$(find "$tmp" -name 'fig3_*.svg' -size +3k | wc -l)" -eq 7 ] && [ "$(find "$tmp" -name 'best3_*.svg' -size +3k | wc -l)" -eq 7 ] && ! grep -qi 'nan' "$tmp"/*.svg
}
check "seven figures by both readings, without holes" seven_figures
# The page states what the scenes and the kept reading give now, not what they once gave.
check "the page has this table" diff <(sed -n '/^<!-- numbers: /,/^<!-- end of numbers -->/{/^<!--/!p}' host/sim/FIGURES.md) "$tmp/table.md"
here=$PWD
mkdir -p "$tmp/other/host" "$tmp/other/tests/figures"
cp -r host/scenes "$tmp/other/host" && cp tests/figures/readings.json "$tmp/other/tests/figures"
sed -i 's/"KL": 16000000.0/"KL": 16000000.0, "v0": 3/' "$tmp/other/host/scenes/rstar_fig3_6.json"
check "a scene that is not R* is found" fails_with 1 rstar_fig3_6 sh -c "cd '$tmp/other' && '$here/build/tests/figures/figures' --table"
cp host/scenes/rstar_fig3_6.json "$tmp/other/host/scenes"
sed -i '/mats/d' "$tmp/other/tests/figures/readings.json"
check "so is a kept reading without an input" fails_with 4 readings sh -c "cd '$tmp/other' && '$here/build/tests/figures/figures' --table"
# Numbers that the text states: 3.6, 3.7, 3.8 (two), 3.11, 3.12; over 1 ft is a line.
stated() { [ "$(cat "$tmp"/fig3_*.svg | grep -c '<text>text[:,]')" -eq 7 ]; }
check "what the text states is marked" stated
check "no such folder" fails_with 3 none build/tests/figures/figures "$tmp/none"
finish
