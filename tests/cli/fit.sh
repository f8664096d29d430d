#!/usr/bin/env bash
# matrig fit: landing 1 of tests/runs, played to the emulated board and logged. Their truth comes from a chain that shares no
# code with the fit (tests/runs/README.md): closing resistances uniform over 0 to 20 lb, friction 0.5, a twelfth of the thrust.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/campaign.db

fitted() { # FIELD of grit
    sqlite3 :memory: "select json_extract(value, '\$.$1') from json_each(json_extract(cast(readfile('$tmp/fit.json') as text), '\$.parameters'))
        where json_extract(value, '\$.name') = 'grit'"
}
between() { awk -v low="$1" -v x="$2" -v high="$3" 'BEGIN { print low, x, high; exit !(low <= x && x <= high) }'; }

fits() { # by a clock that passes 30 times as fast
    touch "$tmp/fast"
    LD_PRELOAD=build/tests/link/faults.so CLOCK_RATE=$tmp/fast:30 $matrig --json fit "$db" 1 --fit grit --draws 60 \
        --plot "$tmp/fit.svg" -o "$tmp/fit_scene.json" >"$tmp/fit.json" 2>"$tmp/goes.txt"
}
goes_on() {
    cat "$tmp/goes.txt"
    grep -Eq '^matrig: fit: running for [1-9][0-9]* s: round [0-9]+: [0-9]+ of [0-9]+ data sets done; fewer --draws would be quicker$' "$tmp/goes.txt"
}
holds_truth() { between "$(fitted low)" 10.0 "$(fitted high)"; }
narrows_prior() { between 0 "$(fitted error_of_prior)" 0.7; }
residuals_drawn() { xmllint --noout "$tmp/fit.svg" 2>/dev/null || python3 -c "import xml.dom.minidom as m, sys; m.parse('$tmp/fit.svg')"; }
scene_has_it() { # means of 421 draws: within a tenth
    $matrig sim "$tmp/fit_scene.json" >"$tmp/sim.txt" &&
        between "$(awk -v v="$(fitted value)" 'BEGIN { print 0.9 * v }')" \
            "$(sqlite3 :memory: "select avg(value) from json_each(json_extract(cast(readfile('$tmp/fit_scene.json') as text), '\$.grit'))")" \
            "$(awk -v v="$(fitted value)" 'BEGIN { print 1.1 * v }')"
}
misfit() { # FIELD
    sqlite3 :memory: "select json_extract(cast(readfile('$tmp/fit.json') as text), '\$.misfit.$1')"
}
can_be() { [ "$(misfit checked)" = 1 ] && [ "$(misfit cannot_be)" = 0 ] && [ "$(misfit replicas)" -ge 90 ]; }
# Gaps as if laid in stretches of five segments: no such runway is drawn, and the movement is another's.
laid_in_stretches() {
    cp "$db" "$tmp/laid.db" && sqlite3 "$tmp/laid.db" 'update slack set slack_in = case when (segment / 5) % 2 then 0.06 else 0.28 end' &&
        ! $matrig --json fit "$tmp/laid.db" 1 --fit grit --draws 60 --plot "$tmp/laid.svg" >"$tmp/fit.json" && [ "$(misfit cannot_be)" = 1 ] &&
        grep -q '"intervals_trusted":false' "$tmp/fit.json" && grep -q 'cannot describe the data' "$tmp/laid.svg"
}
no_transducer() {
    cp "$db" "$tmp/none.db" && sqlite3 "$tmp/none.db" 'update channels set kind = 0 where kind = 1'
}
no_switches() { cp "$db" "$tmp/blind.db" && sqlite3 "$tmp/blind.db" 'delete from edges; delete from frames'; }

check "landing 1 is played and logged" campaign_of "$db" 1
check "it is fitted" fits
check "and says how far it is all the while" goes_on
check "the interval of the closing resistance holds the truth" holds_truth
check "and is narrower than the prior's" narrows_prior
check "the model can be the data's" can_be
check "the residuals are a picture" residuals_drawn
check "the scene runs, with the fitted resistance" scene_has_it
check "a runway laid in stretches cannot be: exit code 1, JSON and picture say so" laid_in_stretches
check "a landing without transducers" eval "no_transducer && fails_with 5 'no landing to fit: .*no transducer' $matrig fit '$tmp/none.db'"
check "a landing of which no switch edge was received" eval "no_switches && fails_with 2 'RUN 1 is incomplete: none of .* switch edges' $matrig fit '$tmp/blind.db' 1"
check "another version's database" eval "cp '$db' '$tmp/old.db' && sqlite3 '$tmp/old.db' 'pragma user_version = 99' && fails_with 4 'version' $matrig fit '$tmp/old.db'"
check "no database" fails_with 3 'none' $matrig fit "$tmp/none/none.db"
finish
