#!/usr/bin/env bash
# matrig sweep: cases as lines, run in parts by GNU parallel or one after the other, the table, failures, searches, designs, what is refused.
. "$(dirname "$0")/tap.sh"
m=build/matrig
chain='"model": "chain", "N": 20, "left": "free", "right": "free", "CL": 0, "Vac": 0, "s0": 0, "v0": 0, "friction": "none"'
cat >"$tmp/base.json" <<J
{$chain, "F": 12000, "tend": 0.01, "_note": "joined mats without friction, pushed on the first"}
J
study() { # NAME: 1,000 cheap cases
    cat >"$tmp/$1.json" <<'J'
{"name": "a <study> & more", "base": "base.json",
 "vary": {"KL": {"from": 1e6, "to": 1e8, "count": 40, "scale": "log"}, "F": {"from": 1000, "to": 25000, "count": 25}},
 "outputs": ["peak_u_ft", "outputs.-1.u_ft.1", "status"]}
J
}
run() { $m --quiet sweep "$tmp/$1.json" --cases 1..999999 -o "$tmp/$1.jsonl"; } # NAME: all cases, one after the other
table() { $m sweep "$tmp/$1.json" --table "${@:2}"; } # NAME FILE...

# --- the whole, and in parts ---
study whole
listed() { $m sweep "$tmp/whole.json" >"$tmp/o" && [ "$(wc -l <"$tmp/o")" = 1000 ] && sed -n '1p;1000p' "$tmp/o" && grep -q '^{"case":1000,"values":{"KL":100000000,"F":25000}}$' "$tmp/o"; }
check "alone, 1,000 cases as lines" listed
whole() { run whole && [ "$(wc -l <"$tmp/whole.jsonl")" = 1000 ] && ! grep -v '"status":"ok"' "$tmp/whole.jsonl"; }
check "all are run" whole
# F and the movement of mat 1 are proportional: nothing but springs and masses.
proportional() {
    sed -n 's/.*"KL":1000000,"F":\([0-9]*\)}.*"outputs.-1.u_ft.1":\([0-9.e-]*\),.*/\1 \2/p' "$tmp/whole.jsonl" |
        awk '{ r = $2 / $1; if (NR == 1) first = r; d = r / first - 1; if (d > 1e-6 || d < -1e-6) bad++ } END { exit !(NR == 25 && !bad) }'
}
check "each case has its own values: movement is proportional to F" proportional
parts() { # as tasks do, in any order, the last one beyond the end
    for n in 701 1 351; do $m --quiet sweep "$tmp/whole.json" --cases $n..$((n + 349)) -o "$tmp/part$n.jsonl" || return 1; done >"$tmp/o"
    cat "$tmp/part1.jsonl" "$tmp/part351.jsonl" "$tmp/part701.jsonl" | cmp - "$tmp/whole.jsonl"
}
check "parts are the whole, byte for byte" parts
one() { $m sweep "$tmp/whole.json" --cases 7 | cmp - <(sed -n 7p "$tmp/whole.jsonl"); }
check "one case, to standard output" one
gathered() { table whole "$tmp"/part*.jsonl -o "$tmp/whole.csv" >"$tmp/o" && cat "$tmp/o" && grep -q '^cases *1000 of 1000$' "$tmp/o" && grep -q '^missing *0$' "$tmp/o" &&
    [ "$(wc -l <"$tmp/whole.csv")" = 1001 ] && [ "$(head -n 1 "$tmp/whole.csv")" = "case,KL,F,status,peak_u_ft,outputs.-1.u_ft.1,status" ] && sed -n 3p "$tmp/whole.csv" | grep -q '^2,1000000,2000,ok,[0-9.]*,[0-9.]*,ok$'; }
check "the table, as CSV" gathered
missing() { table whole "$tmp/part1.jsonl" "$tmp/part701.jsonl" "$tmp/part1.jsonl" -o "$tmp/some.csv" >"$tmp/o"; [ $? -eq 1 ] && cat "$tmp/o" && grep -q '^missing *350$' "$tmp/o" && grep -q '^repeated *350$' "$tmp/o"; }
check "what is missing, or there twice, is counted: exit 1" missing
foreign() { sed 's/"count": 25/"count": 24/' "$tmp/whole.json" >"$tmp/other.json"; fails_with 4 'the results are of a different sweep: .*part1.jsonl line 1' $m sweep "$tmp/other.json" --table "$tmp/part1.jsonl"; }
check "results of another sweep are refused" foreign
torn() { head -c -20 "$tmp/part1.jsonl" >"$tmp/torn.jsonl"; fails_with 4 'not a line of results: .*torn.jsonl line 350' $m sweep "$tmp/whole.json" --table "$tmp/torn.jsonl"; }
check "so is a line that is none" torn
killed() { # a result file is there whole, or not at all
    $m --quiet sweep "$tmp/whole.json" --cases 1..1000 -o "$tmp/killed.jsonl" &
    kill -9 $!
    wait $! 2>/dev/null
    [ ! -e "$tmp/killed.jsonl" ]
}
check "a killed task leaves no file" killed

# --- designs ---
cat >"$tmp/lhs.json" <<J
{"base": "base.json", "lhs": {"n": 200, "seed": 5, "keys": {"F": {"from": 1000, "to": 3000}, "KL": {"from": 1e5, "to": 1e7, "scale": "log"}}},
 "outputs": ["peak_u_ft"]}
J
column() { $m sweep "$1" | sed "s/.*\"$2\":\([0-9.e+-]*\).*/\1/"; }
strata() { # KEY EXPRESSION of a value v that goes from 0 to 1: one in each of 200
    column "$tmp/lhs.json" "$1" | awk "{ v = \$1; k = int(200 * ($2)); if (k < 0 || k > 199 || s[k]++) exit bad = 1 } END { exit bad || NR != 200 }"
}
check "Latin hypercube: one value in each stratum, linear" strata F '(v - 1000) / 2000'
check "and logarithmic" strata KL 'log(v / 1e5) / log(100)'
unordered() { # the two keys have nothing to do with each other: correlation of ranks within 4 standard deviations, not sorted
    paste <(column "$tmp/lhs.json" F) <(column "$tmp/lhs.json" KL) | awk '{ x = $1; y = log($2); n++; sx += x; sy += y; xx += x * x; yy += y * y; xy += x * y
        if (NR > 1 && x > last) up++; last = x }
        END { r = (xy - sx * sy / n) / sqrt((xx - sx * sx / n) * (yy - sy * sy / n)); print r, up; exit !(r < 0.28 && r > -0.28 && up > 60 && up < 140) }'
}
check "its keys are in random order, each for itself" unordered
more_keys() {
    sed 's/"keys": {/"keys": {"W": [100, 160, 220], /' "$tmp/lhs.json" >"$tmp/lhs2.json" && cmp <(column "$tmp/lhs.json" F) <(column "$tmp/lhs2.json" F) &&
        column "$tmp/lhs2.json" W | sort | uniq -c | awk '$1 < 66 || $1 > 67 { bad = 1 } END { exit bad || NR != 3 }'
}
check "another key changes nothing; a list is sampled evenly" more_keys
seed() { sed 's/"seed": 5/"seed": 6/' "$tmp/lhs.json" >"$tmp/lhs3.json" && ! cmp -s <(column "$tmp/lhs.json" F) <(column "$tmp/lhs3.json" F); }
check "another seed, another design" seed
cat >"$tmp/set.json" <<'J'
{"base": {"model": "consistent", "N": 8, "bump": [0, 0.01, 0], "tend": 0.001},
 "vary": {"h_ft": {"values": [0.01, 0.02], "set": {"bump": [0.5, 1, 0.5], "slack": 0.1}}, "friction": ["stick", "none"], "bump_first": [4, 5]},
 "outputs": ["max_lift_ft"]}
J
set_keys() { # the lift at the start is the bump, less what the mats settle: W / 2 KV is 2e-5 ft
    run set && [ "$(wc -l <"$tmp/set.jsonl")" = 8 ] &&
        sed 's/.*"h_ft":\([0-9.]*\).*"max_lift_ft":\([0-9.e-]*\).*/\1 \2/' "$tmp/set.jsonl" | awk '{ d = $2 - $1; if (d > 1e-4 || d < -1e-4) bad = 1 } END { exit bad || NR != 8 }'
}
check "a value that sets a list by its shape; texts; whole numbers" set_keys

# --- searches: a block on a rough floor slips when F exceeds f W (Coulomb) ---
cat >"$tmp/find.json" <<'J'
{"base": {"model": "chain", "N": 1, "left": "free", "right": "free", "Vac": 0, "s0": 0.5, "v0": 0, "tend": 0.2},
 "vary": {"f": [0.1, 0.5, 0.9, 5], "W": [160, 320]},
 "find": {"key": "F", "from": 10, "to": 1000, "field": "peak_u_ft", "above": 0, "tolerance": 0.001}, "outputs": ["peak_u_ft"]}
J
slips() {
    run find && sed -n 's/.*"f":\([0-9.]*\),"W":\([0-9]*\)}.*"verdict":"between","low":\([0-9.]*\),"high":\([0-9.]*\),.*/\1 \2 \3 \4/p' "$tmp/find.jsonl" |
        tee "$tmp/o" | awk '{ t = $1 * $2; if (!($3 <= t && t <= $4) || $4 - $3 > 0.001 * $4) { print "wrong: " $0; bad = 1 } } END { exit bad || NR != 7 }'
}
check "the threshold of slip is f W, within the bracket of 0.1 %" slips
check "no threshold within the range is said" grep -q '"f":5,"W":320.*"verdict":"none","low":1000' "$tmp/find.jsonl"
at_most() { sed 's/"from": 10,/"from": 300,/; s/\[160, 320\]/[160]/; s/, 5\]/]/' "$tmp/find.json" >"$tmp/find2.json" && run find2 &&
    [ "$(grep -c '"verdict":"at_most","low":null,"high":300' "$tmp/find2.jsonl")" = 3 ]; }
check "a threshold below the range too" at_most

# --- campaigns: a case is what matrig study says of the file with the values in it ---
mkdir -p "$tmp/runway"
cat >"$tmp/runway/scene.json" <<'J'
{"N": 120, "L": 0.2857142857142857, "W": 0.466, "I": 1.19e-4, "KV": 1.3e4, "CV": 60, "KT": 41.6, "CT": 1.57e-4, "TAD_deg": 7,
 "profile": "full", "KL": 2.9e5, "CL": 5, "slack": 0.0025, "left": "fixed", "right": "fixed", "f": 0.5, "v0": 0}
J
cat >"$tmp/runway/series.json" <<'J'
{"scene": "scene.json", "seeds": [4, 6], "landings": [{"speed_ft_s": 10, "deceleration_ft_s2": 4}, {"speed_ft_s": 20, "deceleration_ft_s2": 8}]}
J
cat >"$tmp/series.json" <<'J'
{"base": "runway/series.json", "vary": {"landings.-1.deceleration_ft_s2": [8, 11], "scene.f": [0.5, 0.8], "runway.closing_lb": [[0, 10]]},
 "outputs": ["buckled_share", "median_station_ft", "median_zone_mats", "median_movement_in", "landings.0.total_in.5.1"]}
J
campaigns() { run series && cat "$tmp/series.jsonl" && [ "$(wc -l <"$tmp/series.jsonl")" = 4 ] && ! grep -v '"status":"ok"' "$tmp/series.jsonl"; }
check "a study of a campaign, known by its landings" campaigns
by_hand() { # DECELERATION F: the same from the runways of a campaign file that was written so
    sed "s/0.5, \"v0\"/$2, \"v0\"/" "$tmp/runway/scene.json" >"$tmp/runway/scene2.json"
    sed "s/scene.json/scene2.json/; s/: 8}/: $1}/; s/\"seeds\"/\"runway\": {\"closing_lb\": [0, 10]}, &/" "$tmp/runway/series.json" >"$tmp/runway/series2.json"
    $m --quiet --json study "$tmp/runway/series2.json" >"$tmp/direct.json" && python3 - "$tmp" "$1" "$2" <<'P'
import json, statistics, sys
tmp, a, f = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
runways = json.load(open(tmp + "/direct.json"))["runways"]
line, = [l for l in map(json.loads, open(tmp + "/series.jsonl")) if (l["values"]["landings.-1.deceleration_ft_s2"], l["values"]["scene.f"]) == (a, f)]
buckled = [r for r in runways if r["buckled_landing"]]
before = [[l for l in r["landings"] if not l["buckled"]] for r in runways]
want = {"buckled_share": len(buckled) / len(runways),
        "median_station_ft": statistics.median(r["buckled_ft"] for r in buckled) if buckled else None,
        "median_zone_mats": statistics.median(max(l["zone_mats"] for l in b) for b in before),
        "median_movement_in": statistics.median(max(l["peak_in"] for l in b) for b in before)}
for name, value in want.items():
    got = line["result"][name]
    print(name, got, value)
    assert got == value or abs(got - value) < 1e-4 * abs(value) + 1e-6, name
print(line["result"]["landings.0.total_in.5.1"])
assert line["result"]["landings.0.total_in.5.1"] == json.load(open(tmp + "/direct.json"))["landings"][0]["total_in"][5][1]
P
}
check "its cases are those of matrig study" by_hand 8 0.5
check "also with another friction and deceleration" by_hand 11 0.8
unplayable() { # an aircraft that rolls for longer than it is followed
    sed 's/"N": 120/"N": 20000/' "$tmp/runway/scene.json" >"$tmp/runway/long.json"
    cat >"$tmp/rolls.json" <<'J'
{"base": {"scene": "runway/long.json", "seeds": 2, "engine": {"use": "chain"}, "landings": [{"speed_ft_s": 1, "deceleration_ft_s2": 4}]},
 "vary": {"landings.0.deceleration_ft_s2": [4, 0.0001]}, "outputs": ["buckled_share"]}
J
    run rolls && cat "$tmp/rolls.jsonl" && grep -q ':4}.*"status":"ok","result":{"buckled_share":0.0}' "$tmp/rolls.jsonl" &&
        grep -q '"status":"incomplete","reason":"2 of 2 runways could not be simulated; seed 1: no stop: ' "$tmp/rolls.jsonl"
}
check "a case with runways that cannot be played says so, and has no result" unplayable
# --- failures are kept ---
cat >"$tmp/fails.json" <<'J'
{"base": "base.json", "vary": {"KL": [8e6, -1], "friction": ["none", "rough"]}, "outputs": ["peak_u_ft"]}
J
refusals() {
    run fails && table fails "$tmp/fails.jsonl" >"$tmp/o" && cat "$tmp/o" && grep -q '^failed *3$' "$tmp/o" && grep -q 'refused *1 *3$' "$tmp/o" && grep -q 'refused  unknown choice: scene: friction' "$tmp/o" && grep -q '"KL":8000000.*rough.*"status":"refused","reason":"unknown choice: scene: friction' "$tmp/fails.jsonl" &&
        [ "$(grep -c 'out of range: scene: KL is -1' "$tmp/fails.jsonl")" -ge 1 ] && [ "$(grep -c '"status":"ok"' "$tmp/fails.jsonl")" = 1 ]
}
check "a case that the simulation refuses is recorded with the reason" refusals

# --- indices ---
indices() { # F and KL move the mats, CV has no place in a chain; the same shares by a second computation
    sed 's/"lhs": {"n": 200/"sobol": {"n": 40/; s/"keys": {/"keys": {"CV": {"from": 1, "to": 2}, /' "$tmp/lhs.json" >"$tmp/sobol.json" && run sobol &&
        $m --json sweep "$tmp/sobol.json" --table "$tmp/sobol.jsonl" >"$tmp/o.json" && [ "$(wc -l <"$tmp/sobol.jsonl")" = 200 ] || return 1
    table sobol "$tmp/sobol.jsonl" | grep 'peak_u_ft  CV .* 40$' || return 1
    python3 - "$tmp/sobol.jsonl" "$tmp/o.json" <<'P'
import json, statistics, sys
f = [line['result']['peak_u_ft'] for line in map(json.loads, open(sys.argv[1]))]
block = lambda k: f[40 * k:40 * k + 40]
half = lambda p, q: sum((a - b) ** 2 for a, b in zip(p, q)) / 40 / 2 / statistics.pvariance(f[:80])
rows = {row['key']: row for row in json.load(open(sys.argv[2]))['indices']}
for k, key in enumerate(('CV', 'F', 'KL')):
    first, total = rows[key]['first'], rows[key]['total']
    assert rows[key]['points'] == 40 and rows[key]['at'] == {} and rows[key]['output'] == 'peak_u_ft'
    assert abs(first[0] - (1 - half(block(1), block(2 + k)))) < 1e-9, (key, first)
    assert abs(total[0] - half(block(0), block(2 + k))) < 1e-9, (key, total)
    assert first[1] <= first[0] <= first[2] and total[1] <= total[0] <= total[2]
assert rows['CV']['total'] == [0, 0, 0] and rows['F']['total'][0] > 0.1
P
}
check "indices say what share of the variance a key makes" indices

# --- what is refused ---
bad() { # NAME EXIT PATTERN JSON
    printf '%s' "$4" >"$tmp/bad.json"
    check "$1" fails_with "$2" "$3" $m sweep "$tmp/bad.json"
}
b='"base": "base.json"' o='"outputs": ["peak_u_ft"]'
check "no file" fails_with 3 'cannot open sweep: .*none.json' $m sweep "$tmp/none.json"
check "no word" fails_with 2 'needs FILE' $m sweep
bad "no JSON" 4 'sweep ends too early: .*bad.json line 1' '{"base":'
bad "not a sweep" 4 'not a sweep' '[]'
bad "a list has no index" 4 'F is a list; give a range, which a Sobol sweep needs' "{$b, \"sobol\": {\"n\": 8, \"seed\": 1, \"keys\": {\"F\": [1, 2]}}, $o}"
bad "two samples of one sweep" 4 'lhs and sobol' "{$b, \"sobol\": {}, \"lhs\": {}, $o}"
bad "whole numbers from a half" 4 'whole numbers for scale whole' "{$b, \"vary\": {\"N\": {\"from\": 0.5, \"to\": 9, \"count\": 3, \"scale\": \"whole\"}}, $o}"
bad "an unknown key" 4 'unknown key: .*"varies"' "{$b, \"varies\": {}, $o}"
bad "no base" 4 'key missing: .*base' "{\"vary\": {\"F\": [1]}, $o}"
bad "a base that is not there" 3 'cannot open base: .*nowhere.json' "{\"base\": \"nowhere.json\", \"vary\": {\"F\": [1]}, $o}"
bad "nothing varied" 4 'varies no key' "{$b, $o}"
bad "no outputs" 4 'key missing: .*outputs' "{$b, \"vary\": {\"F\": [1]}}"
bad "a key that scenes lack" 4 'unknown key: .*vary Thrust: a scene has no key "Thrust"' "{$b, \"vary\": {\"Thrust\": [1]}, $o}"
bad "a first case that is refused" 4 'first case: KL' "{$b, \"vary\": {\"KL\": [-5, 1]}, $o}"
bad "an empty list" 4 'list of the wrong length: .*vary F' "{$b, \"vary\": {\"F\": []}, $o}"
bad "a range without count" 4 'vary F; give "count"' "{$b, \"vary\": {\"F\": {\"from\": 1, \"to\": 2}}, $o}"
bad "a log range below 0" 4 'above 0 for scale log' "{$b, \"vary\": {\"F\": {\"from\": -1, \"to\": 2, \"count\": 3, \"scale\": \"log\"}}, $o}"
bad "too many cases" 4 'too many cases' "{$b, \"vary\": {\"F\": {\"from\": 1, \"to\": 2, \"count\": 9999}, \"KL\": {\"from\": 1, \"to\": 2, \"count\": 9999}}, $o}"
bad "a dotted key that leads nowhere" 4 'no such key' "{$b, \"vary\": {\"path.7.1\": [5]}, $o}"
bad "a search without a field" 4 'find: .*field' "{$b, \"vary\": {\"KL\": [5]}, \"find\": {\"key\": \"F\", \"from\": 1, \"to\": 2, \"above\": 1}}"
bad "a search of a varied key" 4 'varied and searched' "{$b, \"vary\": {\"F\": [5]}, \"find\": {\"key\": \"F\", \"from\": 1, \"to\": 2, \"field\": \"peak_u_ft\", \"above\": 1}}"
c='"base": "runway/series.json"' co='"outputs": ["buckled_share"]'
bad "a scene given as a campaign" 4 'wrong value: .*landings' "{\"base\": {\"scene\": {}, \"landings\": []}, \"vary\": {\"seeds\": [1]}, $co}"
bad "a key that campaigns lack" 4 'unknown key: .*first case: .*"friction"' "{$c, \"vary\": {\"friction\": [1]}, $co}"
bad "a key that its runway lacks" 4 'unknown key: .*runway."gaps"' "{$c, \"vary\": {\"runway.gaps\": [1]}, $co}"
bad "a key that its scene lacks" 4 'Thrust' "{$c, \"vary\": {\"scene.Thrust\": [1]}, $co}"
bad "a landing that it lacks" 4 'no such key' "{$c, \"vary\": {\"landings.2.speed_ft_s\": [1]}, $co}"
bad "a campaign whose scene is not there" 3 'cannot open scene: .*runway/gone.json' \
    "{\"base\": {\"scene\": \"runway/gone.json\", \"landings\": []}, \"vary\": {\"seeds\": [1]}, $co}"
unknown_output() { printf '%s' "{$b, \"vary\": {\"F\": [1]}, \"outputs\": [\"lift\"]}" >"$tmp/bad.json" && run bad && cat "$tmp/bad.jsonl" &&
    grep -q '"status":"refused","reason":"the result has no field \\"lift\\"' "$tmp/bad.jsonl"; }
check "an output that no result has" unknown_output
for cases in 0 5..4 1001 1001..1002; do check "--cases $cases" fails_with 2 'is out of range; give cases' $m sweep "$tmp/whole.json" --cases $cases; done
for cases in x 1.. ..2 1..2x -1; do check "--cases $cases" fails_with 2 'not a range of cases: --cases' $m sweep "$tmp/whole.json" --cases=$cases; done
check "-o alone" fails_with 2 '-o works only with --cases' $m sweep "$tmp/whole.json" -o "$tmp/r.jsonl"
check "two things at once" fails_with 2 'exclude each other' $m sweep "$tmp/whole.json" --cases 1 --table "$tmp/whole.jsonl"
check "no results" fails_with 2 'needs the result files' $m sweep "$tmp/whole.json" --table
check "results that are not there" fails_with 3 'cannot open results: .*gone.jsonl' $m sweep "$tmp/whole.json" --table "$tmp/gone.jsonl"
check "results over the sweep" fails_with 2 'would overwrite' $m sweep "$tmp/whole.json" --cases 1 -o "$tmp/whole.json"
check "a folder that is not there" fails_with 3 'cannot write .*nowhere/r.jsonl' $m sweep "$tmp/whole.json" --cases 1 -o "$tmp/nowhere/r.jsonl"
check "help has an example" sh -c "$m sweep --help | grep -q 'Example: matrig sweep'"
finish
