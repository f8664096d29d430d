#!/usr/bin/env bash
# What `make fuzz` has found and what it began with, given to every parser again.
. "$(dirname "$0")/tap.sh"

for folder in tests/fuzz/corpus/*/; do
    parser=$(basename "$folder")
    check "$parser takes its corpus" build/tests/fuzz/fuzz_"$parser" "$folder"
done
finish
