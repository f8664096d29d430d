#!/usr/bin/env bash
# What takes more than a minute says every 30 s that it goes on, terminal or not: matrig study and matrig error; fit.sh has matrig fit.
# Their clock passes 2,000 times as fast.
. "$(dirname "$0")/tap.sh"
m=build/matrig
touch "$tmp/fast"
cat >"$tmp/short.json" <<'J'
{"name": "short", "N": 8, "bump": [0.0099, 0.02, 0.0099], "friction": "tanh", "tend": 0.008}
J
fast() { # ERRORS COMMAND...: the command on that clock
    local to=$1
    shift
    LD_PRELOAD=build/tests/link/faults.so CLOCK_RATE=$tmp/fast:2000 timeout 600 "$@" >"$tmp/out" 2>"$to"
}

error_goes_on() { fast "$tmp/error.txt" $m error "$tmp/short.json" && cat "$tmp/error.txt"; }
says() { grep -E "^matrig: $1: running for [1-9][0-9]* s: $2; $3 would be quicker$" "$tmp/$1.txt" || { cat "$tmp/$1.txt" && false; }; }
check "error: takes more than half a minute" error_goes_on
check "and says how far it is and what is quicker" says error "run [0-9]+, compared with the reference" "a smaller tend"
quiet_error() { fast "$tmp/quiet.txt" $m --quiet error "$tmp/short.json" && cat "$tmp/quiet.txt" && [ ! -s "$tmp/quiet.txt" ]; }
check "with --quiet it says nothing" quiet_error

# One runway alone: none is done until all is.
study_goes_on() { fast "$tmp/study.txt" $m study host/landing_series/series/friction.json --ground elastic --seeds 1; }
check "study: one runway" study_goes_on
check "goes on while none is done" says study "0 of 1 runways done" "fewer --seeds"
quiet_study() { fast "$tmp/quiet.txt" $m --quiet study host/landing_series/series/friction.json --ground elastic --seeds 1 && [ ! -s "$tmp/quiet.txt" ]; }
check "with --quiet it says nothing either" quiet_study
finish
