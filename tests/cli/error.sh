#!/usr/bin/env bash
# matrig error: the table, its JSON, the plot, the page, and what is refused.
. "$(dirname "$0")/tap.sh"
m=build/matrig
cat >"$tmp/short.json" <<'J'
{"name": "short <3.7>", "N": 8, "bump": [0.0099, 0.02, 0.0099], "friction": "tanh", "tend": 0.008}
J
cat >"$tmp/sign.json" <<'J'
{"N": 8, "bump": [0.0099, 0.02, 0.0099], "friction": "sign", "tend": 0.003}
J
echo '{"model": "chain", "N": 3, "tend": 0.3}' >"$tmp/chain.json"

check "a study runs and is drawn" sh -c "$m error $tmp/short.json --plot $tmp/plot.svg >$tmp/table"
check "every solver is in the table" awk '$1 ~ /^(event|implicit|cvode|rkgs|hamming|rk4)$/ && $NF ~ /ok|it$/ { s[$1] = 1 }
    END { for (n in s) k++; exit k != 6 }' "$tmp/table"
check "it says what the reference is" grep -Eq 'reference +event .*in agreement with implicit' <(tr '\n' ' ' <"$tmp/table")
check "it says which is cheapest" grep -Eq '^ +cheapest +[a-z0-9]+ ' "$tmp/table"
drawn() {
    [ "$(grep -o 'run time (ms)' "$tmp/plot.svg" | wc -l)" = 2 ] && grep -q 'largest error of lift (ft)' "$tmp/plot.svg" && grep -q 'short <3.7>\|short &lt;3.7' "$tmp/plot.svg" &&
        [ "$(grep -oE '>(event|implicit|cvode|rkgs|hamming|rk4)<' "$tmp/plot.svg" | sort -u | wc -l)" = 6 ] && ! grep -Eqi '[^a-z](nan|inf)[^a-z]' "$tmp/plot.svg"
}
check "two panels with axes, and six solvers" drawn

json() {
    $m --json error "$tmp/short.json" >"$tmp/o.json" && [ "$(wc -l <"$tmp/o.json")" = 1 ] || return 1
    cat "$tmp/o.json"
    for key in scene reference method agreement u_ft lift_ft runs solver rtol dt_s rhs run_ms err_u err_lift status order; do
        grep -q "\"$key\":" "$tmp/o.json" || return 1
    done
}
check "the keys of the JSON" json
check "the error falls to below 1e-6 ft" sh -c "grep -o '\"err_u\":[0-9.e-]*' $tmp/o.json | tail -n 1 |
    awk -F: '{ exit !(\$2 > 0 && \$2 < 1e-6) }'"

# The predictor beside the chain's solver: eight of its variants and three steps.
report() {
    build/tests/error_report/error-report "$tmp" >"$tmp/predictor.md" && cat "$tmp/predictor.md" &&
        [ "$(grep -c '^| predictor | .* | [0-9.]* |$' "$tmp/predictor.md")" = 8 ] && [ "$(grep -c '^| staggered |' "$tmp/predictor.md")" = 3 ]
}
check "the predictor is reported beside the chain's solver" report
column() { awk -F ' *[|] *' -v name="$1" -v column="$2" '$3 == name { print $column }' "$tmp/predictor.md"; }
# The finer, the nearer and the dearer.
falls() { # COLUMN VARIANT...
    local column=$1 last=1e9 value; shift
    for variant; do
        value=$(column "$variant" "$column")
        echo "$variant: $value"
        awk -v a="$value" -v b="$last" 'BEGIN { exit !(a > 0 && a < b) }' || return 1
        last=$value
    done
}
groups_are_near() { awk -v a="$(column "four in one" 6)" 'BEGIN { print a; exit !(a > 0 && a < 0.03) }'; }
check "every mat errs less than two in one, and that less than the plough" falls 6 plough "two in one" "full, 0.167 ms"
check "four in one follow the fine chain to 0.03 in rms" groups_are_near
check "cycles fall from level to level" falls 5 "full, 0.05 ms" "full, 0.167 ms" "two in one" "four in one" "plough"
check "a step beyond the limit is refused" grep -q '^| predictor | full, 0.2 ms | refused: ' "$tmp/predictor.md"
check "its plot has two panels" eval "[ \$(grep -o 'rms error of u (in)' $tmp/predictor.svg | wc -l) = 2 ]"
check "no reference: exit 5, no table" fails_with 5 "no reference" $m error "$tmp/sign.json"
check "nothing on stdout then" test ! -s "$tmp/out"
echo keep >"$tmp/old.svg"
check "no reference: an old plot stays" fails_with 5 "no reference" $m error "$tmp/sign.json" --plot "$tmp/old.svg"
check "it has stayed" grep -q keep "$tmp/old.svg"
check "no reference: no new plot" fails_with 5 "no reference" $m error "$tmp/sign.json" --plot "$tmp/new.svg"
check "there is none" test ! -e "$tmp/new.svg"
chain() { # of first order by steps; events come below it
    $m --json error "$tmp/chain.json" --plot "$tmp/chain.svg" >"$tmp/chain.out" && python3 - "$tmp/chain.out" <<'P'
import json, sys
d = json.load(open(sys.argv[1]))
by = {s: [r for r in d["runs"] if r["solver"] == s] for s in ("event", "staggered")}
assert len(by["event"]) >= 7 and len(by["staggered"]) >= 10, by
assert min(r["err_u"] for r in by["event"]) < 1e-9 < by["staggered"][-1]["err_u"] < by["staggered"][0]["err_u"]
P
}
check "a chain: its two solvers over tolerances and steps" chain
check "plot in no folder" fails_with 3 "cannot write.*none/x.svg" $m error "$tmp/short.json" --plot "$tmp/none/x.svg"
check "unknown option" fails_with 2 "'--rtol' of error" $m error "$tmp/short.json" --rtol 1e-3
check "no scene given" fails_with 2 "error needs SCENE" $m error
check "no such scene" fails_with 3 "none.json" $m error "$tmp/none.json"
echo '{"N": 8, "sped": 3}' >"$tmp/bad.json"
check "a scene with an unknown key" fails_with 4 sped $m error "$tmp/bad.json"
finish
