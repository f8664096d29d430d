#!/usr/bin/env bash
# Writes golden.txt anew: its header as it is, then what the reference prints. About 15 s.
set -eu
cd "$(dirname "$0")/../.."
make --no-print-directory build/tests/sim_reference/reference >/dev/null
new=build/tests/sim_reference/golden.txt
grep '^#' tests/sim_reference/golden.txt >"$new"
build/tests/sim_reference/reference -h 2e-6 tests/sim_reference/scenes/*.json >>"$new"
mv "$new" tests/sim_reference/golden.txt
