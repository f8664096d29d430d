#!/usr/bin/env bash
# The scoreboard's rows and the pilot cases: what must hold on every runway.
. "$(dirname "$0")/tap.sh"
# What the report states of the series besides its buckle: rows of the scoreboard.
told() {
    local standard=host/landing_series/series/standard.json
    SEEDS=1 build/tests/scoreboard/scoreboard $standard >"$tmp/c.md" 2>/dev/null || return 1
    cat "$tmp/c.md"
    [ "$(grep -c '^| - |' "$tmp/c.md")" -eq 7 ] &&
        grep -q '^| standard pattern | .*few runways: .* bits | landing .*few runways: .* bits |$' "$tmp/c.md"
}
check "facts of a series are rows of the scoreboard" told
ground() {
    local fresh=host/landing_series/series/control_fresh.json
    build/matrig --quiet study $fresh --seeds 1 | grep -q '^ground *weightless gear' &&
        build/matrig --quiet study $fresh --seeds 1 --ground elastic | grep -q '^ground *elastic ground under a gear with weight: 7000 lb/ft .* 6 axles in 4 lines'
}
check "and which ground it has" ground
# More friction below than above holds the mat under a locked wheel: Coulomb, on any runway.
pilot() { build/tests/pilot/pilot 1 >"$tmp/pilot.md" && cat "$tmp/pilot.md" && [ "$(grep -c '^| [1-6]' "$tmp/pilot.md")" -eq 7 ]; }
check "the pilot study's six results" pilot
check "no wave when f below exceeds f above" grep -q '^| 5 .* 0 of 1 runways buckle, .* agrees' "$tmp/pilot.md"
finish
