#!/usr/bin/env bash
# matrig demo: three landings through board, log, comparison and report, in a folder of the user's; what it refuses, and what it leaves.
. "$(dirname "$0")/tap.sh"
root=$PWD
matrig=$root/build/matrig
work=$root/$tmp/"a folder"
mkdir -p "$work" "$tmp/temporary"
export TMPDIR=$root/$tmp/temporary
truth() { sed -n "s/^truth $2 //p" "tests/runs/landing$1.run"; }

plays() { timeout 280 env -C "$work" "$matrig" demo first >"$work/told.txt" 2>"$work/err.txt"; }
tells() {
    grep -c '^== Landing' "$work/told.txt" | grep -x 3 && tail -n 1 "$work/told.txt" | grep -Fx 'Look at first/report.html; the campaign is first/campaign.db.' &&
        sed -n '/^== Run times/,$p' "$work/told.txt" | grep -Ec '^(play and log landing|compare landing) [145] +[0-9.]+ s$' | grep -x 6
}
all_measured() { # each touchdown's speed, against the truth that its run file was made with
    local true
    true=$(for landing in 1 4 5; do truth $landing touchdown_speed_ft_s; done)
    "$matrig" --quiet --json report "$work/first/campaign.db" -o "$tmp/again.html" >"$tmp/report.json" && python3 -c 'import json, sys
said = [(l["landing"], l["touchdown_speed_ft_s"]) for l in json.load(open(sys.argv[1]))["landings"]]
print(said, sys.argv[2:])
assert [l for l, _ in said] == [1, 4, 5] and all(abs(v - float(t)) < 0.05 for (_, v), t in zip(said, sys.argv[2:], strict=True))' "$tmp/report.json" $true
}
is_warned_of() { grep -c 'warned [0-9.]* s after touchdown' "$work/told.txt" | grep -x 1; } # landing 5 alone
has_page() { grep -q '<html' "$work/first/report.html" && [ "$(wc -c <"$work/first/report.html")" -gt 100000 ]; }
no_more() { [ "$(ls -A "$work/first" | tr '\n' ' ')" = 'campaign.db report.html ' ] && [ -z "$(ls "$TMPDIR")" ]; }
refuses_another() {
    sha256sum "$work/first/campaign.db" >"$tmp/before" && fails_with 2 'there is one already: .*first/campaign\.db; name a new folder' "$matrig" demo "$work/first" &&
        sha256sum --check --status "$tmp/before"
}
as_json() {
    timeout 280 "$matrig" --quiet --json demo "$tmp/json" >"$tmp/json.txt" 2>"$tmp/json.err" && [ ! -s "$tmp/json.err" ] || return 1
    python3 -c 'import json, sys
d = json.load(open(sys.argv[1]))
assert [(l["landing"], l["run"]) for l in d["landings"]] == [(1, 1), (4, 2), (5, 3)]
assert all(l["log"]["landings"] and l["compare"]["run"] == l["run"] and l["log_s"] > 0 for l in d["landings"])
assert d["page"] == sys.argv[2] + "/report.html" and len(d["report"]["landings"]) == 3' "$tmp/json.txt" "$tmp/json"
}
no_board() { fails_with 3 'no emulated board .*: /nowhere; .*package matrig-board' "$matrig" demo --board /nowhere "$tmp/never" && [ ! -e "$tmp/never" ]; }
broken_board() { # one that ends at once: log does not wait for it without end
    printf '#!/bin/sh\necho "no board today" >&2\nexit 3\n' >"$tmp/broken" && chmod +x "$tmp/broken"
    timeout 100 "$matrig" demo --board "$tmp/broken" "$tmp/none" >"$tmp/out" 2>"$tmp/err"
    echo "exit $?" | grep -x 'exit 3' && grep -x 'no board today' "$tmp/err" && tail -n 1 "$tmp/err" | grep 'matrig log ended with exit code 3: matrig demo'
}
no_landings() { # the programs alone
    mkdir -p "$tmp/alone" && cp build/matrig "$tmp/alone/" && env -u XDG_DATA_HOME XDG_DATA_DIRS=/nowhere HOME=/nowhere \
        "$tmp/alone/matrig" demo --board build/matrig-board --elf build/firmware/matrig.elf "$tmp/none2" 2>"$tmp/err"
    [ $? = 3 ] && grep -E 'no recorded landing \(.*\): .*landing1\.run; .*package matrig' "$tmp/err"
}
is_interrupted() { # while the board plays: programs and sockets are gone
    local demo
    "$matrig" demo "$tmp/cut" >"$tmp/out" 2>"$tmp/err" &
    demo=$!
    await compgen -G "$TMPDIR/matrig-demo.*/serial" >/dev/null || return 1
    kill -TERM $demo
    wait $demo
    [ $? = 3 ] && grep 'interrupted: matrig demo' "$tmp/err" && [ -z "$(ls "$TMPDIR")" ] && ! pgrep -f "$TMPDIR/matrig-demo"
}

check "three landings are played, logged, compared and reported" plays
check "it tells where to look, and how long each step took" tells
check "each touchdown is as fast as the run file says" all_measured
check "landing 5 alone is warned of" is_warned_of
check "there is a page" has_page
check "and nothing but page and campaign" no_more
check "a campaign that is there is left alone" refuses_another
check "one object for programs, and silence" as_json
check "without an emulated board nothing begins" no_board
check "a board that ends is told" broken_board
check "landings that are not there are told" no_landings
check "interrupted, it leaves nothing running" is_interrupted
finish
