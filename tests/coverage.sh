#!/usr/bin/env bash
# Branch coverage of common/ and of the firmware above board.h by their own tests (`make coverage`): the share of branches taken,
# and each line with a branch that no test takes, with the reason that tests/uncovered.txt gives for its function. Fails below
# 95 %, and when a line has no reason.
# usage: tests/coverage.sh DIRECTORY   of objects made with --coverage
set -euo pipefail
cd "$(dirname "$0")/.."
out=$1
least_percent=95
find "$out" -name '*.gcda' -delete
for program in "$out"/tests/common/test_* "$out"/tests/common/onboard/test_* "$out"/tests/firmware/test_* "$out"/tests/host/test_*; do
    [ -f "$program" ] && [ -x "$program" ] || continue
    CMOCKA_MESSAGE_OUTPUT=TAP timeout -k 5 600 "$program" >"$out/$(basename "$program").log" 2>&1 ||
        { echo "$program failed: see $out/$(basename "$program").log" >&2; exit 1; }
done
status=0
gcovr --root . --filter common/ --filter firmware/ --exclude 'firmware/main.c' --branches --exclude-unreachable-branches \
    --fail-under-branch $least_percent --txt "$out/files.txt" --json "$out/coverage.json" \
    "$out/host/common" "$out/host/firmware" || status=$?
cat "$out/files.txt"
python3 tests/uncovered.py "$out/coverage.json" tests/uncovered.txt | tee "$out/branches.txt" || status=1
[ $status -eq 0 ] || echo "below $least_percent %, or branches without a reason: see $out/branches.txt" >&2
exit $status
