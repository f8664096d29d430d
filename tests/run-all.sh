#!/usr/bin/env bash
# Runs test programs and scripts that print TAP, shows what failed, and ends with "N passed, N failed".
# usage: tests/run-all.sh PROGRAM...
set -u
cd "$(dirname "$0")/.."
limit_s=300
passed=0 failed=0
mkdir -p build/test-tmp build/test-log
for program in "$@"; do
    name=${program#build/}
    log=build/test-log/$(echo "$name" | tr / -).log
    CMOCKA_MESSAGE_OUTPUT=TAP timeout -k 5 $limit_s "$program" >"$log" 2>&1
    status=$?
    ok=$(grep -c '^ok ' "$log")
    bad=$(grep -c '^not ok ' "$log")
    planned=$(sed -n 's/^1\.\.\([0-9]*\).*/\1/p' "$log" | head -n 1)
    # A program that died, or ran fewer tests than it announced, has failed at least once.
    if [ "$bad" -eq 0 ] && { [ $status -ne 0 ] || [ $((ok + bad)) -lt "${planned:-1}" ]; }; then bad=1; fi
    passed=$((passed + ok)) failed=$((failed + bad))
    if [ "$bad" -gt 0 ]; then
        echo "FAILED $name: $bad of $((ok + bad)) (exit $status); $log:"
        grep -v '^ok ' "$log" | head -n 40 | sed 's/^/    /'
    else
        echo "$name: $ok"
    fi
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
