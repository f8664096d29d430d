#!/usr/bin/env bash
# matrig params: readings to parameters, hand-worked.
. "$(dirname "$0")/tap.sh"
m=build/matrig
cat >"$tmp/readings.json" <<'J'
{
  "_note": "joint and hinge as section 3.4 of the report; a 140 lb plank of 2 ft on 4 ft cords",
  "inertia": {"weight_lb": {"value": 140, "error": 0.5}, "spacing_ft": 2, "cord_ft": 4,
              "period_s": {"readings": [1.278, 1.280, 1.279, 1.281, 1.280]}},
  "tension": {"slope_lb_in_in": {"value": 9500, "error": 300}, "joint_in": 144},
  "hinge": {"angle_deg": [11, 12, 13, 14], "moment_ft_lb": [1745.33, 3490.66, 5235.99, 6981.32]},
  "pull": {"weight_lb": 160, "pull_lb": {"readings": [78, 82, 80]}},
  "deflection": {"load_lb": 120, "deflection_in": {"value": 0.05, "error": 0.005}}
}
J
# near KEY FIELD VALUE TOLERANCE
near() {
    $m --json params "$tmp/readings.json" >"$tmp/o.json" || return 1
    got=$(grep -o "\"$1\":{[^}]*}" "$tmp/o.json" | head -n 1 | grep -o "\"$2\":[0-9.e+-]*" | cut -d: -f2)
    echo "$1 $2 $got"
    awk -v g="$got" -v v="$3" -v t="$4" 'BEGIN { exit !(g != "" && g - v <= t && v - g <= t) }'
}
# Each kind of reading once, with its error: the rest is tests/host/test_params'. I = W d2 T2/(16 pi2 l) = 140*4*1.2796^2/(631.655).
check "inertia" near I value 1.45165 2e-5
check "inertia's error: weight 0.357 %, period 2 * 0.00051/1.2796" near I error 0.005313 2e-5
check "KL of the report" near KL value 16416000 1
check "KT of the report" near KT value 1e5 1
check "TAD of the report" near TAD_deg value 10 1e-4
check "friction's error" near f error 0.0072169 1e-6
check "soil's error" near KV error 1440 1e-6
echo '{"hinge": {"angle_deg": [2, 5, 8, 11, 12, 13], "moment_ft_lb": [20, -20, 10, 1745, 3491, 5236]}}' >"$tmp/readings.json"
check "readings within the free travel are refused" fails_with 4 'readings within the free travel: .*hinge: 1 of 6' $m params "$tmp/readings.json"
echo '{"hinge": {"angle_deg": [1, 2, 3, 4, 5, 6], "moment_ft_lb": [20.3, 19.8, 20.1, 19.7, 20.4, 19.9]}}' >"$tmp/readings.json"
check "all within: refused with what can be said" fails_with 5 'no stiffness: .*hinge: 6 readings' $m params "$tmp/readings.json"
echo '{"hinge": {"angle_deg": [-12, 11, 12, 13], "moment_ft_lb": [-3491, 1745, 3491, 5236]}}' >"$tmp/readings.json"
check "both ways at once" fails_with 4 'negative angle' $m params "$tmp/readings.json"
# slack of 0.02 in, then 9,500 lb/in per in of a strip of 2 in
echo '{"tension": {"joint_in": 144, "strip_in": 2, "stretch_in": [0.03, 0.04, 0.05, 0.06], "force_lb": [191, 379, 571, 759]}}' >"$tmp/readings.json"
check "a joint's slack is no part of KL" near KL value 16416000 150000
echo '{"pull": {"weight_lb": 160, "pull_lb": 80}}' >"$tmp/readings.json"
check "an error that nobody stated is unknown, not 0" eval '$m params "$tmp/readings.json" | grep -q "^f .*0.5 error unknown" && $m --json params "$tmp/readings.json" | grep -q "\"error\":null"'
# A plate of 11.28379 in has 100 in2: on soil of 200 lb/in3 it takes 20,000 lb/in; half of a mat of 12 x 2 ft has 1728 in2
echo '{"plate": {"load_lb": [200, 400, 600], "settlement_in": [0.012, 0.022, 0.032], "plate_in": 11.2837917, "mat_length_ft": 12, "mat_width_ft": 2}}' >"$tmp/readings.json"
check "KV of a plate bearing test, whose seating does not matter" near KV value 4147200 1
echo '{"plate": {"load_lb": [200, 400, 600], "settlement_in": [0.012, 0.022, 0.032], "plate_in": 11, "mat_length_ft": 12, "mat_width_ft": 2}, "deflection": {"load_lb": 120, "deflection_in": 0.05}}' >"$tmp/readings.json"
check "two tests of one parameter are refused" fails_with 4 'two tests give KV' $m params "$tmp/readings.json"
# 200 and 100 lb/in3 under half of 3456 in2: 4147200 and 2073600 lb/ft (12 in). Nodes at 0, 2, ... 10 ft; tests at 1 ft (two, the newer one holds) and at
# 7 ft, which is as near to 4 ft and newer. 5 % of 4147200 is the largest error.
acceptance_gives_kv() {
    local at
    for at in '1 bearing_lb_in3=150' '1 bearing_lb_in3=200+-10' '7 bearing_lb_in3=100+-5' '9 cbr_percent=20' '10 bearing_lb_in3=900'; do $m --quiet record "$tmp/kv.db" subgrade $at >/dev/null; done
    $m --quiet record "$tmp/kv.db" --correct 1 moisture_percent=5 --reason late >/dev/null # the test of 200 stays the newest
    $m --quiet record "$tmp/kv.db" --withdraw 5 --reason 'wrong scale' >/dev/null
    echo '{"subgrade": {"records": "kv.db", "mats": 5, "mat_length_ft": 2, "mat_width_ft": 12}}' >"$tmp/readings.json"
    near KV error 207360 1 && near KV value $((4147200 / 3 + 2073600 * 2 / 3)) 10 && $m params "$tmp/readings.json" -o "$tmp/kv.json" && cat "$tmp/kv.json" && python3 - "$tmp/kv.json" <<'PY' || return 1
import json, sys
kv = json.load(open(sys.argv[1]))["KV"]
assert [round(v / 100) for v in kv] == [41472, 41472, 20736, 20736, 20736, 20736], kv
PY
    sed -i 's/^{/{ "model": "consistent", "N": 5, "CV": 500, "mats_crossed": 1,/' "$tmp/kv.json" && $m sim "$tmp/kv.json" --solver staggered --limit 60
}
check "plate tests by station give KV along the runway" acceptance_gives_kv
echo '{"subgrade": {"records": "kv2.db", "mats": 5, "mat_length_ft": 2, "mat_width_ft": 12}}' >"$tmp/readings.json"
$m --quiet record "$tmp/kv2.db" subgrade 9 cbr_percent=20 >/dev/null
check "no plate test among the records" fails_with 4 'no plate test: .*kv2.db; set records' $m params "$tmp/readings.json"
cat >"$tmp/readings.json" <<'J'
{"tension": {"slope_lb_in_in": {"value": 9500, "error": 300}, "joint_in": 144}, "pull": {"weight_lb": 160, "pull_lb": {"readings": [78, 82, 80]}}}
J

scene_runs() {
    $m params "$tmp/readings.json" -o "$tmp/scene.json" && cat "$tmp/scene.json" &&
        sed -i 's/^{/{ "model": "chain", "N": 10,/' "$tmp/scene.json" && $m sim "$tmp/scene.json"
}
check "what -o writes is the beginning of a scene" scene_runs

while IFS='|' read -r name code pattern json; do
    echo "$json" >"$tmp/bad.json"
    check "$name" fails_with "$code" "$pattern" $m params "$tmp/bad.json"
done <<'J'
misspelt reading|4|weigth_lb|{"pull": {"weigth_lb": 3}}
negative reading|4|not a reading: .*pull.weight_lb; give a number above 0|{"pull": {"weight_lb": -3, "pull_lb": 1}}
a moment without turning|4|has zero moment at -4.0|{"hinge": {"angle_deg": [1, 2, 3, 4], "moment_ft_lb": [500, 601, 700, 799]}}
too few points|5|too few points|{"hinge": {"angle_deg": [1, 2], "moment_ft_lb": [3, 4]}}
lists of different lengths|4|3 and 2|{"hinge": {"angle_deg": [1, 2, 3], "moment_ft_lb": [3, 4]}}
no JSON|4|line [12] column|{
no infinite parameter|5|KV|{"deflection": {"load_lb": 1e300, "deflection_in": 1e-300}}
text for a reading|4|not a reading: .*pull.weight_lb|{"pull": {"weight_lb": "3", "pull_lb": 1}}
an error below 0|4|not a reading: .*pull.weight_lb; .*with E 0 or more|{"pull": {"weight_lb": {"readings": [3], "error": -1}, "pull_lb": 1}}
a list|4|no readings|[1]
no readings|4|no readings|{}
J
check "no file" fails_with 3 none.json $m params "$tmp/none.json"
finish
