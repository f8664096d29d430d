#!/usr/bin/env bash
# The blocks of commands in docs/howto/ do what they say: tests/house/blocks.py. Their campaign.db has landings 1, 4 and 5 as RUN 1 to 3.
. "$(dirname "$0")/tap.sh"
page() { python3 tests/house/blocks.py "$1" "$tmp/$(basename "$1" .md)"; }
for landing in 1 4 5; do
    build/matrig-board --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig "tests/runs/landing$landing.run" 2>/dev/null
    check "landing $landing" build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/campaign.db"
done
for file in docs/howto/*.md; do
    check "$file" page "$file"
done
finish
