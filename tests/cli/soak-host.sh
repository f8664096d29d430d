#!/usr/bin/env bash
# 20 s (make long: a minute) of a full bus and a full serial line into one campaign, and beside it one whose queues overflow; tests/soak_host/README.md.
. "$(dirname "$0")/tap.sh"

seconds=$(take 20 60)
tests/soak_host/run.sh "$seconds" "$tmp/minute" >"$tmp/minute.txt" 2>&1 &
minute=$!
tests/soak_host/run.sh 10 "$tmp/held" 2 >"$tmp/held.txt" 2>&1 &
held=$!
of() { # PROCESS FILE
    wait "$1"
    local status=$?
    cat "$2"
    return $status
}
figures() { sed 's/^/# /' "$1"; }

check "links held up for 2 s lose what their queues do not hold, and it is reported to the frame" of $held "$tmp/held.txt"
check "100 % of 1 Mbit/s and 2 Mbaud for $seconds s: nothing lost, memory flat" of $minute "$tmp/minute.txt"
figures "$tmp/minute.txt"
figures "$tmp/held.txt"
finish
