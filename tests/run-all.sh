#!/usr/bin/env bash
# Runs test programs and scripts that print TAP, as many at a time as there are processors (or TEST_JOBS), shows what failed and how
# long each took, in the order they were given, and ends with "N passed, N failed".
# usage: tests/run-all.sh PROGRAM...
set -um # -m: what runs in the background is interrupted as it would be in the foreground
cd "$(dirname "$0")/.."
limit_s=300
jobs=${TEST_JOBS:-$(nproc)}
passed=0 failed=0 reported=0
programs=("$@")
declare -A running=() # process: place in programs
began_s=() took_s=() status=()
mkdir -p build/test-tmp build/test-log
trap 'kill "${!running[@]}" 2>/dev/null; exit 130' INT TERM

name_of() { echo "${1#build/}"; }
log_of() { echo "build/test-log/$(name_of "$1" | tr / -).log"; }

start() { # PLACE
    local program=${programs[$1]} with=()
    [ "${program%.sh}" = "$program" ] || with=(bash) # whether or not the file may be executed
    (CMOCKA_MESSAGE_OUTPUT=TAP exec timeout -k 5 $limit_s "${with[@]}" "$program") >"$(log_of "$program")" 2>&1 </dev/null &
    running[$!]=$1
    began_s[$1]=$SECONDS
}

# Waits for one that ends, and keeps how.
finish() {
    local pid result place
    wait -n -p pid
    result=$?
    place=${running[$pid]}
    status[place]=$result
    took_s[place]=$((SECONDS - began_s[place]))
    unset "running[$pid]"
}

report() { # PLACE
    local name log bad ok planned seconds=${took_s[$1]} result=${status[$1]}
    name=$(name_of "${programs[$1]}") log=$(log_of "${programs[$1]}")
    ok=$(grep -c '^ok ' "$log")
    bad=$(grep -c '^not ok ' "$log")
    planned=$(sed -n 's/^1\.\.\([0-9]*\).*/\1/p' "$log" | head -n 1)
    # A program that died, or ran fewer tests than it announced, has failed at least once.
    if [ "$bad" -eq 0 ] && { [ "$result" -ne 0 ] || [ $((ok + bad)) -lt "${planned:-1}" ]; }; then bad=1; fi
    passed=$((passed + ok)) failed=$((failed + bad))
    if [ "$bad" -gt 0 ]; then
        echo "FAILED $name: $bad of $((ok + bad)) (exit $result, $seconds s); $log:"
        grep -v '^ok ' "$log" | head -n 40 | sed 's/^/    /'
    else
        printf '%-40s %4d %4d s\n' "$name:" "$ok" "$seconds"
    fi
}

report_ended() { # those whose turn it is
    while [ -n "${status[reported]:-}" ]; do
        report "$reported"
        reported=$((reported + 1))
    done
}

for place in "${!programs[@]}"; do
    if [ ${#running[@]} -ge "$jobs" ]; then
        finish
        report_ended
    fi
    start "$place"
done
while [ ${#running[@]} -gt 0 ]; do
    finish
    report_ended
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
