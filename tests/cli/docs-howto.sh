#!/usr/bin/env bash
# The blocks of commands in docs/howto/ do what they say: tests/house/blocks.py. Their campaign.db has landing 5 three times.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
page() { python3 tests/house/blocks.py "$1" "$tmp/$(basename "$1" .md)"; }
campaign() {
    played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run &&
        build/matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/campaign.db" &&
        python3 tests/report/grow.py "$tmp/campaign.db" 3
}
check "a campaign of three landings" campaign
for file in docs/howto/*.md; do
    check "$file" page "$file"
done
finish
