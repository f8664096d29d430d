#!/usr/bin/env bash
# matrig compare: a simulated landing is played to the emulated board and held against its own scene, a wrong one, limits, in a series.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
scene=$tmp/brisk.json
db=$tmp/c.db

python3 tests/compare/brisk.py host/scenes/model_runway.json >"$scene"
python3 tests/compare/scene_run.py $matrig $scene tests/runs/landing1.run "$tmp/own.run" &&
    played --elf build/firmware/matrig.elf --can none --serial "file:$tmp/whole.serial" --rig "$tmp/own.run" 2>"$tmp/board.err"
# The run ends where it ends, maybe inside a frame: up to the last frame's end.
python3 -c 'import sys; data = open(sys.argv[1], "rb").read(); open(sys.argv[2], "wb").write(data[: data.rindex(b"\0") + 1])' "$tmp/whole.serial" "$tmp/own.serial"
log() { $matrig --quiet log --serial "file:$tmp/own.serial" --db "$db" >/dev/null; }
log && $matrig --quiet landing "$db" --series "spring" --pattern standard >/dev/null && log
sed 's/"f": 0.5/"f": 0.35/' $scene >"$tmp/slippery.json"

cat >"$tmp/own.json" <<'END'
{"_": "at rest the measured zone ends where transducers do, the simulated does not",
 "channels.*.rms_in": 0.01, "channels.*.bias_in": 0.006, "channels.*.end_en": 1, "channels.*.chi": 1,
 "channels.1.arrival_difference_s": 0.02, "channels.5.peak_difference_mm": 0.3,
 "zones.*.overlap_simulated.share": 0.15}
END

json() { python3 -c 'import json, sys
def no(x): raise SystemExit("not JSON: " + x)
j = json.load(open(sys.argv[1]), parse_constant=no)
print(eval(sys.argv[2]))' "$1" "$2"; }

# Its motion and gaps found again from the switches and the survey.
its_own_scene_passes() { $matrig compare "$db" 1 $scene --limits "$tmp/own.json" | tee "$tmp/own.txt" | tail -1 | grep -Eq '^  verdict +pass$'; }
wrong_friction_fails_where_it_should() {
    local worst
    $matrig sim $scene --csv "$tmp/a.csv" >/dev/null && $matrig sim "$tmp/slippery.json" --csv "$tmp/b.csv" >/dev/null || return 1
    worst=$(python3 - "$tmp/a.csv" "$tmp/b.csv" <<'END'
import csv, sys
a, b = ([list(map(float, r[1:9])) for r in list(csv.reader(open(f)))[1:]] for f in sys.argv[1:])
n = min(len(a), len(b))
rms = [12 * (sum((a[i][c] - b[i][c]) ** 2 for i in range(n)) / n) ** 0.5 for c in range(8)]
worst = max(range(8), key=lambda c: rms[c])
print(worst + 1, "%.2f" % rms[worst])
END
    ) || return 1
    echo "expected: transducer, rms: $worst"
    fails_with 1 "channels.${worst% *}.rms_in of RUN 1 is .*; the limit 0.0030 is exceeded by" $matrig compare "$db" 1 "$tmp/slippery.json" --limit 0.003 &&
        $matrig --json compare "$db" 1 "$tmp/slippery.json" >"$tmp/slips.json" && [ "$(json "$tmp/slips.json" "abs(j['channels'][${worst% *} - 1]['rms_in'] / ${worst#* } - 1) < 0.03")" = True ]
}
fits_a_terminal() {
    $matrig compare "$db" 1 >"$tmp/t.txt" && [ "$(wc -l <"$tmp/t.txt")" -le 13 ] && $matrig compare --all "$db" 1 >>"$tmp/t.txt" && $matrig --si compare --all "$db" 1 >>"$tmp/t.txt" && $matrig compare "$db" $scene >>"$tmp/t.txt" || return 1
    awk 'length > 100 { print; bad = 1 } END { exit bad }' "$tmp/t.txt"
}
json_is_json() {
    $matrig --json compare "$db" 1 --limit 1 >"$tmp/one.json" && $matrig --json --si compare "$db" 1 >"$tmp/si.json" && $matrig --json compare "$db" $scene >"$tmp/set.json" || return 1
    [ "$(json "$tmp/si.json" 'j["limits"] is None and all(c["chi"] > 0 for c in j["channels"])')" = True ] &&
        [ "$(json "$tmp/one.json" 'j["limits"]["pass"] and j["error_in"] > 0 and j["run_ms"] > 0')" = True ] &&
        [ "$(json "$tmp/set.json" 'len(j["landings"]), len(j["channels"]), j["compared"]')" = "(2, 8, 2)" ] &&
        [ "$(json "$tmp/si.json" "abs(j['channels'][2]['peak_measured_mm'] / 25.4 - $(json "$tmp/one.json" 'j["channels"][2]["peak_measured_in"]')) < 1e-5")" = True ]
}
# The figures once more from the series, by other code.
figures_from_the_csv() {
    $matrig --json compare "$db" 1 -o "$tmp/one.csv" >"$tmp/csv.json" && python3 - "$tmp/one.csv" "$tmp/csv.json" <<'END'
import csv, json, sys
rows = list(csv.DictReader(open(sys.argv[1])))
for c in json.load(open(sys.argv[2]))["channels"][:7]:
    at = lambda r, n: r["d%d_%s_in" % (c["number"], n)]
    pairs = [(float(at(r, "measured")), float(at(r, "simulated")), float(at(r, "measured_error")), float(at(r, "simulated_error"))) for r in rows if at(r, "measured")]
    n = len(pairs)
    d = [m - s for m, s, _, _ in pairs]
    bias, rms = sum(d) / n, (sum(x * x for x in d) / n) ** 0.5
    chi = (sum((m - s) ** 2 / (u * u + v * v) for m, s, u, v in pairs) / n) ** 0.5
    print(c["number"], bias, rms, chi)
    assert abs(bias - c["bias_in"]) < 1e-6 and abs(rms - c["rms_in"]) < 1e-6 and abs(chi / c["chi"] - 1) < 1e-4
END
}

series_and_its_limits() {
    # Twice the same landing, by a board that says the same survey: what the first did to the gaps is carried on, and shows.
    printf '{"channels.*.rms_in": 1.5, "series.within": 1, "series.rms_in": 1}' >"$tmp/series.json"
    $matrig compare "$db" $scene --limits "$tmp/series.json" | tee "$tmp/series.txt" | grep -Eq '^within limits +100 %' && cat "$tmp/series.txt" || return 1
    printf '{"series.bias_in": 0.00001}' >"$tmp/strict.json"
    fails_with 1 'bias_in of the series is .*; the limit 0.0000 is exceeded by' $matrig compare "$db" $scene --limits "$tmp/strict.json" &&
        [ "$($matrig --json compare "$db" --series spring >"$tmp/s.json"; json "$tmp/s.json" '[l["run"] for l in j["landings"]]')" = "[2]" ] &&
        fails_with 2 "no landings in series 'summer'" $matrig compare "$db" --series summer
}
ensemble_has_a_spread() { # of runways in which gaps and resistances vary: the error is more than the solver's
    $matrig --json compare "$db" 1 host/landing_series/series/standard.json --seeds 3 >"$tmp/e.json" &&
        [ "$(json "$tmp/e.json" 'j["seeds"] == 3 and max(c["peak_simulated_error_in"] for c in j["channels"]) > 1.5 * j["error_in"]')" = True ]
}
without_switches() {
    cp "$db" "$tmp/blind.db" && sqlite3 "$tmp/blind.db" 'delete from edges where landing = 2' || return 1
    fails_with 5 'motion of the gear is unknown .*RUN 2; compare a landing with at least 3' $matrig compare "$tmp/blind.db" 2 || return 1
    $matrig compare "$tmp/blind.db" $scene >"$tmp/blind.txt" && grep -q '^RUN 2 not compared: the motion of the gear is unknown' "$tmp/blind.txt" && grep -Eq '^compared +1$' "$tmp/blind.txt" &&
        fails_with 1 'RUN 2 not compared: the motion of the gear is unknown' $matrig compare "$tmp/blind.db" $scene --limit 1
}
wrong_input_is_told() {
    echo '{"channels.*.rsm_in": 1}' >"$tmp/typo.json"
    fails_with 1 'the result has no value channels.*.rsm_in: RUN 1' $matrig compare "$db" 1 --limits "$tmp/typo.json" &&
        fails_with 3 'cannot read limits: .*none.json' $matrig compare "$db" 1 --limits "$tmp/none.json" &&
        fails_with 2 'different scale: host/scenes/full_width_36000.json' $matrig compare "$db" 1 host/scenes/full_width_36000.json &&
        fails_with 2 'different scale: host/scenes/full_width_36000.json' $matrig compare "$db" 1 --scene host/scenes/full_width_36000.json &&
        fails_with 2 "two scenes given: $scene and --scene $scene; give only one" $matrig compare "$db" 1 $scene --scene $scene &&
        fails_with 2 'one runway; --seeds needs a study file' $matrig compare "$db" 1 --seeds 4 &&
        fails_with 2 'RUN and --series exclude each other' $matrig compare "$db" 1 --series spring &&
        fails_with 2 '-o works only for a single landing; give the RUN of a landing' $matrig compare "$db" $scene -o "$tmp/x.csv" &&
        fails_with 2 'needs DB RUN, DB FILE or DB --series' $matrig compare "$db"
}
ends_with_a_sentence() { # the text has it, the report too (tests/host/test_compare has which value it names)
    local sentence='RUN 1 differs from slippery.json: [0-9]* of [0-9]* peaks, ends and arrivals differ by more than twice their errors; largest: the '
    $matrig compare "$db" 1 "$tmp/slippery.json" | tr -s ' \n' ' ' | grep -o "$sentence.* En [0-9.]*" >"$tmp/said" && cat "$tmp/said" &&
        $matrig --quiet report "$db" -o "$tmp/differs.html" && grep -qF "$(cat "$tmp/said")" "$tmp/differs.html"
}
report_has_the_table() {
    cp $scene "$tmp/<b>x.json" && $matrig compare "$db" 1 "$tmp/<b>x.json" >/dev/null && $matrig --quiet report "$db" -o "$tmp/r.html" || return 1
    grep -q '<h3>Measured against simulated</h3>' "$tmp/r.html" && grep -q 'Simulation: &lt;b&gt;x.json, standard error' "$tmp/r.html" && ! grep -q '<b>x' "$tmp/r.html" &&
        ! sed '/^<script>/,$d' "$tmp/r.html" | grep -Eq '>-?nan|NaN' && grep -q 'measured with 95 % band' "$tmp/r.html"
}

check "a simulated landing, played and measured, is its own scene's: motion and gaps found again" its_own_scene_passes
check "another friction fails, at the transducer where it shows most" wrong_friction_fails_where_it_should
check "tables fit 100 columns" fits_a_terminal
check "JSON is JSON; what is not known is null" json_is_json
check "bias, rms and chi, once more from the CSV" figures_from_the_csv
check "a sentence has the largest difference" ends_with_a_sentence
check "a series, its limits, and a part of it by name" series_and_its_limits
check "an ensemble's spread is part of the simulation's error" ensemble_has_a_spread
check "a landing without switches is told, in a series too" without_switches
check "wrong input gets one line" wrong_input_is_told
check "the report has the table, names in it are inert" report_has_the_table
# Blocks lost while the gear comes to rest: what was measured then is not known, and no zone is made of the survey alone.
nothing_at_rest() {
    played --elf build/firmware/matrig.elf --can none --serial "file:$tmp/five.serial" --rig tests/runs/landing5.run 2>"$tmp/board.err" || return 1
    (head -c 500000 "$tmp/five.serial" && tail -c 200000 "$tmp/five.serial") >"$tmp/lost.serial"
    $matrig --quiet log --serial "file:$tmp/lost.serial" --db "$tmp/lost.db" >/dev/null 2>&1
    [ "$(json "$tmp/one.json" 'min(c["valid"] for c in j["channels"])')" = 1.0 ] || return 1
    $matrig compare "$tmp/lost.db" 1 | grep -x "zone at rest   not known" && $matrig compare --all "$tmp/lost.db" 1 | grep -A 9 'at rest' && $matrig --json compare "$tmp/lost.db" 1 >"$tmp/lost.json" || return 1
    [ "$(json "$tmp/lost.json" 'max(c["valid"] for c in j["channels"]) < 0.999')" = True ] || return 1
    [ "$(json "$tmp/lost.json" '[(z["measured"], z["overlap_simulated"]) for z in j["zones"] if z["when"] == "at rest"]')" = "[(None, None)]" ]
}
check "no zone is measured where blocks were lost" nothing_at_rest
finish
