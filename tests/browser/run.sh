#!/usr/bin/env bash
# The pages in headless Chromium; pictures are left in build/browser. Ends with "N passed, N failed".
set -u
cd "$(dirname "$0")/../.."
mkdir -p build/browser
passed=0 failed=0
for test in live report picture; do
    timeout -k 5 150 python3 "tests/browser/$test.py" >"build/test-browser-$test.log" 2>&1
    status=$?
    ok=$(grep -c '^ok ' "build/test-browser-$test.log")
    bad=$(grep -c '^not ok ' "build/test-browser-$test.log")
    if [ "$status" -ne 0 ] && [ "$bad" -eq 0 ]; then bad=1; fi
    passed=$((passed + ok)) failed=$((failed + bad))
    grep '^# \(warning\|memory\)' "build/test-browser-$test.log" | sed 's/^# /    /'
    if [ "$bad" -gt 0 ]; then
        echo "FAILED browser/$test: $bad of $((ok + bad)) (exit $status); build/test-browser-$test.log:"
        grep -v '^ok ' "build/test-browser-$test.log" | head -n 60 | sed 's/^/    /'
    else
        printf '%-40s %4d\n' "browser/$test:" "$ok"
    fi
done
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
