#!/usr/bin/env bash
# The blocks of commands in docs/howto/ do what they say: tests/house/blocks.py. Their campaign.db has landing 5 three times.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
page() { python3 tests/house/blocks.py "$1" "$tmp/$(basename "$1" .md)"; }
campaign() { campaign_of "$tmp/campaign.db" 5 && python3 tests/report/grow.py "$tmp/campaign.db" 3; }
check "a campaign of three landings" campaign
for file in docs/howto/*.md; do
    check "$file" page "$file"
done
finish
