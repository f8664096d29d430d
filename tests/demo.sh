#!/usr/bin/env bash
# The demo: landings 1, 4 and 5 are played to the emulated board, logged over CAN and serial by another process, compared
# with the simulation and put on a page. Leaves build/demo/campaign.db and build/demo/report.html.
set -euo pipefail
cd "$(dirname "$0")/.."
out=build/demo
rm -rf "$out"
mkdir -p "$out"
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
board=
trap '[ -z "$board" ] || kill "$board" 2>/dev/null || true; rm -rf "$sockets"' EXIT

times=()
timed() { # NAME COMMAND...
    local name=$1 begin end
    shift
    begin=$(date +%s%N)
    "$@"
    end=$(date +%s%N)
    times+=("$(printf '%-34s %7.2f s' "$name" "$(awk "BEGIN{print ($end - $begin) / 1e9}")")")
}

play() { # LANDING
    build/matrig-board --elf build/firmware/matrig.elf --can "unix:$sockets/can" --serial "unix:$sockets/serial" \
        --rig "tests/runs/landing$1.run" --speed max &
    board=$!
    build/matrig log --can "unix:$sockets/can" --serial "unix:$sockets/serial" --db "$out/campaign.db"
    wait "$board"
    board=
}

run=0
for landing in 1 4 5; do
    run=$((run + 1))
    echo "== Landing $landing of the standard series (synthetic) on the emulated board"
    timed "play and log landing $landing" play "$landing"
    timed "compare landing $landing" build/matrig compare "$out/campaign.db" "$run"
done
timed "report" build/matrig report "$out/campaign.db" -o "$out/report.html"
echo "== Run times"
printf '%s\n' "${times[@]}"
echo "Look at $out/report.html; the campaign is $out/campaign.db."
