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
cat >"$tmp/block.json" <<'J'
{"model": "chain", "N": 1, "left": "free", "right": "free", "F": 160, "F_tstop": 0.1, "Vac": 0, "s0": 1, "v0": 0, "tend": 0.3}
J

check "a study runs and is drawn" sh -c "$m error $tmp/short.json --plot $tmp/plot.svg >$tmp/table"
check "every solver is in the table" awk '$1 ~ /^(event|implicit|cvode|rkgs|hamming|rk4)$/ && $NF ~ /ok|it$/ { s[$1] = 1 }
    END { for (n in s) k++; exit k != 6 }' "$tmp/table"
check "it says what the reference is" grep -Eq 'reference +event .*agrees with implicit' <(tr '\n' ' ' <"$tmp/table")
check "it says which is cheapest" grep -Eq '^ +cheapest +[a-z0-9]+ ' "$tmp/table"
drawn() {
    [ "$(grep -o 'run time, ms' "$tmp/plot.svg" | wc -l)" = 2 ] && grep -q 'largest error of lift, ft' "$tmp/plot.svg" &&
        grep -q 'xmlns=' "$tmp/plot.svg" && grep -q '10<tspan' "$tmp/plot.svg" &&
        [ "$(grep -c 'class="line e' "$tmp/plot.svg")" -ge 18 ] &&
        [ "$(grep -o 'class="full e.' "$tmp/plot.svg" | sort -u | wc -l)" = 6 ] &&
        grep -q 'short &lt;3.7&gt;' "$tmp/plot.svg" && ! grep -Eqi '[^a-z](nan|inf)[^a-z]' "$tmp/plot.svg"
}
check "two panels with axes, a line and marks for each of six solvers" drawn
check "every text is inside the picture" python3 tests/report/texts_inside.py "$tmp/plot.svg"

json() {
    $m --json error "$tmp/block.json" >"$tmp/o.json" && [ "$(wc -l <"$tmp/o.json")" = 1 ] || return 1
    cat "$tmp/o.json"
    for key in scene reference method agreement u_ft lift_ft runs solver rtol dt_s rhs run_ms err_u err_lift status order; do
        grep -q "\"$key\":" "$tmp/o.json" || return 1
    done
}
check "the keys of the JSON" json
check "a block's error falls to below 1e-6 ft" sh -c "grep -o '\"err_u\":[0-9.e-]*' $tmp/o.json | tail -n 1 |
    awk -F: '{ exit !(\$2 > 0 && \$2 < 1e-6) }'"

# A beyond-limit step of the chain is refused by its solver: it stays in the table, without errors.
cat >"$tmp/wave.json" <<'J'
{"model": "chain", "N": 20, "CL": 0, "left": "free", "right": "free", "F": 12000, "Vac": 0, "s0": 0, "v0": 0, "friction": "none", "tend": 0.02}
J
failed_run() {
    $m --json error "$tmp/wave.json" >"$tmp/wave.out" || return 1
    sed 's/{/\n{/g' "$tmp/wave.out" | grep '"status":"unstable"' | grep '"err_u":null' | grep -q '"err_lift":null'
}
check "a failed run stays in the table with null errors" failed_run

page() {
    mkdir -p "$tmp/page" && build/tests/error_report/error-report "$tmp/page" "$tmp/short.json" "$tmp/block.json" &&
        [ "$(grep -c '<svg ' "$tmp/page/index.html")" = 2 ] && grep -q 'is cheapest' "$tmp/page/index.html" &&
        grep -q 'falls as dt<sup>' "$tmp/page/index.html" && grep -q '</html>' "$tmp/page/index.html" &&
        ! grep -Eqi 'https?:|src=|[^a-z](nan|inf)[^a-z]' "$tmp/page/index.html"
}
check "the page is whole and self-contained" page

# The predictor's section: eight of its variants and three steps of the chain's solver; errors are the study's own.
predictor_page() {
    mkdir -p "$tmp/pp" && build/tests/error_report/error-report "$tmp/pp" predictor &&
        [ "$(grep -c '^<tr><td>predictor</td>' "$tmp/pp/index.html")" = 8 ] &&
        [ "$(grep -c '^<tr><td>staggered</td>' "$tmp/pp/index.html")" = 3 ] && [ "$(grep -c '<svg ' "$tmp/pp/index.html")" = 2 ] &&
        ! grep -Eqi 'src=|[^a-z](nan|inf)[^a-z]' "$tmp/pp/index.html"
}
check "the predictor is on the page beside the chain's solver" predictor_page
same_errors() { # the page's mean over landings is the JSON's
    local page json
    page=$(grep -o '<td>predictor</td><td>four in one</td>.*' "$tmp/pp/index.html" | sed 's/<[^>]*>/ /g' | awk '{ print $7 }')
    json=$(predictor_json "four in one" own_runway.rms_in)
    echo "page $page, JSON $json"
    awk -v a="$page" -v b="$json" 'BEGIN { exit !(a > 0 && a - b < 1e-4 && b - a < 1e-4) }'
}

# The predictor: the finer, the nearer and the dearer; what is beyond the limit is refused.
predictor_json() { sqlite3 :memory: "select round(avg(json_extract(l.value, '\$.$2')), 5) from json_each(json_extract(cast(readfile('$tmp/predictor.json') as text), '\$.variants')) v, json_each(json_extract(v.value, '\$.landings')) l where json_extract(v.value, '\$.variant') = '$1'"; }
falls() { # KEY VARIANT...
    local key=$1 last=1e9 value; shift
    for variant; do
        value=$(predictor_json "$variant" "$key")
        echo "$variant: $key $value"
        awk -v a="$value" -v b="$last" 'BEGIN { exit !(a > 0 && a < b) }' || return 1
        last=$value
    done
}
check "a study of the predictor" eval "$m error --predictor --plot $tmp/p.svg >$tmp/predictor.txt && $m --json error --predictor >$tmp/predictor.json"
check "with the errors of the study" same_errors
groups_are_near() { awk -v a="$(predictor_json "four in one" own_runway.rms_in)" 'BEGIN { print a; exit !(a > 0 && a < 0.03) }'; }
check "every mat errs less than two in one, and that less than the plough" falls own_runway.rms_in plough "two in one" "full, 0.167 ms"
check "four in one follow the fine chain to 0.03 in rms" groups_are_near
check "cycles fall from level to level" falls cycles "full, 0.05 ms" "full, 0.167 ms" "two in one" "four in one" "plough"
check "landing by landing" [ "$(grep -Ec ' %( over budget)?$' "$tmp/predictor.txt")" = 40 ]
check "a step beyond the limit is refused" grep -Eq '^ +full, 0.2 ms +refused: ' "$tmp/predictor.txt"
check "its plot has two panels" eval "[ \$(grep -o 'rms error of u, in' $tmp/p.svg | wc -l) = 2 ] && ! grep -Eqi '[^a-z](nan|inf)[^a-z]' $tmp/p.svg"
check "the predictor takes no scene" fails_with 2 'takes no SCENE' $m error --predictor "$tmp/short.json"
check "no reference: exit 5, no table" fails_with 5 "no reference" $m error "$tmp/sign.json"
check "nothing on stdout then" test ! -s "$tmp/out"
echo keep >"$tmp/old.svg"
check "no reference: an old plot stays" fails_with 5 "no reference" $m error "$tmp/sign.json" --plot "$tmp/old.svg"
check "it has stayed" grep -q keep "$tmp/old.svg"
check "no reference: no new plot" fails_with 5 "no reference" $m error "$tmp/sign.json" --plot "$tmp/new.svg"
check "there is none" test ! -e "$tmp/new.svg"
check "plot in no folder" fails_with 3 "cannot write.*none/x.svg" $m error "$tmp/short.json" --plot "$tmp/none/x.svg"
check "unknown option" fails_with 2 "'--rtol' of error" $m error "$tmp/short.json" --rtol 1e-3
check "no scene given" fails_with 2 "error needs SCENE" $m error
check "no such scene" fails_with 3 "none.json" $m error "$tmp/none.json"
echo '{"N": 8, "sped": 3}' >"$tmp/bad.json"
check "a scene with an unknown key" fails_with 4 sped $m error "$tmp/bad.json"
finish
