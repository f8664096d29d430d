# TAP for shell tests: source it, call `check NAME COMMAND...` for each test, end with `finish`.
# Runs in the project's root; $tmp is a fresh folder under build/test-tmp. The name tap.sh is skipped by the runner.
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 99
tests=0
tmp=build/test-tmp/$(basename "$0" .sh)
rm -rf "$tmp"
mkdir -p "$tmp"

# check NAME COMMAND...: passes when the command succeeds; its output is shown when it does not.
check() {
    local name=$1
    shift
    tests=$((tests + 1))
    if "$@" >"$tmp/check.out" 2>&1; then
        echo "ok $tests - $name"
    else
        echo "not ok $tests - $name"
        tail -n 20 "$tmp/check.out" | sed 's/^/# /'
    fi
}

# fails_with CODE PATTERN COMMAND...: the command exits with CODE, says exactly one line on stderr, and it matches PATTERN.
fails_with() {
    local code=$1 pattern=$2 status
    shift 2
    timeout 600 "$@" >"$tmp/out" 2>"$tmp/err" </dev/null
    status=$?
    echo "exit $status; stderr:"
    cat "$tmp/err"
    [ "$status" -eq "$code" ] && [ "$(wc -l <"$tmp/err")" -eq 1 ] && grep -Eq -- "$pattern" "$tmp/err"
}

# take FEW ALL: how much a test takes on: ALL in `make long`, which sets MATRIG_LONG, FEW in `make test`
take() { if [ -n "${MATRIG_LONG:-}" ]; then echo "$2"; else echo "$1"; fi; }

# await COMMAND...: until it succeeds, at most five minutes: a wait that succeeds costs nothing, however busy the computer is.
await() {
    local until=$((SECONDS + 300))
    until "$@" 2>/dev/null; do [ $SECONDS -lt $until ] || return 1; sleep 0.02; done
}

# waited_us PID: how long its first thread has waited for a processor in all
waited_us() { local ran waits _; read -r ran waits _ <"/proc/$1/schedstat" && echo $((waits / 1000)); }

# with_board BOARD-OPTION... -- COMMAND...: against an emulated board whose flash, $tmp/flash, is kept; the command's exit code
with_board() {
    local board status options=()
    while [ "$1" != -- ]; do
        options+=("$1")
        shift
    done
    shift
    timeout 600 build/matrig-board --elf build/firmware/matrig.elf --flash "$tmp/flash" "${options[@]}" 2>"$tmp/board.err" &
    board=$!
    timeout 600 "$@"
    status=$?
    kill $board 2>/dev/null
    wait $board 2>/dev/null
    return $status
}

finish() { echo "1..$tests"; }
