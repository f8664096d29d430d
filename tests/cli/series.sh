#!/usr/bin/env bash
# matrig study: a small ensemble, its JSON, page and picture, the same on every processor, and what is refused.
. "$(dirname "$0")/tap.sh"
m=build/matrig
cat >"$tmp/scene.json" <<'J'
{"N": 120, "L": 0.2857142857142857, "W": 0.466, "I": 1.19e-4, "KV": 1.3e4, "CV": 60, "KT": 41.6, "CT": 1.57e-4, "TAD_deg": 7,
 "profile": "full", "KL": 2.9e5, "CL": 5, "slack": 0.0025, "left": "fixed", "right": "fixed", "f": 0.5, "v0": 0}
J
cat >"$tmp/small.json" <<'J'
{"name": "small <one>", "scene": "scene.json", "seeds": 4, "engine": {"use": "chain"},
 "landings": [{"speed_ft_s": 14, "deceleration_ft_s2": [4, 5], "times": 2}, {"speed_ft_s": 20, "deceleration_ft_s2": 9}]}
J
sed 's/"deceleration_ft_s2": 9/"deceleration_ft_s2": 0.0001/' "$tmp/small.json" >"$tmp/rolls.json"
sed 's/"N": 120/"N": 20000/' "$tmp/scene.json" >"$tmp/long.json"
sed 's/scene.json/long.json/; s/"speed_ft_s": 20/"speed_ft_s": 1/' "$tmp/rolls.json" >"$tmp/endless.json"
sed 's/"seeds"/"sedes"/' "$tmp/small.json" >"$tmp/typo.json"
sed 's/scene.json/none.json/' "$tmp/small.json" >"$tmp/lost.json"

check "help has an example" sh -c "$m study --help | grep -q '^Example: matrig study '"
check "a table, and how many seeds" sh -c "$m study $tmp/small.json --plot $tmp/plot.svg >$tmp/table && grep -q 'on 4 runways (seeds 1 to 4)' $tmp/table"
check "a row for each landing" sh -c "[ \$(grep -Ec '^ +[123] +4 ' $tmp/table) = 3 ]"
check "the plot has both panels" eval 'grep -q "small <one>\|small &lt;one" "$tmp/plot.svg" && grep -q "total movement" "$tmp/plot.svg" && grep -q "buckles in landing" "$tmp/plot.svg"'
seeds() {
    $m --json study "$tmp/small.json" >"$tmp/seeds.json" && [ "$(wc -l <"$tmp/seeds.json")" = 1 ] && grep -q '"seeds":4' "$tmp/seeds.json" &&
        [ "$(grep -o '"seed":[0-9]*' "$tmp/seeds.json" | sort -u | wc -l)" = 4 ]
}
check "JSON on a line, of all seeds" seeds
# Of six runways one is played twice, of four none.
peak_errors() { # SEEDS TEST: errors of peaks in the JSON, and in the table
    $m --json study "$tmp/small.json" --seeds "$1" >"$tmp/peaks.json" && python3 - "$tmp/peaks.json" "$2" <<'P' && $m study "$tmp/small.json" --seeds "$1" >"$tmp/peaks"
import json, sys
d = json.load(open(sys.argv[1]))
holds = (lambda e: e is None) if sys.argv[2] == "none" else (lambda e: e > 0)
for of in d["landings"] + [o for r in d["runways"] for o in r["landings"]]:
    assert all(holds(of[k]) for k in ("lift_ratio_error", "push_error_lb", "pull_error_lb")), of
for of in d["landings"]:
    assert of["push_lb"][0] <= of["push_lb"][1] <= of["push_lb"][2] and holds(of["push_mean_error_lb"]), of
P
}
check "peaks have errors" eval 'peak_errors 6 some && grep -Eq "^ +3 +[0-9.]+ \+- [0-9.]+ +[0-9.]+ +[0-9.]+ \+- " "$tmp/peaks"'
check "of too few runways none" eval 'peak_errors 4 none && grep -Eq "^ +3 +[0-9.]+ +- +[0-9.]+ +- *$" "$tmp/peaks"'
check "an aircraft that does not stop: exit 5, and why" fails_with 5 "could not be simulated" $m --quiet study "$tmp/endless.json" --seeds 1
check "the reason is on stdout" grep -q 'no stop: .*landing 3' "$tmp/out"
# A median is told as finely as its interval is wide: two digits of half of it, and no more than the quantity has.
digits_as_the_interval() { # OPTION...
    $m "$@" study "$tmp/small.json" >"$tmp/spread" && sed -n '/^each landing: median/,$p' "$tmp/spread" && python3 - "$tmp/spread" <<'P'
import math, re, sys
found = re.findall(r"(-?[0-9.]+) \((-?[0-9.]+)-(-?[0-9.]+)\)", open(sys.argv[1]).read().split("each landing: median")[1])
assert len(found) > 5, found
for value, low, high in found:
    half, told = (float(high) - float(low)) / 2, len(value.partition(".")[2])
    assert half <= 0 or told <= max(0, 1 - math.floor(math.log10(half * 0.93))), (value, low, high)
P
}
check "digits as the interval has" digits_as_the_interval
check "with --si, too" digits_as_the_interval --si
check "a misspelt key" fails_with 4 'unknown key: .*"sedes"' $m study "$tmp/typo.json"
check "a scene that is not there" fails_with 3 "cannot open scene: .*none.json" $m study "$tmp/lost.json"
check "no file" fails_with 2 "FILE" $m study
check "a plot of another kind, before anything is played" fails_with 2 ".svg, .png or .pdf" $m study "$tmp/small.json" --plot "$tmp/plot.html"
check "a plot that cannot be written" eval 'fails_with 3 "cannot write" $m study "$tmp/small.json" --plot "$tmp/none/plot.svg" && [ ! -s "$tmp/out" ]'
sed 's/"speed_ft_s": 20/"speed_ft_s": 20, "touchdown_ft": 40/' "$tmp/small.json" >"$tmp/beyond.json"
check "a touchdown beyond the runway" fails_with 4 "touchdown_ft.*34.2857 ft" $m study "$tmp/beyond.json"
check "too many seeds" fails_with 2 "--seeds" $m study "$tmp/small.json" --seeds 100001

# The same bytes on another processor: the C library's functions as on one without AVX2 and FMA. A wave rises, so that the last bit of an angle
# makes another landing.
same_bytes() { # STUDY GROUND
    local study=host/landing_series/series/$1.json
    $m --json --quiet study "$study" --ground "$2" --seeds 1 >"$tmp/with.json" && grep -q '"waves":[1-9]\|"buckled":true' "$tmp/with.json" &&
        GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable $m --json --quiet study "$study" --ground "$2" --seeds 1 >"$tmp/without.json" && cmp "$tmp/with.json" "$tmp/without.json"
}
for study in $(take standard "standard cleats friction"); do
    check "without AVX2 and FMA the same bytes: $study" same_bytes "$study" weightless
done
[ -z "${MATRIG_LONG:-}" ] || check "and on elastic ground" same_bytes cleats elastic

# Extremes end with an answer, or say why not.
extreme() { # NAME, replacements in the file, in the scene
    sed "$2" "$tmp/scene.json" >"$tmp/scene_$1.json"
    cat >"$tmp/$1.json" <<J
{"scene": "scene_$1.json", "seeds": 2, $3}
J
    timeout 600 $m --json --quiet study "$tmp/$1.json" >"$tmp/$1.out" 2>"$tmp/$1.err"
    case $? in
        0) grep -q '"failed":0' "$tmp/$1.out" && ! grep -Eqi '[^a-z](nan|inf)[^a-z]' "$tmp/$1.out" ;;
        5) grep -q '"failed":"' "$tmp/$1.out" && [ "$(wc -l <"$tmp/$1.err")" = 1 ] ;;
        *) cat "$tmp/$1.err"; false ;;
    esac
}
landings='"landings": [{"speed_ft_s": 20, "deceleration_ft_s2"'
check "locked wheels, 32 ft/s2" extreme locked '' "$landings: 32, \"times\": 3}]"
check "friction 0.05" extreme slippery 's/"f": 0.5/"f": 0.05/' "$landings: 9}]"
check "friction 1" extreme rough 's/"f": 0.5/"f": 1/' "$landings: 9}]"
check "all joints closed" extreme closed '' "\"runway\": {\"gap_in\": 0}, $landings: 9}]"
check "all joints closed, 32 ft/s2, friction 0.05" extreme all 's/"f": 0.5/"f": 0.05/' "\"runway\": {\"gap_in\": 0}, $landings: 32}]"
check "2,000 mats" extreme long 's/120/2000/' "$landings: 5, \"touchdown_ft\": [3, 400], \"times\": 3}]"
finish
