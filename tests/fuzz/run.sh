#!/usr/bin/env bash
# Looks for inputs that break a parser: each for so many seconds, from the corpus on. What is new and covers more is kept in
# BUILD/corpus; what breaks one, in BUILD/broken. Ends with a table; exit 1 when anything broke.
# usage: tests/fuzz/run.sh BUILD SECONDS PARSER...
set -u
cd "$(dirname "$0")/../.."
build=$1 seconds=$2
shift 2
status=0
mkdir -p "$build/broken"
printf '%-10s %10s %12s %10s %8s %9s  %s\n' parser seconds inputs 'a second' edges memory result >"$build/table.txt"
for parser in "$@"; do
    mkdir -p "$build/corpus/$parser"
    "$build/tests/fuzz/fuzz_$parser" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=1024 -print_final_stats=1 -verbosity=1 \
        -artifact_prefix="$build/broken/$parser-" "$build/corpus/$parser" "tests/fuzz/corpus/$parser" >"$build/$parser.log" 2>&1
    result=$?
    [ $result -eq 0 ] || status=1
    awk -v parser="$parser" -v seconds="$seconds" -v result=$result '
        /cov: / {for (i = 1; i < NF; i++) if ($i == "cov:") edges = $(i + 1)}
        /stat::number_of_executed_units/ {inputs = $2}
        /stat::average_exec_per_sec/ {rate = $2}
        /stat::peak_rss_mb/ {memory = $2}
        END {printf "%-10s %10d %12d %10d %8d %6d MB  %s\n", parser, seconds, inputs, rate, edges, memory, result ? "BROKEN, see " parser ".log" : "none broken"}
        ' "$build/$parser.log" >>"$build/table.txt"
    tail -n 1 "$build/table.txt"
done
cat "$build/table.txt"
exit $status
