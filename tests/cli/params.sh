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

# A joint that is free up to 10 degrees and has 1e5 ft lb/rad beyond: hinge FROM STEP TO SCATTER, made by awk.
hinge() {
    awk -v from="$1" -v step="$2" -v to="$3" -v noise="$4" 'BEGIN {
        for (a = from; a <= to; a += step) {
            beyond = (a - 10) * atan2(0, -1) / 180
            angles = angles comma a; moments = moments comma ((beyond > 0 ? 1e5 * beyond : 0) + noise * sin(7 * a * a)); comma = ", "
        }
        print "{\"hinge\": {\"angle_deg\": [" angles "], \"moment_ft_lb\": [" moments "]}}" }' >"$tmp/readings.json"
    cat "$tmp/readings.json"
}
hinge 11.3 0.7 16 30
check "all beyond the free travel: KT" near KT value 1e5 1500
check "TAD" near TAD_deg value 10 0.06
hinge 2.3 0.7 16 30
check "some within: KT of those beyond" near KT value 1e5 1500
check "TAD of those beyond" near TAD_deg value 10 0.06
within_its_error() {
    $m --json params "$tmp/readings.json" | tr '{}' '\n' | awk -F'[:,]' '/"value"/ { off = $2 - (n++ ? 10 : 1e5); print off, $4
        if (off * off > 9 * $4 * $4 || $4 <= 0) bad = 1 } END { exit !(n == 2 && !bad) }'
}
check "both within three of their errors" within_its_error
check "and how many there are" eval '$m params "$tmp/readings.json" | grep -q "^KT.*, [89] of 20 readings beyond the free travel"'
hinge 1 1 9 30
check "all within: refused with what can be said" fails_with 5 'no spring beyond a free travel: .*hinge: 0 of 9' $m params "$tmp/readings.json"
hinge 1 1 9 0
check "all within, without scatter" fails_with 5 'hinge: 0 of 9' $m params "$tmp/readings.json"
hinge 2.5 1.5 12 3
check "one beyond" fails_with 5 'no spring beyond a free travel: .*: [12] of 7' $m params "$tmp/readings.json"
echo '{"hinge": {"angle_deg": [1, 2, 3, 4, 5, 6], "moment_ft_lb": [20.3, 19.8, 20.1, 19.7, 20.4, 19.9]}}' >"$tmp/readings.json"
check "a hinge that drags alike at all angles" fails_with 5 'no spring beyond a free travel' $m params "$tmp/readings.json"
echo '{"hinge": {"angle_deg": [-12, 11, 12, 13], "moment_ft_lb": [-3491, 1745, 3491, 5236]}}' >"$tmp/readings.json"
check "both ways at once" fails_with 4 'angle below 0' $m params "$tmp/readings.json"
echo '{"hinge": {"angle_deg": [1, 2, 3, 4], "moment_ft_lb": [500, 601, 700, 799]}}' >"$tmp/readings.json"
check "a moment without turning" fails_with 4 'meets no moment at -4.0' $m params "$tmp/readings.json"
# slack of 0.02 in, then 9,500 lb/in per in of a strip of 2 in
echo '{"tension": {"joint_in": 144, "strip_in": 2, "stretch_in": [0.005, 0.01, 0.015, 0.03, 0.04, 0.05, 0.06], "force_lb": [1, -2, 1, 191, 379, 571, 759]}}' >"$tmp/readings.json"
check "a joint's slack is left out of KL" near KL value 16416000 150000
echo '{"pull": {"weight_lb": 160, "pull_lb": 80}}' >"$tmp/readings.json"
check "an error that nobody stated is unknown, not 0" eval '$m params "$tmp/readings.json" | grep -q "^f .*0.5 error unknown" && $m --json params "$tmp/readings.json" | grep -q "\"error\":null"'
cat >"$tmp/readings.json" <<'J'
{"tension": {"slope_lb_in_in": {"value": 9500, "error": 300}, "joint_in": 144}, "pull": {"weight_lb": 160, "pull_lb": {"readings": [78, 82, 80]}}}
J

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
