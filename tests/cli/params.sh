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
# I = W d2 T2/(16 pi2 l) = 140*4*1.2796^2/(631.655) = 1.45165; errors: weight 0.357 %, period 2 * 0.00051/1.2796
check "inertia" near I value 1.45165 2e-5
check "inertia's error" near I error 0.005313 2e-5
check "KL of the report" near KL value 16416000 1
check "KL's error" near KL error 518400 1
check "KT of the report" near KT value 1e5 1
check "TAD of the report" near TAD_deg value 10 1e-4
check "friction" near f value 0.5 1e-9
check "friction's error" near f error 0.0072169 1e-6
check "soil" near KV value 14400 1e-6
check "soil's error" near KV error 1440 1e-6

scene_runs() {
    $m params "$tmp/readings.json" -o "$tmp/scene.json" && cat "$tmp/scene.json" &&
        sed -i 's/^{/{ "model": "chain", "N": 10,/' "$tmp/scene.json" && $m sim "$tmp/scene.json"
}
check "what -o writes is the beginning of a scene" scene_runs

echo '{"pull": {"weigth_lb": 3}}' >"$tmp/typo.json"
check "misspelt reading" fails_with 4 'weigth_lb' $m params "$tmp/typo.json"
echo '{"pull": {"weight_lb": -3, "pull_lb": 1}}' >"$tmp/negative.json"
check "negative reading" fails_with 4 'pull.weight_lb is -3' $m params "$tmp/negative.json"
echo '{"hinge": {"angle_deg": [1, 2], "moment_ft_lb": [3, 4]}}' >"$tmp/few.json"
check "too few points" fails_with 5 'too few points' $m params "$tmp/few.json"
echo '{"hinge": {"angle_deg": [1, 2, 3], "moment_ft_lb": [3, 4]}}' >"$tmp/pairs.json"
check "lists of different lengths" fails_with 4 '3 and 2' $m params "$tmp/pairs.json"
echo '{' >"$tmp/broken.json"
check "no JSON" fails_with 4 'line [12] column' $m params "$tmp/broken.json"
echo '{"deflection": {"load_lb": 1e300, "deflection_in": 1e-300}}' >"$tmp/huge.json"
check "no infinite parameter" fails_with 5 'KV' $m params "$tmp/huge.json"
echo '{"pull": {"weight_lb": "3", "pull_lb": 1}}' >"$tmp/text.json"
check "text for a reading" fails_with 4 'no reading: .*pull.weight_lb' $m params "$tmp/text.json"
echo '{"pull": {"weight_lb": {"readings": [3], "error": -1}, "pull_lb": 1}}' >"$tmp/minus.json"
check "an error below 0" fails_with 4 'has error -1' $m params "$tmp/minus.json"
echo '[1]' >"$tmp/list.json"
check "a list" fails_with 4 'no JSON object' $m params "$tmp/list.json"
check "no file" fails_with 3 none.json $m params "$tmp/none.json"
echo '{}' >"$tmp/empty.json"
check "no readings" fails_with 4 'no readings' $m params "$tmp/empty.json"
finish
