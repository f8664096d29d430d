#!/usr/bin/env bash
# matrig demo: three landings through board, log, comparison and report, in a folder of the user's; what it refuses, and what it leaves.
. "$(dirname "$0")/tap.sh"
root=$PWD
matrig=$root/build/matrig
work=$root/$tmp/"a folder"
mkdir -p "$work" "$tmp/temporary"
export TMPDIR=$root/$tmp/temporary
truth() { sed -n "s/^truth $2 //p" "tests/runs/landing$1.run"; }

plays() { timeout 600 env -C "$work" "$matrig" demo first >"$work/told.txt" 2>"$work/err.txt"; }
tells() {
    grep -c '^== Landing' "$work/told.txt" | grep -x 3 && tail -n 1 "$work/told.txt" | grep -Fx 'Look at first/report.html; the campaign is first/campaign.db.'
}
all_measured() { # each touchdown's speed, against the truth that its run file was made with
    local true
    true=$(for landing in 1 4 5; do truth $landing touchdown_speed_ft_s; done)
    "$matrig" --json show "$work/first/campaign.db" >"$tmp/show.json" && python3 -c 'import json, sys
said = [(l["landing"], l["touchdown_speed_ft_s"]) for l in json.load(open(sys.argv[1]))["landings"]]
print(said, sys.argv[2:])
assert [l for l, _ in said] == [1, 4, 5] and all(abs(v - float(t)) < 0.05 for (_, v), t in zip(said, sys.argv[2:], strict=True))' "$tmp/show.json" $true
}
is_warned_of() { grep -c 'warned [0-9.]* s after touchdown' "$work/told.txt" | grep -x 1; } # landing 5 alone
has_page() { grep -q '<html' "$work/first/report.html" && [ "$(wc -c <"$work/first/report.html")" -gt 100000 ]; }
no_more() { [ "$(ls -A "$work/first" | tr '\n' ' ')" = 'campaign.db report.html ' ] && [ -z "$(ls "$TMPDIR")" ]; }
refuses_another() {
    sha256sum "$work/first/campaign.db" >"$tmp/before" && fails_with 2 'there is one already: .*first/campaign\.db; name a new folder' "$matrig" demo "$work/first" &&
        sha256sum --check --status "$tmp/before"
}
with() { # PROGRAM: matrig with another matrig-board beside it, or none
    mkdir -p "$tmp/beside" && cp build/matrig "$tmp/beside/" && rm -f "$tmp/beside/matrig-board" && { [ -z "$1" ] || cp "$1" "$tmp/beside/matrig-board"; } &&
        mkdir -p "$tmp/share/matrig" && cp host/demo.sh build/firmware/matrig.elf "$tmp/share/matrig/" && cp -r tests/runs "$tmp/share/matrig/"
}
no_board() { with '' && fails_with 3 'no emulated board: .*; .*package matrig-board' "$tmp/beside/matrig" demo "$tmp/never" && [ ! -e "$tmp/never" ]; }
broken_board() { # one that ends at once: log does not wait for it without end
    printf '#!/bin/sh\necho "no board today" >&2\nexit 3\n' >"$tmp/broken" && chmod +x "$tmp/broken" && with "$tmp/broken"
    timeout 600 "$tmp/beside/matrig" demo "$tmp/none" >"$tmp/out" 2>"$tmp/err"
    echo "exit $?" | grep -x 'exit 3' && cat "$tmp/err" && grep -x 'no board today' "$tmp/err" && tail -n 1 "$tmp/err" | grep 'matrig log ended with exit code 3: matrig demo'
}
no_landings() { # the programs alone
    with build/matrig-board && rm -r "$tmp/share/matrig/runs" && fails_with 3 'no recorded landing: .*landing1\.run; .*package matrig' "$tmp/beside/matrig" demo "$tmp/none2"
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
check "it prints where to look" tells
check "each touchdown is as fast as the run file says" all_measured
check "landing 5 alone is warned of" is_warned_of
check "there is a page" has_page
check "and nothing but page and campaign" no_more
check "a campaign that is there is left alone" refuses_another
check "without an emulated board nothing begins" no_board
check "a board that ends is told" broken_board
check "landings that are not there are told" no_landings
check "interrupted, it leaves nothing running" is_interrupted
finish
