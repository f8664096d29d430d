#!/usr/bin/env bash
# Runs test programs and scripts that print TAP and ends with "N passed, N failed". Shows what failed and, as they end, of each: its checks, how
# long it took, how much processor time it and its children took. Three more at a time than there are processors (or TEST_JOBS), as several wait
# most of their time. Those first that took longest in the last run, so that no processor is idle at the end; before there was one, the scripts.
# usage: tests/run-all.sh PROGRAM...
set -um # -m: what runs in the background is interrupted as it would be in the foreground
cd "$(dirname "$0")/.."
export PATH=/usr/bin:/bin:$PATH # the packages that the tests need, whatever else of the same name this computer has
limit_s=${MATRIG_LONG:+3600} # of a program, on a computer that has much else to do
limit_s=${limit_s:-900}
jobs=${TEST_JOBS:-$(($(nproc) + 3))}
passed=0 failed=0 processor_ms=0
programs=("$@")
declare -A running=() # process: place in programs
mkdir -p build/test-tmp build/test-log
trap 'kill "${!running[@]}" 2>/dev/null; exit 130' INT TERM

name_of() { echo "${1#build/}"; }
log_of() { echo "build/test-log/$(name_of "$1" | tr / -).log"; }
times_of() { echo "build/test-log/$(name_of "$1" | tr / -).times"; } # one line: seconds in all, user, system

# Places in programs, the longest of the last run first; before all those without one, the last given, which is a script, first.
places_by_length() {
    local place times
    for place in "${!programs[@]}"; do
        times=$(times_of "${programs[$place]}")
        echo "$(if [ -s "$times" ]; then cut -d ' ' -f 1 "$times"; else echo $((limit_s + 10)); fi) $place"
    done | LC_ALL=C sort -k 1,1nr -k 2,2nr | cut -d ' ' -f 2
}

start() { # PLACE
    local program=${programs[$1]} log times with=()
    log=$(log_of "$program") times=$(times_of "$program")
    rm -f "$times"
    [ "${program%.sh}" = "$program" ] || with=(bash) # whether or not the file may be executed
    # A shell between: what it waits for is in its times.
    # shellcheck disable=SC2016
    CMOCKA_MESSAGE_OUTPUT=TAP timeout -k 5 $limit_s bash -c 'TIMEFORMAT="%R %U %S"; log=$1 times=$2; shift 2
        { time "$@" >"$log" 2>&1 </dev/null; } 2>"$times.new"
        result=$?
        tail -n 1 "$times.new" | tr , . >"$times" # some languages write 0,5
        rm -f "$times.new"
        exit $result' - "$log" "$times" "${with[@]}" "$program" &
    running[$!]=$1
}

# Waits for one that ends, and reports it.
finish() {
    local pid result place
    wait -n -p pid
    result=$?
    place=${running[$pid]}
    unset "running[$pid]"
    report "${programs[place]}" "$result"
}

milliseconds() { local s=${1/./}; echo $((10#$s)); } # of seconds with three decimals

report() { # PROGRAM EXIT-CODE
    local name log bad ok planned result=$2 took_s=$limit_s.000 user_s=0.000 system_s=0.000 ms
    name=$(name_of "$1") log=$(log_of "$1")
    ok=$(grep -c '^ok ' "$log")
    bad=$(grep -c '^not ok ' "$log")
    planned=$(sed -n 's/^1\.\.\([0-9]*\).*/\1/p' "$log" | head -n 1)
    # A program that died, or ran fewer tests than it announced, has failed at least once.
    if [ "$bad" -eq 0 ] && { [ "$result" -ne 0 ] || [ $((ok + bad)) -lt "${planned:-1}" ]; }; then bad=1; fi
    passed=$((passed + ok)) failed=$((failed + bad))
    read -r took_s user_s system_s 2>/dev/null <"$(times_of "$1")"
    ms=$(($(milliseconds "$user_s") + $(milliseconds "$system_s")))
    processor_ms=$((processor_ms + ms))
    if [ "$bad" -gt 0 ]; then
        echo "FAILED $name: $bad of $((ok + bad)) (exit $result, ${took_s%.*} s); $log:"
        grep -v '^ok ' "$log" | head -n 40 | sed 's/^/    /'
    else
        printf '%-40s %4d %4d s %6d.%d s of processor\n' "$name:" "$ok" "${took_s%.*}" $((ms / 1000)) $((ms % 1000 / 100))
    fi
}

for place in $(places_by_length); do
    [ ${#running[@]} -lt "$jobs" ] || finish
    start "$place"
done
while [ ${#running[@]} -gt 0 ]; do finish; done
printf '%-40s %4d %4d s %6d.%d s of processor\n' "all:" "$passed" "$SECONDS" $((processor_ms / 1000)) $((processor_ms % 1000 / 100))
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
