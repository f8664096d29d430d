#!/usr/bin/env bash
# The blocks of commands in README.md, the tutorial and the explanations do what they say: tests/house/blocks.py. docs-howto.sh has those of
# the how-to pages.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
page() { python3 tests/house/blocks.py "$1" "$tmp/$(basename "$1" .md)"; }
put() { printf '%s\n' '# Page' "\`\`\`$1" "${@:2}" '```' >"$tmp/page.md"; }
finds() { # PATTERN MARK LINE...: the page with this block fails, and says so
    put "${@:2}" && rm -rf "$tmp/small" && ! python3 tests/house/blocks.py "$tmp/page.md" "$tmp/small" >"$tmp/said" && cat "$tmp/said" && grep -Eq -- "$1" "$tmp/said"
}
runs_all() { put sh 'touch one' 'build/matrig --version >two' && rm -rf "$tmp/small" && python3 tests/house/blocks.py "$tmp/page.md" "$tmp/small" && [ -e "$tmp/small/one" ] && [ -s "$tmp/small/two" ]; }

campaign() { campaign_of "$tmp/campaign.db" 5 && python3 tests/report/grow.py "$tmp/campaign.db" 3; } # what pages call campaign.db

check "a block that works is run" runs_all
check "a line that fails is found" finds 'failed: false' sh true false true
check "a last line that fails is found" finds 'exit 3' sh true 'build/matrig report none.db'
check "an option that matrig lacks is found where a block is not run" finds 'matrig log has no option --loud' 'sh hardware' 'build/matrig log --can can:can0 --loud'
check "a command that matrig lacks" finds 'no command lgo' 'sh network' 'build/matrig lgo'
check "a target that make lacks" finds 'no target everything' 'sh long' 'make everything # now'
check "a line that is not bash" finds 'syntax error' 'sh hardware' 'for'
inline() { # PATTERN TEXT: a line of text with this command is found to be wrong
    printf '# Page\n\nSay `%s` to it.\n' "$2" >"$tmp/page.md" && ! python3 tests/house/blocks.py "$tmp/page.md" >"$tmp/said" && cat "$tmp/said" && grep -Eq -- "page.md:3: .*$1" "$tmp/said"
}
check "an option that matrig lacks, in a line of text" inline 'matrig report has no option --loud' 'build/matrig --json report campaign.db --loud'
check "a command that it lacks, in a line of text" inline 'no command lgo' 'matrig lgo'
check "a target that make lacks, in a line of text" inline 'no target everything' 'make everything'
mapfile -t readmes < <(find common docs firmware hil host tests -name README.md -not -path '*/.*')
check "commands in the text of the folders' READMEs" python3 tests/house/blocks.py --look "${readmes[@]}"
check "a campaign of three landings" campaign
for file in README.md docs/*.md docs/explanation/*.md docs/measured/*.md; do
    check "$file" page "$file"
done
# What README.md and the tutorial leave in the folder of the sources is nothing that git would take up.
left_is_ignored() { # PAGE
    git rev-parse --is-inside-work-tree >/dev/null 2>&1 || return 0
    find "$tmp/$1" -mindepth 1 -maxdepth 1 -not -type l -not -name said.txt -printf '%f\n' | sort >"$tmp/left"
    [ -s "$tmp/left" ] && ! git check-ignore --no-index --verbose --non-matching --stdin <"$tmp/left" | grep '^::'
}
check "git ignores what README.md leaves" left_is_ignored README
check "git ignores what the tutorial leaves" left_is_ignored tutorial
finish
