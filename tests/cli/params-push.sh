#!/usr/bin/env bash
# matrig params --push: readings of push tests to the gear's keys. Fits against two other ways (tests/push), units, refusals, what cannot be
# told, the page. How often the intervals hold: tests/host/test_push.c.
. "$(dirname "$0")/tap.sh"
m=build/matrig
# field FILE PATH: a value of its JSON, "a.b.0.c"
field() { python3 -c 'import functools, json, sys
print(functools.reduce(lambda at, key: at[int(key)] if isinstance(at, list) else at[key], sys.argv[2].split("."), json.load(open(sys.argv[1]))))' "$1" "$2"; }
# near FILE PATH VALUE RELATIVE-TOLERANCE
near() {
    local got
    got=$(field "$1" "$2") && echo "$2: $got, not $3" && awk -v g="$got" -v v="$3" -v t="$4" 'BEGIN { d = (g - v) / v; exit !(g != "" && d <= t && d >= -t) }'
}
push() { $m --json params --push "$@" >"$tmp/o.json"; }

# A second way to the same least squares.
witness() {
    python3 tests/push/witness.py tests/push/one.csv 0.5 0.001 >"$tmp/witness" && cat "$tmp/witness" && push tests/push/one.csv --mats 2 || return 1
    local name value low high
    while read -r name value low high; do
        case $name in
        K) near "$tmp/o.json" push.tests.0.k_lb_in "$value" 5e-5 && near "$tmp/o.json" push.tests.0.k_lb_in_low "$low" 5e-5 &&
            near "$tmp/o.json" push.tests.0.k_lb_in_high "$high" 5e-5 && near "$tmp/o.json" parameters.gear_k_lb_ft.value "$(awk "BEGIN {print 6 * $value}")" 5e-5 ;;
        rho) near "$tmp/o.json" push.tests.0.unloading "$value" 5e-5 && near "$tmp/o.json" push.tests.0.unloading_low "$low" 5e-5 &&
            near "$tmp/o.json" push.tests.0.unloading_high "$high" 5e-5 ;;
        chi2) near "$tmp/o.json" push.tests.0.chi_square "$value" 5e-5 ;;
        esac || return 1
    done <"$tmp/witness"
}
check "values, both ends of the intervals and chi2 as Gauss-Newton over every true force has them" witness

# What the simulation's mats do is what the fit finds.
by_sim() {
    python3 tests/push/by_sim.py $m "$tmp" "$1" "$2" "$3" >"$tmp/sim.csv" && push "$tmp/sim.csv" --mats 1 --dial-error 1e-5 --force-error 0.001 &&
        near "$tmp/o.json" parameters.gear_k_lb_ft.value "$1" 1e-3 && near "$tmp/o.json" parameters.gear_unloading.value "$2" 1e-3 &&
        near "$tmp/o.json" parameters.gear_axle_law.value "$3" 2e-3
}
check "the ground that matrig sim pushed on: 5,000 lb/ft, 0.7, 0.6" by_sim 5000 0.7 0.6
check "and 12,000 lb/ft, 0.95, 1" by_sim 12000 0.95 1

# Other units, columns in another order, a unit behind a value, an empty load: the same readings.
units() {
    push tests/push/one.csv --mats 2 && mv "$tmp/o.json" "$tmp/lb.json" &&
        awk -F, 'NR == 1 {print "# a comment\n\ndial [mm],force (N),load (kg)"; next}
            {printf "%.6f,%s,%s\n", $4 * 25.4, NR == 5 ? $3 " lb" : sprintf("%.7f", $3 * 4.4482216152605), NR == 2 ? sprintf("%.7f", $2 * 0.45359237) : ""}' \
            tests/push/one.csv >"$tmp/si.csv" && push "$tmp/si.csv" --mats 2 &&
        near "$tmp/o.json" parameters.gear_k_lb_ft.value "$(field "$tmp/lb.json" parameters.gear_k_lb_ft.value)" 1e-5 &&
        near "$tmp/o.json" parameters.wheel_load.value 108 1e-6
}
check "N, kg, mm and another order" units

# What cannot be told says why; the rest stands.
told() { $m params --push "$@" >"$tmp/text"; cat "$tmp/text"; }
no_unloading() { head -n 10 tests/push/one.csv >"$tmp/up.csv" && told "$tmp/up.csv" --mats 2 && grep -q '^gear_k_lb_ft ' "$tmp/text" &&
    grep -q '^gear_unloading  *undetermined: no readings while unloading' "$tmp/text" && grep -q '^gear_axle_law  *undetermined: the tests used only one load' "$tmp/text"; }
check "no way down, one load" no_unloading
still() { awk -F, -v OFS=, 'NR > 1 {$4 = 0.001} {print}' tests/push/one.csv >"$tmp/still.csv" && told "$tmp/still.csv" --mats 2 -o "$tmp/still.json" &&
    grep -q "^gear_k_lb_ft  *undetermined: .*at least [1-9]" "$tmp/text" && grep -q "^Coulomb's rigid law" "$tmp/text" && ! grep -q '"gear_' "$tmp/still.json"; }
check "nothing moves: Coulomb's law, a bound, and no key for a scene" still
weak() { awk -F, -v OFS=, 'NR > 1 {$3 = $3 / 12; $4 = 0} {print}' tests/push/one.csv >"$tmp/weak.csv" && told "$tmp/weak.csv" --mats 2 && grep -q '^Elastic ground cannot be distinguished' "$tmp/text" &&
    ! grep -q '^gear_k_lb_ft *[0-9]' "$tmp/text"; }
check "too weak a push: cannot tell which law" weak
bent() { awk -F, -v OFS=, 'NR > 1 {$4 = 4e-5 * $3 * $3} {print}' tests/push/one.csv >"$tmp/bent.csv" && told "$tmp/bent.csv" --mats 2 && grep -q '^Neither law fits well' "$tmp/text"; }
check "a bend that neither law has" bent
check "no axle of 50 lb was tested" eval 'told tests/push/one.csv --mats 2 --axle-load 50lb && grep -q "^gear_k_lb_ft *undetermined: the tests used 108 lb" "$tmp/text" && ! grep -q "^gear_k_lb_ft *[0-9]" "$tmp/text"'

# Bad input: one line.
bad() { printf "$1" >"$tmp/bad.csv" && fails_with "$2" "$3" $m params --push "$tmp/bad.csv" --mats 2; }
head='load (lb),force (lb),displacement (in)\n'
check "no --mats" fails_with 2 'number of mats unknown.*--mats 1 or --mats 2' $m params --push tests/push/one.csv
check "--mats without tests" fails_with 2 'mats without a push test' $m params --mats 2
check "nothing to read" fails_with 2 'no readings: give READINGS' $m params
check "no file" fails_with 3 'cannot read .*none.csv' $m params --push "$tmp/none.csv" --mats 2
check "empty" bad '' 4 'no readings: .*bad.csv'
check "no unit" bad 'load (lb),force,displacement (in)\n' 4 "no unit: .*line 1: 'force'; give the force in lb, N"
check "a force in mm" bad 'load (lb),force (mm),displacement (in)\n' 4 'the wrong kind: .*force'
check "a column missing" bad 'load (lb),force (lb)\n' 4 'no column for the displacement'
check "a column twice" bad 'load (lb),force (lb),force (N),displacement (in)\n' 4 'two columns for the force'
check "an unknown column" bad 'load (lb),force (lb),displacement (in),time\n' 4 "unknown column: .*'time'"
check "a unit that matrig does not convert" bad 'load (kip),force (lb),displacement (in)\n' 4 "unknown unit in a column name: .*'load \(kip\)'"
check "no number" bad "${head}108,0,0\n108,five,0.01\n" 4 "no number: .*line 3: force 'five'"
check "a reading missing" bad "${head}108,0,0\n108,5,\n" 4 'reading missing: .*line 3: displacement'
check "a decimal comma" bad "${head}108,0,0\n108,5,0,01\n" 4 '4 values for 3 columns: .*line 3'
check "no load at first" bad "${head},0,0\n" 4 'reading missing: .*line 2: load'
check "a load of 0" bad "${head}0,0,0\n" 4 'out of range: .*line 2: load 0'
check "a displacement of 1e150" bad "${head}108,0,0\n108,5,1e150\n" 4 'out of range: .*line 3: displacement 1e150'
check "too few readings" bad "${head}108,0,0\n108,5,0.004\n108,10,0.009\n" 5 'too few readings: .*bad.csv: test 1 under 108 lb has 3'
check "no force" bad "${head}108,0,0\n108,1,0\n108,2,0\n108,1,0\n108,0,0\n" 5 'all forces are below their error'
check "does not write over the readings" fails_with 2 'one.csv' $m params --push tests/push/one.csv --mats 2 -o tests/push/one.csv --force

# Both kinds of readings make one scene, and the scene runs.
together() {
    echo '{"pull": {"weight_lb": 160, "pull_lb": {"readings": [78, 82, 80]}}}' >"$tmp/readings.json"
    $m params "$tmp/readings.json" --push tests/push/one.csv --mats 2 -o "$tmp/scene.json" --plot "$tmp/push.svg" >"$tmp/text" && cat "$tmp/scene.json" "$tmp/text" &&
        near "$tmp/scene.json" f 0.5 1e-9 &&
        sed -i 's/^{/{ "model": "chain", "N": 10, "L": 0.2857, "W": 0.466, "F": 20,/' "$tmp/scene.json" && $m sim "$tmp/scene.json"
}
check "with READINGS: one scene that runs" together
check "the plot has both laws" sh -c "grep -q 'elastic ground' $tmp/push.svg && grep -q 'Coulomb, rigid' $tmp/push.svg && grep -q 'test A' $tmp/push.svg"
finish
