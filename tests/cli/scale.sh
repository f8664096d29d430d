#!/usr/bin/env bash
# matrig scale: values the report works out, scene files both ways, errors.
. "$(dirname "$0")/tap.sh"
m=build/matrig

# says PATTERN WORDS...: `matrig --json scale WORDS` has a member that matches.
says() {
    local want=$1
    shift
    $m --json scale "$@" >"$tmp/o.json" || return 1
    cat "$tmp/o.json"
    sed 's/[{},]/\n/g' "$tmp/o.json" | grep -Eq -- "$want"
}
check "1000 lb of model weigh 343000 lb" says '"to":343000\.0' weight=1000
check "2 slug ft2 become 1.19e-4" says '"to":0\.000118998' I=2 --to model
check "joint stiffness by n squared" says '"to":367346\.93' KL=1.8e7 --to model
check "the pilot model: 40 kip become 918 lb" says '"to":918\.27' weight=40000 --to model --n 6.6 --keep modulus

tables() { # Tables 2.2 and B.2, and what the text works out with n 7
    $m --json scale >"$tmp/density" && $m --json scale --keep modulus --n 6.6 >"$tmp/modulus" && python3 - "$tmp/density" "$tmp/modulus" <<'P'
import json, sys
density, modulus = ({r[k]: r for r in json.load(open(f))["ratios"] for k in ("name", "symbol")} for f in sys.argv[1:])
halves = {"gravity": 0, "length": 2, "density": 0, "weight": 6, "acceleration": 0, "friction": 0, "landings": 0, "velocity": 1, "modulus": 2, "pressure": 2,
          "time": 1, "soil_modulus": 0, "inertia": 10, "torsional_stiffness": 8, "stiffness": 4}
pilot = {"gravity": 0, "length": 2, "modulus": 0, "weight": 4, "density": -2, "friction": 0, "velocity": 1, "pressure": 0}
for table, n, powers in ((density, 7, halves), (modulus, 6.6, pilot)):
    bad = [k for k, p in powers.items() if abs(table[k]["ratio"] / n ** (p / 2) - 1) > 1e-10]
    assert not bad, bad
d = {k: r["ratio"] for k, r in density.items()}
for got, want, within in ((1440 * d["W"], 495000, 1500), (1220 * d["W"], 419000, 1000), (82 / d["p"], 12, .5), (28 * d["v"] * 3600 / 5280, 50, 1),
        (46 * d["v"] * 3600 / 5280, 85, 2.5), (1450 / d["line_force"], 30, .5), (120 * d["length"], 840, 1e-6), (.25 / d["l"], .036, .0005),
        (2 / d["I"], 1.19e-4, .005e-4), (1.8e7 / d["KL"], 3.67e5, .005e5), (1e5 / d["KT"], 41.5, .2), (40000 / modulus["W"]["ratio"], 920, 2)):
    assert abs(got - want) <= within, (got, want)
P
}
check "the report's two tables, and numbers of its text" tables

check "a force in newtons: 108 N are 24.28 lb" says '"from":24\.279[34]' F=108N
check "and with a blank" says '"from":24\.279[34]' "F=108 N"
check "a unit of another kind" fails_with 2 "a length instead of a force: '3mm' for F; write lb, .* or no unit for lb" $m scale F=3mm

# there_and_back SCENE FT: movements differ by at most FT. On the runway rounding decides whether single joints' grit gives
# way: its own error estimate is the measure.
there_and_back() {
    $m scale "$1" -o "$tmp/big.json" --force && $m scale "$tmp/big.json" --to model -o "$tmp/small.json" --force || return 1
    for f in "$1" "$tmp/small.json"; do
        $m --json sim "$f" | grep -o '"outputs".*"active"' | grep -o '"[0-9]*":[0-9.e-]*' | cut -d: -f2 >"$tmp/$(basename "$f").u"
    done
    paste "$tmp/$(basename "$1").u" "$tmp/small.json.u" |
        awk -v within="$2" '{ d = $1 - $2; if (NF != 2 || d * d > within * within) bad++ } END { print NR, bad; exit bad || NR < 5 }'
}
check "a scene scaled up and down again runs the same" there_and_back host/scenes/rstar_fig3_8_soft.json 1e-9

scaled_run() {
    cat >"$tmp/block.json" <<'J'
{"model": "chain", "N": 30, "F": 12000, "tend": 0.049, "u_mats": [4]}
J
    $m scale "$tmp/block.json" --to model -o "$tmp/model.json" || return 1
    big=$($m --json sim "$tmp/block.json" --rtol 1e-5 | grep -o '"4":[0-9.e-]*' | cut -d: -f2)
    small=$($m --json sim "$tmp/model.json" --rtol 1e-5 | grep -o '"4":[0-9.e-]*' | cut -d: -f2)
    echo "$big $small"
    awk -v a="$big" -v b="$small" 'BEGIN { r = a / b / 7; exit !(a > 0 && r > 0.99999 && r < 1.00001) }'
}
cp host/scenes/model_runway.json "$tmp/own.json"
ln -s own.json "$tmp/alias.json"
own() { fails_with 2 "would overwrite the input" $m scale "$tmp/own.json" -o "$1" && cmp "$tmp/own.json" host/scenes/model_runway.json; }
check "a quantity twice" fails_with 2 "velocity is given twice" $m scale velocity=3 weight=2 velocity=4
check "a scene is not written over itself" own "$tmp/own.json"
check "nor by another name of it" own "$tmp/alias.json"
damped() { # an element's key scales as its unit, lb s/ft: as CV does; text with a unit is a number then
    cat >"$tmp/damped.json" <<'J'
{"model": "chain", "N": 30, "slack": 0.01, "CV": 700, "ground_damping": 700}
J
    sed 's/"ground_damping": 700/"ground_damping": "700 lb s\/ft"/' "$tmp/damped.json" >"$tmp/text.json"
    for options in "--to model" "--n 3 --keep modulus"; do
        for file in damped text; do
            $m scale "$tmp/$file.json" $options -o "$tmp/out.json" --force || return 1
            cv=$(grep -o '"CV": *[0-9.e+-]*' "$tmp/out.json" | cut -d: -f2)
            c=$(grep -o '"ground_damping": *[0-9.e+-]*' "$tmp/out.json" | cut -d: -f2)
            echo "$options $file: $cv $c"
            awk -v a="$cv" -v b="$c" 'BEGIN { exit !(a > 0 && a != 700 && a - b < 1e-9 * a && b - a < 1e-9 * a) }' || return 1
        done
    done
}
check "ground damping scales as a damper of the ground" damped
check "and a runway" there_and_back host/scenes/model_runway.json 8e-4
check "a scaled scene moves 1/7 as far" scaled_run

banded() { # tensions of a model's bands are n^3 smaller; 7^3 = 343
    cat >"$tmp/banded.json" <<'J'
{"model": "chain", "N": 40, "F": 1200, "v0": 0, "Vac": 40, "tend": 0.5, "bands": 1, "band_T0": 9000, "band_every": 8, "band_K": 2000}
J
    $m scale "$tmp/banded.json" --to model -o "$tmp/small.json" --force || return 1
    for f in banded small; do
        $m --json sim "$tmp/$f.json" | grep -o '"band_least_lb":\[[^]]*' | cut -d[ -f2 | tr , '\n' >"$tmp/$f.t"
    done
    paste "$tmp/banded.t" "$tmp/small.t" | awk '{ r = $1 / $2 / 343; if (r < 0.999 || r > 1.001) bad++; if ($1 < 8995) moved++ } \
        END { print NR, bad + 0, moved; exit bad || NR != 6 || !moved }'
}
check "bands scale with it" banded
check "no such quantity" fails_with 2 "unknown quantity: 'speed'" $m scale speed=3
check "a symbol in the wrong case" fails_with 2 "'W' is for weight" $m scale w=3
check "a file for nothing" fails_with 2 "works only with a scene" $m scale W=1 -o "$tmp/nothing"
to_pipe() { timeout 600 $m scale "$tmp/block.json" -o /dev/stdout | grep -q '"mats"\|"N"'; }
check "an output that is a pipe" to_pipe
check "an output called -" fails_with 2 "the file name - is not accepted" $m scale "$tmp/block.json" -o -
check "not a number" fails_with 2 "not a number: 'x'" $m scale weight=x
check "no such side" fails_with 2 "unknown side: 'up'" $m scale weight=1 --to up
check "no such scene" fails_with 3 "none.json" $m scale "$tmp/none.json"
echo '{"model": "chain", "sped": 3}' >"$tmp/bad.json"
check "a scene with an unknown key" fails_with 4 sped $m scale "$tmp/bad.json"
check "a list of all ratios" grep -Eq 'torsional_stiffness +KT +n\^4 ' <($m scale)

laid_rig() { # rig.json by the factors of host/sim/MODIFICATIONS.md, to five digits; sliding is its own
    python3 - host/landing_series/series/rig.json host/landing_series/series/diagonal_rig.json <<'P'
import json, math, sys
rig, diagonal = (json.load(open(f)) for f in sys.argv[1:])
c = math.cos(math.radians(diagonal["lay_deg"]))
power = {"L": -1, "W": -1, "KV": -1, "CV": -1, "slack": -1, "KL": 1, "CL": 1, "TAD_deg": 1, "I": -3, "KT": -3, "CT": -3}
laid = {k: v * c ** power[k] if k in power else v for k, v in rig.items()}
laid["N"] = round(rig["N"] * c)
bad = [k for k in laid if k[0] != "_" and not (laid[k] == diagonal.get(k) or abs(laid[k] - diagonal[k]) < 2e-5 * abs(diagonal[k]))]
print(bad)
sys.exit(bool(bad))
P
}
check "the diagonal series' scene is the rig laid at 45 degrees" laid_rig
finish
