#!/usr/bin/env bash
# One version: what the changelog calls the newest is what programs say, what the image carries and the man pages bear. (tests/deb.sh
# looks at the packages.)
. "$(dirname "$0")/tap.sh"
newest() { sed -n 's/^## \([0-9]*\.[0-9]*\.[0-9]*\), .*/\1/p' "$1" | head -n 1; }
version=$(newest docs/changelog.md)

is_three_numbers() { echo "'$version'" && [[ $version =~ ^[0-9]+\.[0-9]+\.[0-9]+$ ]]; }
is_dated_or_open() { # a tag can be set, or it is said that none is
    grep -m 1 '^## ' docs/changelog.md | grep -Ex '## [0-9.]+, (20[0-9]{2}-[01][0-9]-[0-3][0-9]|not released yet)'
}
matrig_says() { build/matrig --version | grep -Fx "matrig $version" && build/matrig --json --version | grep -F "\"$version\""; }
board_says() { build/matrig-board --version | grep -Fx "matrig-board $version"; }
study_takes_it() { # and goes on to the command that it does not know
    fails_with 2 'unknown' build/matrig-study --started-by "$version" /x/matrig fit --no-such-option && ! grep 'of version' "$tmp/err"
}
study_takes_no_other() { fails_with 2 "matrig-study is version $version, but /x/matrig is version 9\.9\.9" build/matrig-study --started-by 9.9.9 /x/matrig fit; }
in_image() { # FILE: bytes 20 to 22 of the header at 0x200 (common/image.h)
    local magic numbers
    magic=$(od -An -c -j 512 -N 4 "$1" | tr -d ' ')
    numbers=$(od -An -tu1 -j 532 -N 3 "$1" | sed 's/^ *//; s/ \+/./g')
    echo "$1: $magic $numbers"
    [ "$magic $numbers" = "MRIG $version" ]
}
image_carries() { in_image build/firmware/matrig.bin && in_image build/firmware/vectors.bin; }
page_bears() { sed -n 's/^\.TH .*"\(matrig[a-z-]* [0-9.]*\)".*/\1/p' "build/$1.1" | grep -Fx "$1 $version"; }
packages_have() { sed -n '1s/^matrig (\([^)]*\)) .*/\1/p' debian/changelog | grep -Fx "$version"; }

check "the changelog begins with a version" is_three_numbers
check "which has a date, or is not released yet" is_dated_or_open
check "matrig says the same" matrig_says
check "matrig-board too" board_says
check "matrig-study takes matrig of that version" study_takes_it
check "and of no other" study_takes_no_other
check "the image carries it, in one piece and in two" image_carries
check "the man page of matrig bears it" page_bears matrig
check "that of matrig-board too" page_bears matrig-board
check "the packages' changelog begins with it" packages_have
finish
