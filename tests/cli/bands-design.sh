#!/usr/bin/env bash
# matrig bands: the worked example of Appendix C to the digit, other designs worked by hand, units, errors.
. "$(dirname "$0")/tap.sh"
m=build/matrig
# says KEY VALUE TOLERANCE WORDS...: of the design in the JSON of `matrig bands WORDS`
says() {
    local key=$1 value=$2 tolerance=$3 got
    shift 3
    timeout 600 $m --json bands "$@" >"$tmp/o.json"
    got=$(grep -o "\"$key\":[0-9.e+-]*" "$tmp/o.json" | head -n 1 | cut -d: -f2)
    echo "$key $got"
    awk -v g="$got" -v v="$value" -v t="$tolerance" 'BEGIN { exit !(g != "" && g - v <= t && v - g <= t) }'
}
example="weight=480kip deceleration=0.5g bands=4 width=6in thickness=0.375in yield=50ksi mat=160lb friction=0.5 held=4 every=10 row=2ft"
printed() { # as the report prints them: kip to one decimal, whole connections and feet
    $m bands $example >"$tmp/o" || return 1
    cat "$tmp/o"
    awk '$1 == "R" { r = $2 } $1 == "A" { s = $3 } $1 == "n" && $2 == "F'\''" { nf = $3 } $1 == "F'\''" { f = $2 }
        $1 == "n" && $2 != "F'\''" { n = $2 } $1 == "length" { l = $2 } $1 == "T0" { t = $2 }
        END { exit !(r == 60000 && s == 112500 && nf == 52500 && t == 82500 && f == 320 && n == 164 && l == 3280) }' "$tmp/o"
}
check "the worked example to the digit" printed
check "nothing given: the same example" says T0_lb 82500 1e-4
check "R, from C.1" says R_lb 60000 1e-4 $example
check "spacing, C.2: 48 ft of influence over four bands" says spacing_ft 12 1e-9 $example gear=48ft
# 1000 ft: 50 connections, 16 kip; C.8 46 kip, C.9 82.5 kip, in the middle 64.25
check "a shorter band: least T0, C.8" says T0_least_lb 46000 1e-4 length=1000ft
check "largest T0, C.9" says T0_most_lb 82500 1e-4 length=1000ft
# K L/AE = 1 at a' = 1/4: -R 1.25/3 and +R 1.75/3; 2.25 in2 x 29e6 psi / 1000 ft = 65,250 lb/ft
check "C.6 at a quarter of the length" says ahead_lb -25000 1e-3 length=1000ft spring=65250lb/ft at=0.25
check "C.7 there" says behind_lb 35000 1e-3 length=1000ft spring=65250 at=0.25
check "in other units" says n_most 164 0 weight=2135.1463kN deceleration=4.903318m/s2 area=1451.6094mm2 \
    yield=344.73786MPa mat=711.715N row=609.6mm
holds() { $m --json bands "$@" >"$tmp/o.json"; [ $? -eq 0 ] && grep -q '"holds_by_theory":true' "$tmp/o.json"; }
fails() { timeout 600 $m bands "$@" >"$tmp/o"; [ $? -eq 1 ] && cat "$tmp/o"; }
check "theory alone: the example holds" holds
check "too long a band fails by theory" fails length=4000ft
check "so does too little tension" fails length=1000ft tension=40kip

in_newtons() { # T0 14 kip are 62275.1 N, n F' + R/2 of 24.6 kip 109426 N
    $m --si bands deceleration=0.25g length=600ft tension=14kip >"$tmp/o"
    cat "$tmp/o"
    grep -Eq 'theory: T0 62275\.1 N is below n F. \+ R/2 = [0-9.]+ N' "$tmp/o" && ! grep -E '[0-9] (lb|ft|in)( |$)' "$tmp/o"
}
check "--si: findings too" in_newtons

check "too weak" fails_with 2 "bands too weak: .*R = 60000 lb.*A fy = 18750" $m bands width=1in thickness=0.375in
check "no such input" fails_with 2 "unknown input: 'wieght'" $m bands wieght=3
check "no such unit" fails_with 2 "unknown unit: '3stone' for weight; write lb, kip, N, kN, kgf or kg" $m bands weight=3stone
check "a unit where there is none" fails_with 2 "unexpected unit" $m bands bands=4ft
check "not a number" fails_with 2 "not a number: 'x'" $m bands weight=x
check "out of range" fails_with 2 "value out of range: at is 1.5" $m bands at=1.5
check "half a section" fails_with 2 "width and thickness, or area" $m bands width=6
check "two sections" fails_with 2 "width and thickness, or area" $m bands width=6 thickness=1 area=3
check "half a row" fails_with 2 "not a whole number: every" $m bands every=2.5
check "not a word" fails_with 2 "NAME=VALUE" $m bands weight
check "an input twice" fails_with 2 "yield is given twice" $m bands yield=50ksi yield=40ksi
finish
