#!/usr/bin/env bash
# Branch coverage of common/ and of the firmware above board.h by their own tests (`make coverage`).
# usage: tests/coverage.sh DIRECTORY   of objects made with --coverage
set -eu
cd "$(dirname "$0")/.."
out=$1
least_percent=95
find "$out" -name '*.gcda' -delete
for program in "$out"/tests/common/test_* "$out"/tests/firmware/test_*; do
    [ -x "$program" ] || continue
    CMOCKA_MESSAGE_OUTPUT=TAP timeout -k 5 600 "$program" >"$out/$(basename "$program").log" 2>&1 ||
        { echo "$program failed: see $out/$(basename "$program").log" >&2; exit 1; }
done
status=0
gcovr --root . --filter common/ --filter firmware/ --exclude 'firmware/main.c' --branches --exclude-unreachable-branches \
    --fail-under-branch $least_percent --txt "$out/files.txt" --json "$out/coverage.json" \
    "$out/host/common" "$out/host/firmware" || status=$?
# Which branches nobody takes: a line for each source line that has some.
python3 - "$out/coverage.json" >"$out/branches.txt" <<'END'
import json, sys
for f in json.load(open(sys.argv[1]))["files"]:
    source = open(f["file"]).read().splitlines()
    for line in f["lines"]:
        missed = [b for b in line["branches"] if not b["count"]]
        if missed:
            print("%s:%d: %d of %d not taken: %s" % (f["file"], line["line_number"], len(missed), len(line["branches"]),
                                                   source[line["line_number"] - 1].strip()))
END
cat "$out/files.txt"
echo "$(wc -l <"$out/branches.txt") lines have branches that no test takes: $out/branches.txt"
[ $status -eq 0 ] || echo "branch coverage is below $least_percent %" >&2
exit $status
