#!/usr/bin/env bash
# The blocks of commands in README.md, the tutorial and the explanations do what they say: tests/house/blocks.py. docs-howto.sh has those of
# the how-to pages.
. "$(dirname "$0")/tap.sh"
page() { python3 tests/house/blocks.py "$1" "$tmp/$(basename "$1" .md)"; }
put() { printf '%s\n' '# Page' "\`\`\`$1" "${@:2}" '```' >"$tmp/page.md"; }
finds() { # PATTERN MARK LINE...: the page with this block fails, and says so
    put "${@:2}" && rm -rf "$tmp/small" && ! python3 tests/house/blocks.py "$tmp/page.md" "$tmp/small" >"$tmp/said" && cat "$tmp/said" && grep -Eq -- "$1" "$tmp/said"
}
runs_all() { put sh 'touch one' 'build/matrig --version >two' && rm -rf "$tmp/small" && python3 tests/house/blocks.py "$tmp/page.md" "$tmp/small" && [ -e "$tmp/small/one" ] && [ -s "$tmp/small/two" ]; }

# What pages call campaign.db: landing 5, three times.
campaign() {
    build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run &&
        build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/campaign.db" &&
        python3 tests/report/grow.py "$tmp/campaign.db" 3
}

check "a block that works is run" runs_all
check "a line that fails is found" finds 'failed: false' sh true false true
check "a last line that fails is found" finds 'exit 3' sh true 'build/matrig report none.db'
check "an option that matrig lacks is found where a block is not run" finds 'matrig log has no option --loud' 'sh hardware' 'build/matrig log --can can:can0 --loud'
check "a command that matrig lacks" finds 'no command lgo' 'sh network' 'build/matrig lgo'
check "a target that make lacks" finds 'no target everything' 'sh long' 'make everything # now'
check "a line that is not bash" finds 'syntax error' 'sh hardware' 'for'
check "a campaign of three landings" campaign
for file in README.md docs/*.md docs/explanation/*.md docs/measured/*.md; do
    check "$file" page "$file"
done
finish
