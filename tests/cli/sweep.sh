#!/usr/bin/env bash
# matrig sweep: 1,000 cases killed ten times and resumed, shards, torn lines, a second writer, failures, searches, designs, what is refused.
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
table() { sed 's/,"cpu_ms":[0-9.]*}$/}/' "$1" | sort; } # FILE: its lines without the times, in an order of their own
same() { cmp <(table "$1") <(table "$2"); }
lines() { if [ -e "$1" ]; then wc -l <"$1"; else echo 0; fi; }
distinct() { [ "$(wc -l <"$1")" -eq "$2" ] && [ "$(grep -o '"case":"[0-9a-f]*"' "$1" | sort -u | wc -l)" -eq "$2" ]; }

# --- unbroken, and killed ten times ---
study whole
unbroken() { $m sweep "$tmp/whole.json" -j2 && distinct "$tmp/whole.jsonl" 1000 && ! grep -v '"status":"ok"' "$tmp/whole.jsonl"; }
check "1,000 cases, 1,000 ids" unbroken
# F and the movement of mat 1 are proportional: nothing but springs and masses. KL times 4, F times 2: the same movement in half the time is not
# asked here; proportionality is.
proportional() {
    sed -n 's/.*"KL":1000000,"F":\([0-9]*\)}.*"outputs.-1.u_ft.1":\([0-9.e-]*\),.*/\1 \2/p' "$tmp/whole.jsonl" |
        awk '{ r = $2 / $1; if (NR == 1) first = r; d = r / first - 1; if (d > 1e-6 || d < -1e-6) bad++ } END { exit !(NR == 25 && !bad) }'
}
check "each case has its own values: movement is proportional to F" proportional

study killed
kills=0
wait_lines() { # FILE COUNT PROCESS: until it has that many, bounded; false when the process ended before
    for _ in $(seq 10000); do
        [ "$(lines "$1")" -ge "$2" ] && return 0
        kill -0 "$3" 2>/dev/null || return 1
        sleep 0.002
    done
    return 1
}
kill_once() {
    local target process
    target=$(($(lines "$tmp/killed.jsonl") + 5 + RANDOM % 55))
    $m --quiet sweep "$tmp/killed.json" -j 2 >"$tmp/killed.out" 2>&1 &
    process=$!
    wait_lines "$tmp/killed.jsonl" $target $process
    kill -9 $process 2>/dev/null
    wait $process 2>/dev/null
    [ $? -eq 137 ] && kills=$((kills + 1))
}
killed_ten_times() {
    while [ $kills -lt 10 ] && [ "$(lines "$tmp/killed.jsonl")" -lt 1000 ]; do kill_once; done
    echo "$kills kills, $(lines "$tmp/killed.jsonl") lines"
    [ $kills -eq 10 ] && [ "$(lines "$tmp/killed.jsonl")" -lt 1000 ]
}
check "killed ten times with cases left" killed_ten_times
resumed() {
    local before
    before=$(lines "$tmp/killed.jsonl")
    $m --json sweep "$tmp/killed.json" -j 2 >"$tmp/o.json" && cat "$tmp/o.json" || return 1
    grep -q "\"before\":$before,\"run\":$((1000 - before)),\"failed\":0,\"missing\":0" "$tmp/o.json" &&
        distinct "$tmp/killed.jsonl" 1000 && same "$tmp/killed.jsonl" "$tmp/whole.jsonl"
}
check "resumed: 1,000 distinct results, none twice, all as in the unbroken run" resumed
nothing_left() { # of the killed sweeps: the kernel ends their children, which may take it a moment
    gone() { ! pgrep -f "sweep $tmp/killed.json" >/dev/null; }
    await gone
}
check "no process is left behind" nothing_left
orphan() { # a child that does not run, so that only the kernel can end it
    echo '{"base": {"model": "consistent", "bump": [0.02]}, "vary": {"mats_crossed": [40]}, "outputs": ["bow_wave"]}' >"$tmp/orphan.json"
    $m --quiet sweep "$tmp/orphan.json" >/dev/null 2>&1 &
    local process=$! child=
    for _ in $(seq 500); do
        child=$(pgrep -P $process) && break
        sleep 0.01
    done
    kill -STOP "$child" && kill -9 $process
    wait $process 2>/dev/null
    ended() { ! kill -0 "$child" 2>/dev/null; }
    await ended && return 0
    kill -9 "$child"
    return 1
}
check "the child of a killed sweep ends with it" orphan
again() { $m sweep "$tmp/killed.json" | tee "$tmp/o" && grep -q '1000 done before, 0 run' "$tmp/o" && distinct "$tmp/killed.jsonl" 1000; }
check "once more: nothing to do" again

# --- a torn last line ---
torn() {
    head -n 990 "$tmp/whole.jsonl" >"$tmp/killed.jsonl" && sed -n 991p "$tmp/whole.jsonl" | head -c 100 >>"$tmp/killed.jsonl"
    $m sweep "$tmp/killed.json" >"$tmp/o" 2>"$tmp/e" && cat "$tmp/o" "$tmp/e" && grep -q '990 done before, 10 run' "$tmp/o" &&
        grep -q 'torn last line of 100 bytes' "$tmp/e" && same "$tmp/killed.jsonl" "$tmp/whole.jsonl"
}
check "a torn last line is found and its case done again" torn
whole_but_newline() { # also when only the newline is missing
    head -c -1 "$tmp/whole.jsonl" >"$tmp/killed.jsonl"
    $m --quiet sweep "$tmp/killed.json" >"$tmp/o" && grep -q '999 done before, 1 run' "$tmp/o" && same "$tmp/killed.jsonl" "$tmp/whole.jsonl"
}
check "a last line without its newline too" whole_but_newline
broken_middle() { sed '500s/.*/{"case": 1}/' "$tmp/whole.jsonl" >"$tmp/killed.jsonl"; fails_with 4 'not a result: .*killed.jsonl line 500' $m sweep "$tmp/killed.json"; }
check "a line that is no result is an error, with its number" broken_middle

# --- a second writer ---
second_writer() {
    rm -f "$tmp/killed.jsonl"
    $m --quiet sweep "$tmp/killed.json" -j 1 >"$tmp/first.out" 2>&1 &
    local first=$! refused
    wait_lines "$tmp/killed.jsonl" 1 $first && kill -STOP $first || return 1
    fails_with 2 "another sweep writes: .*killed.jsonl \(process $first\)" $m sweep "$tmp/killed.json"
    refused=$?
    kill -CONT $first
    wait $first && [ $refused -eq 0 ] && same "$tmp/killed.jsonl" "$tmp/whole.jsonl"
}
check "a second writer is refused, the first goes on" second_writer
stopped() { # Ctrl-C
    rm -f "$tmp/killed.jsonl"
    $m sweep "$tmp/killed.json" -j 2 >"$tmp/o" 2>&1 &
    local process=$!
    wait_lines "$tmp/killed.jsonl" 3 $process && kill -TERM $process
    wait $process
    [ $? -eq 1 ] && cat "$tmp/o" && grep -q 'stopped; the same command goes on' "$tmp/o" && ! grep -q ' 0 missing' "$tmp/o"
}
check "stopped by a signal: exit 1, what is missing is said" stopped

# --- shards ---
study parts
shards() {
    for i in 1 2 3; do $m --quiet sweep "$tmp/parts.json" --shard $i/3 || return 1; done >"$tmp/o"
    [ "$(cat "$tmp"/parts.?-of-3.jsonl | wc -l)" = 1000 ] && [ "$(lines "$tmp/parts.1-of-3.jsonl")" = 334 ] &&
        $m sweep "$tmp/parts.json" --gather >"$tmp/o" && cat "$tmp/o" && grep -q '1000 gathered from 3 files, 0 failed, 0 missing' "$tmp/o" &&
        same "$tmp/parts.jsonl" "$tmp/whole.jsonl" && cmp <(cut -c1-26 "$tmp/parts.jsonl") <($m sweep "$tmp/parts.json" --list | cut -c1-26)
}
check "three shards add up to the whole, in the study's order" shards
gather_again() { $m sweep "$tmp/parts.json" --gather >"$tmp/o" && grep -q ' 0 gathered' "$tmp/o" && distinct "$tmp/parts.jsonl" 1000; }
check "gathering again adds nothing" gather_again
array() { # as Slurm sets it for the array 1-4, task 3; and for 0-3, task 2: the same shard
    rm -f "$tmp"/parts*.jsonl
    SLURM_ARRAY_TASK_ID=3 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_MAX=4 SLURM_ARRAY_TASK_COUNT=4 $m --quiet sweep "$tmp/parts.json" &&
        mv "$tmp/parts.3-of-4.jsonl" "$tmp/one" &&
        SLURM_ARRAY_TASK_ID=2 SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_MAX=3 SLURM_ARRAY_TASK_COUNT=4 $m --quiet sweep "$tmp/parts.json" &&
        mv "$tmp/parts.3-of-4.jsonl" "$tmp/two" && SLURM_ARRAY_TASK_ID=3 $m --quiet sweep "$tmp/parts.json" --shard /4 &&
        same "$tmp/one" "$tmp/two" && same "$tmp/one" "$tmp/parts.3-of-4.jsonl" && [ "$(lines "$tmp/one")" = 250 ]
}
check "SLURM_ARRAY_TASK_ID chooses the shard" array
check "an array with holes is refused" fails_with 2 'SLURM_ARRAY_TASK_ID is 3, .*--shard /N' \
    env SLURM_ARRAY_TASK_ID=3 SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_MAX=5 SLURM_ARRAY_TASK_COUNT=3 $m sweep "$tmp/parts.json"
check "an id alone is not enough" fails_with 2 'SLURM_ARRAY_TASK_ID is 3' env SLURM_ARRAY_TASK_ID=3 $m sweep "$tmp/parts.json"
missing() { $m sweep "$tmp/parts.json" --gather >"$tmp/o"; [ $? -eq 1 ] && cat "$tmp/o" && grep -q '250 gathered from 1 files, 0 failed, 750 missing' "$tmp/o"; }
check "gathering too early says what is missing: exit 1" missing
other_shards() { # what any file of this study has is done
    $m sweep "$tmp/parts.json" --shard 1/2 >"$tmp/o" && cat "$tmp/o" && grep -q 'shard 1/2, 500 of 1000 cases: 250 done before, 250 run' "$tmp/o"
}
check "another division goes on from what is there" other_shards
foreign() { sed 's/"count": 25/"count": 24/' "$tmp/parts.json" >"$tmp/other.json" && cp "$tmp/whole.jsonl" "$tmp/other.jsonl" &&
    fails_with 4 'results of another sweep: .*other.jsonl line' $m sweep "$tmp/other.json"; }
check "results of another study are not mixed in" foreign

# --- ids ---
ids() { $m sweep "$1" --list | grep -o '"case":"[0-9a-f]*"' | sort; }
order() { # keys in another order, the same numbers written otherwise, a key from the base varied: the same cases
    cat >"$tmp/order.json" <<J
{"outputs": ["status", "outputs.-1.u_ft.1", "peak_u_ft"], "name": "other", "timeout_s": 5,
 "vary": {"F": {"to": 25e3, "count": 25, "from": 1000.0}, "tend": [0.01], "KL": {"scale": "log", "from": 1000000, "to": 1e8, "count": 40}},
 "base": {"tend": 5, "_a": "comment", $chain}}
J
    [ "$(ids "$tmp/order.json" | wc -l)" = 1000 ] && cmp <(ids "$tmp/order.json") <(ids "$tmp/whole.json")
}
check "ids do not depend on order or writing" order
extended() { sed 's/"to": 25000, "count": 25/"to": 26000, "count": 26/' "$tmp/whole.json" >"$tmp/more.json" && cp "$tmp/whole.jsonl" "$tmp/more.jsonl" &&
    $m sweep "$tmp/more.json" >"$tmp/o" && grep -q '1040 cases: 1000 done before, 40 run' "$tmp/o"; }
check "a study that is extended keeps what it has" extended
changed() { sed 's/"peak_u_ft", //' "$tmp/whole.json" >"$tmp/x.json" && [ "$(cat <(ids "$tmp/x.json") <(ids "$tmp/whole.json") | sort -u | wc -l)" = 2000 ]; }
check "other outputs are other cases" changed

# --- designs ---
cat >"$tmp/lhs.json" <<J
{"base": "base.json", "lhs": {"n": 200, "seed": 5, "keys": {"F": {"from": 1000, "to": 3000}, "KL": {"from": 1e5, "to": 1e7, "scale": "log"}}},
 "outputs": ["peak_u_ft"]}
J
column() { $m sweep "$1" --list | sed "s/.*\"$2\":\([0-9.e+-]*\).*/\1/"; }
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
    $m --quiet sweep "$tmp/set.json" && [ "$(wc -l <"$tmp/set.jsonl")" = 8 ] &&
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
    $m --quiet sweep "$tmp/find.json" && sed -n 's/.*"f":\([0-9.]*\),"W":\([0-9]*\)}.*"verdict":"between","low":\([0-9.]*\),"high":\([0-9.]*\),.*/\1 \2 \3 \4/p' "$tmp/find.jsonl" |
        tee "$tmp/o" | awk '{ t = $1 * $2; if (!($3 <= t && t <= $4) || $4 - $3 > 0.001 * $4) { print "wrong: " $0; bad = 1 } } END { exit bad || NR != 7 }'
}
check "the threshold of slip is f W, within the bracket of 0.1 %" slips
check "no threshold within the range is said" grep -q '"f":5,"W":320.*"verdict":"none","low":1000' "$tmp/find.jsonl"
at_most() { sed 's/"from": 10,/"from": 300,/; s/\[160, 320\]/[160]/; s/, 5\]/]/' "$tmp/find.json" >"$tmp/find2.json" && $m --quiet sweep "$tmp/find2.json" &&
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
campaigns() { $m --quiet sweep "$tmp/series.json" -j1 >"$tmp/o" && cat "$tmp/o" "$tmp/series.jsonl" && distinct "$tmp/series.jsonl" 4 && ! grep -v '"status":"ok"' "$tmp/series.jsonl"; }
check "a study of a campaign, known by its landings" campaigns
by_hand() { # DECELERATION F: the same from the runways of a campaign file that was written so
    sed "s/0.5, \"v0\"/$2, \"v0\"/" "$tmp/runway/scene.json" >"$tmp/runway/scene2.json"
    sed "s/scene.json/scene2.json/; s/: 8}/: $1}/; s/\"seeds\"/\"runway\": {\"closing_lb\": [0, 10]}, &/" "$tmp/runway/series.json" >"$tmp/runway/series2.json"
    $m --quiet --json campaign "$tmp/runway/series2.json" >"$tmp/direct.json" && python3 - "$tmp" "$1" "$2" <<'P'
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
kind_id() { # saying the kind changes nothing
    sed 's/{"base"/{"kind": "campaign", "base"/' "$tmp/series.json" >"$tmp/said.json" && cmp <(ids "$tmp/said.json") <(ids "$tmp/series.json") && [ "$(ids "$tmp/said.json" | wc -l)" = 4 ]
}
check "and its ids do not depend on whether the kind is said" kind_id
alone() { # the copy beside the results has the scene in it: it runs elsewhere
    mkdir -p "$tmp/away" && cp "$tmp/series.study.json" "$tmp/away/s.json" && cmp <(ids "$tmp/away/s.json") <(ids "$tmp/series.json")
}
check "the copy of the study is whole" alone
unplayable() { # an aircraft that rolls for longer than it is followed
    sed 's/"N": 120/"N": 20000/' "$tmp/runway/scene.json" >"$tmp/runway/long.json"
    cat >"$tmp/rolls.json" <<'J'
{"base": {"scene": "runway/long.json", "seeds": 2, "engine": {"use": "chain"}, "landings": [{"speed_ft_s": 1, "deceleration_ft_s2": 4}]},
 "vary": {"landings.0.deceleration_ft_s2": [4, 0.0001]}, "outputs": ["buckled_share"]}
J
    $m --quiet sweep "$tmp/rolls.json" && cat "$tmp/rolls.jsonl" && grep -q ':4}.*"status":"ok","result":{"buckled_share":0.0}' "$tmp/rolls.jsonl" &&
        grep -q '"status":"incomplete","reason":"2 of 2 runways could not be played; seed 1: no stop: ' "$tmp/rolls.jsonl"
}
check "a case with runways that cannot be played says so, and has no result" unplayable
page_campaign() { $m report "$tmp/series.jsonl" && grep -q "those of the campaign's keys" "$tmp/series.html" && [ "$(grep -c '<svg' "$tmp/series.html")" -ge 3 ]; }
check "its page" page_campaign

# --- failures are kept ---
cat >"$tmp/slow.json" <<'J'
{"base": {"model": "consistent", "profile": "full", "bump": [0.0099, 0.02, 0.0099], "mats_crossed": 6}, "vary": {"F": [11000, 12000]}, "outputs": ["bow_wave"]}
J
timeout_case() {
    $m sweep "$tmp/slow.json" --timeout 0.01 >"$tmp/o" && cat "$tmp/o" "$tmp/slow.jsonl" && grep -q '2 failed, 0 missing' "$tmp/o" &&
        [ "$(grep -c '"status":"timeout","reason":"not done after 0.01 s"' "$tmp/slow.jsonl")" = 2 ]
}
check "a case that takes too long is ended and recorded" timeout_case
kept() { $m sweep "$tmp/slow.json" >"$tmp/o" && grep -q '2 done before, 0 run.* 2 failed' "$tmp/o"; }
check "failures are not repeated by themselves" kept
retry() { $m sweep "$tmp/slow.json" --retry >"$tmp/o" && cat "$tmp/o" && grep -q '0 done before, 2 run.* 0 failed' "$tmp/o" && distinct "$tmp/slow.jsonl" 2; }
check "--retry does them again, in their place" retry
retry_shard() { # failures that were gathered, then tried again in a shard, and without shards
    cp "$tmp/slow.json" "$tmp/tries.json"
    for i in 1 2; do $m --quiet sweep "$tmp/tries.json" --timeout 0.01 --shard $i/2 || return 1; done
    $m sweep "$tmp/tries.json" --gather | grep -q '2 gathered from 2 files, 2 failed' && $m --quiet sweep "$tmp/tries.json" --retry --shard 2/2 &&
        $m sweep "$tmp/tries.json" --gather | grep -q '1 gathered from 2 files, 1 failed, 0 missing' &&
        $m sweep "$tmp/tries.json" --retry | grep -q '1 done before, 1 run.* 0 failed' && $m sweep "$tmp/tries.json" --gather | grep -q ' 0 gathered from 2 files, 0 failed' &&
        distinct "$tmp/tries.jsonl" 2
}
check "what is tried again takes the place of the failure, across shards" retry_shard
cat >"$tmp/fails.json" <<'J'
{"base": "base.json", "vary": {"KL": [8e6, -1], "friction": ["none", "rough"]}, "outputs": ["peak_u_ft"]}
J
refusals() {
    $m sweep "$tmp/fails.json" >"$tmp/o" && grep -q '3 failed' "$tmp/o" && grep -q '"KL":8000000.*rough.*"status":"refused","reason":"unknown choice: scene: friction' "$tmp/fails.jsonl" &&
        [ "$(grep -c 'out of range: scene: KL is -1' "$tmp/fails.jsonl")" -ge 1 ] && [ "$(grep -c '"status":"ok"' "$tmp/fails.jsonl")" = 1 ]
}
check "a case that the simulation refuses is recorded with the reason" refusals
unstable() { sed 's/"vary"/"solver": "event", "vary"/' "$tmp/slow.json" >"$tmp/solver.json" && $m --quiet sweep "$tmp/solver.json" --timeout 60 && [ "$(grep -c '"status":"ok"' "$tmp/solver.jsonl")" = 2 ]; }
check "the solver can be chosen" unstable

# --- the page ---
page() {
    $m report "$tmp/fails.jsonl" -o "$tmp/fails.html" && grep -q 'Failed cases' "$tmp/fails.html" && grep -q 'unknown choice: scene: friction' "$tmp/fails.html" || return 1
    $m report "$tmp/whole.jsonl" && grep -q '<h1>a &lt;study&gt; &amp; more</h1>' "$tmp/whole.html" && [ "$(grep -c '<svg' "$tmp/whole.html")" = 2 ] &&
        [ "$(grep -c 'class="line s' "$tmp/whole.html")" = 24 ] && ! grep -Eqi '[^a-z](nan|inf)[^a-z]' "$tmp/whole.html" && ! grep -Eq '(src|href)=' "$tmp/whole.html"
}
# two figures, each with six of 25 series and their keys
check "plots, failures with reasons, everything escaped, nothing from elsewhere" page
page_find() { $m report "$tmp/find.jsonl" && grep -q 'above 1000' "$tmp/find.html" && grep -q '10 to 1000' "$tmp/find.html" && grep -q '8 even parts upwards' "$tmp/find.html"; }
check "thresholds with their search" page_find
page_missing() { head -n 900 "$tmp/whole.jsonl" >"$tmp/killed.jsonl" && $m --json report "$tmp/killed.jsonl" >"$tmp/o.json" && grep -q '^{"cases":900,"failed":0,"missing":100,' "$tmp/o.json" && grep -q '100 of 1000' "$tmp/killed.html"; }
check "missing cases are shown as missing" page_missing
check "every text is inside its picture" python3 tests/report/texts_inside.py "$tmp/whole.html" "$tmp/find.html" "$tmp/series.html"
ranks() { nl | sort -g -k2 | awk '{ print $1, NR }' | sort -n | awk '{ print $2 }'; } # of the numbers on standard input, which all differ
spearman() { # KEY: with peak_u_ft, by Spearman's formula for ranks without ties, to three decimals
    paste <(sed "s/.*\"$1\":\([0-9.e+-]*\).*/\1/" "$tmp/lhs4.jsonl" | ranks) <(sed 's/.*"peak_u_ft":\([0-9.e-]*\).*/\1/' "$tmp/lhs4.jsonl" | ranks) |
        awk '{ d += ($1 - $2) ^ 2 } END { printf "%.3f", 1 - 6 * d / (NR * (NR * NR - 1)) }'
}
influence() { # F pushes, KL holds, CV has no place in a chain
    sed 's/"keys": {/"keys": {"CV": {"from": 1, "to": 2}, /' "$tmp/lhs.json" >"$tmp/lhs4.json" && $m --quiet sweep "$tmp/lhs4.json" && $m --quiet report "$tmp/lhs4.jsonl" || return 1
    for key in F KL CV; do
        grep -o "<td>$key</td><td class=\"n\">[0-9.-]*</td><td>200</td><td>[a-z]*" "$tmp/lhs4.html" | tee -a "$tmp/o"
        grep -q "<td>$key</td><td class=\"n\">$(spearman $key)</td>" "$tmp/lhs4.html" || return 1
    done
    grep -q '<td>F</td>.*beyond chance' "$tmp/lhs4.html" && grep -q '<td>CV</td>.*within chance' "$tmp/lhs4.html"
}
check "rank correlations say which sampled key matters" influence
indices() { # F and KL move the mats, CV has no place in a chain; the same shares by a second computation, from the order that --list says
    sed 's/"lhs": {"n": 200/"sobol": {"n": 40/; s/"keys": {/"keys": {"CV": {"from": 1, "to": 2}, /' "$tmp/lhs.json" >"$tmp/sobol.json" &&
        $m --quiet sweep "$tmp/sobol.json" && $m --json report "$tmp/sobol.jsonl" >"$tmp/o.json" &&
        [ "$(wc -l <"$tmp/sobol.jsonl")" = 200 ] && $m sweep "$tmp/sobol.json" --list >"$tmp/o" || return 1
    grep -q 'indices of sensitivity.*40 points, 200 samples' "$tmp/sobol.html" || return 1
    python3 - "$tmp/o" "$tmp/sobol.jsonl" "$tmp/o.json" <<'P'
import json, re, statistics, sys
order = [re.search(r'[0-9a-f]{16}', line).group() for line in open(sys.argv[1]) if re.search(r'[0-9a-f]{16}', line)]
of = {line['case']: line['result']['peak_u_ft'] for line in map(json.loads, open(sys.argv[2]))}
f = [of[case] for case in order]
block = lambda k: f[40 * k:40 * k + 40]
half = lambda p, q: sum((a - b) ** 2 for a, b in zip(p, q)) / 40 / 2 / statistics.pvariance(f[:80])
said = json.load(open(sys.argv[3]))['indices']['peak_u_ft'][0]
assert said['points'] == 40 and said['at'] == {}, said
for k, key in enumerate(('CV', 'F', 'KL')):
    first, total = said['keys'][key]['first'], said['keys'][key]['total']
    assert abs(first[0] - (1 - half(block(1), block(2 + k)))) < 1e-9, (key, first)
    assert abs(total[0] - half(block(0), block(2 + k))) < 1e-9, (key, total)
    assert first[1] <= first[0] <= first[2] and total[1] <= total[0] <= total[2]
assert said['keys']['CV']['total'][:3] == [0, 0, 0] and said['keys']['F']['total'][0] > 0.1
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
bad "no JSON" 4 'malformed JSON: .*bad.json line 1' '{"base":'
bad "not a sweep" 4 'not a sweep' '[]'
bad "a list has no index" 4 'sobol F is a list' "{$b, \"sobol\": {\"n\": 8, \"seed\": 1, \"keys\": {\"F\": [1, 2]}}, $o}"
bad "two samples of one sweep" 4 'lhs and sobol' "{$b, \"sobol\": {}, \"lhs\": {}, $o}"
bad "whole numbers from a half" 4 'give whole ends' "{$b, \"vary\": {\"N\": {\"from\": 0.5, \"to\": 9, \"count\": 3, \"scale\": \"whole\"}}, $o}"
bad "an unknown key" 4 'unknown key: .*"varies"' "{$b, \"varies\": {}, $o}"
bad "no base" 4 'something is missing: .*base' "{\"vary\": {\"F\": [1]}, $o}"
bad "a base that is not there" 3 'cannot open scene: .*nowhere.json' "{\"base\": \"nowhere.json\", \"vary\": {\"F\": [1]}, $o}"
bad "nothing varied" 4 'varies nothing' "{$b, $o}"
bad "no outputs" 4 'something is missing: .*outputs' "{$b, \"vary\": {\"F\": [1]}}"
bad "a key that scenes lack" 4 'unknown key: .*vary Thrust: a scene has no "Thrust"' "{$b, \"vary\": {\"Thrust\": [1]}, $o}"
bad "a first case that is refused" 4 'first case: KL' "{$b, \"vary\": {\"KL\": [-5, 1]}, $o}"
bad "an empty list" 4 'list of the wrong length: .*vary F' "{$b, \"vary\": {\"F\": []}, $o}"
bad "a range without count" 4 'vary F; give "count"' "{$b, \"vary\": {\"F\": {\"from\": 1, \"to\": 2}}, $o}"
bad "a log range below 0" 4 'a log range lies above 0' "{$b, \"vary\": {\"F\": {\"from\": -1, \"to\": 2, \"count\": 3, \"scale\": \"log\"}}, $o}"
bad "the same case twice" 4 'the same case twice: .*"F":5' "{$b, \"vary\": {\"F\": [5, 5.0]}, $o}"
bad "too many cases" 4 'too many cases' "{$b, \"vary\": {\"F\": {\"from\": 1, \"to\": 2, \"count\": 9999}, \"KL\": {\"from\": 1, \"to\": 2, \"count\": 9999}}, $o}"
bad "a dotted key that leads nowhere" 4 'no such place' "{$b, \"vary\": {\"path.7.1\": [5]}, $o}"
bad "a search without a field" 4 'find field' "{$b, \"vary\": {\"KL\": [5]}, \"find\": {\"key\": \"F\", \"from\": 1, \"to\": 2, \"above\": 1}}"
bad "a search of a varied key" 4 'varied and searched' "{$b, \"vary\": {\"F\": [5]}, \"find\": {\"key\": \"F\", \"from\": 1, \"to\": 2, \"field\": \"peak_u_ft\", \"above\": 1}}"
c='"base": "runway/series.json"' co='"outputs": ["buckled_share"]'
bad "a scene given as a campaign" 4 'wrong value: .*landings' "{\"kind\": \"campaign\", \"base\": {\"scene\": {}}, \"vary\": {\"seeds\": [1]}, $co}"
bad "a campaign given as a scene" 4 'unknown key' "{\"kind\": \"scene\", $c, \"vary\": {\"F\": [1]}, $co}"
bad "a key that campaigns lack" 4 'unknown key: .*first case: .*"friction"' "{$c, \"vary\": {\"friction\": [1]}, $co}"
bad "a key that its runway lacks" 4 'unknown key: .*runway."gaps"' "{$c, \"vary\": {\"runway.gaps\": [1]}, $co}"
bad "a key that its scene lacks" 4 'Thrust' "{$c, \"vary\": {\"scene.Thrust\": [1]}, $co}"
bad "a landing that it lacks" 4 'no such place' "{$c, \"vary\": {\"landings.2.speed_ft_s\": [1]}, $co}"
bad "a solver for a campaign" 4 'not here: .*solver' "{$c, \"solver\": \"event\", \"vary\": {\"seeds\": [1]}, $co}"
bad "a campaign whose scene is not there" 3 'cannot open scene: .*runway/gone.json' \
    "{\"base\": {\"scene\": \"runway/gone.json\", \"landings\": []}, \"vary\": {\"seeds\": [1]}, $co}"
unknown_output() { printf '%s' "{$b, \"vary\": {\"F\": [1]}, \"outputs\": [\"lift\"]}" >"$tmp/bad.json" && rm -f "$tmp/bad.jsonl" && $m --quiet sweep "$tmp/bad.json" && cat "$tmp/bad.jsonl" &&
    grep -q '"status":"refused","reason":"the result has no field \\"lift\\"' "$tmp/bad.jsonl"; }
check "an output that no result has" unknown_output
for shard in 0/3 4/3 1 x/3 1/0 /3 1/3x; do check "--shard $shard" fails_with 2 'no shard: ' $m sweep "$tmp/whole.json" --shard $shard; done
check "-j 0" fails_with 2 'out of range: 0 for -j' $m sweep "$tmp/whole.json" -j 0
check "--shards alone" fails_with 2 'alone: --shards' $m sweep "$tmp/whole.json" --shards 3
check "two ways at once" fails_with 2 'too much at once' $m sweep "$tmp/whole.json" --slurm --parallel
check "no sbatch" fails_with 3 'cannot run: sbatch; install it' env PATH=/nowhere "$PWD/$m" sweep "$tmp/parts.json" --slurm
check "results over the study" fails_with 2 'would overwrite the sweep' $m sweep "$tmp/whole.json" -o "$tmp/whole.json"
check "a folder that is not there" fails_with 3 'cannot write .*nowhere/r.jsonl' $m sweep "$tmp/whole.json" -o "$tmp/nowhere/r.jsonl"
full() { fails_with 3 'not a file of results|cannot' $m sweep "$tmp/whole.json" -o /dev/full; }
check "no regular file" full
check "help has an example" sh -c "$m sweep --help | grep -q 'Example: matrig sweep'"
check "report of nothing" fails_with 3 'cannot open results' $m report "$tmp/nothing.jsonl"
empty() { : >"$tmp/empty.jsonl"; fails_with 5 'no results yet' $m report "$tmp/empty.jsonl"; }
check "report of an empty file" empty
finish
