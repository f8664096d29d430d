#!/usr/bin/env bash
# What make demo builds and installs is what it runs: nothing of studies, tests or browser is in its list of packages or its programs.
. "$(dirname "$0")/tap.sh"
export -n MAKEFLAGS MFLAGS MAKELEVEL
unset MAKEFLAGS MFLAGS
packages() { make -s -np help | sed -n "s/^$1 := //p"; }
demo=$(packages DEMO_PACKAGES)

of_demo() { # the libraries that the two programs name themselves
    readelf -d build/matrig build/matrig-board | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort -u
}
linked() { # PACKAGE: of its libraries one is among them
    local file
    for file in $(dpkg -L "$1" | grep '\.so$'); do
        of_demo | grep -qxF "$(readelf -d "$file" 2>/dev/null | sed -n 's/.*(SONAME).*\[\(.*\)\]/\1/p')" && return 0
    done
    echo "make demo installs $1, and neither matrig nor matrig-board links it"
    return 1
}
libraries() {
    local package count=0
    for package in $demo; do
        case $package in
        libc6-dev) ;;
        *-dev) linked "$package" || return 1; count=$((count + 1)) ;;
        esac
    done
    echo "$count libraries"
    [ $count -ge 6 ]
}
tools() { # no library: the compiler of the firmware, the script that draws the pages' plots, what programs a board
    [ "$(printf '%s\n' $demo | grep -v -e '-dev$' | tr '\n' ' ')" = 'gcc-arm-none-eabi libjs-dygraphs ' ]
}
builds_no_study() { # all that it would do in a folder where nothing is built
    make -n B="$tmp/empty" demo >"$tmp/demo.txt" 2>&1 && grep -q ' -o .*/empty/matrig$' "$tmp/demo.txt" && ! grep -e matrig-study -e 'host/study/' -e cvode "$tmp/demo.txt"
}
all_builds_it() { make -n B="$tmp/empty" all >"$tmp/all.txt" 2>&1 && grep -q ' -o .*/empty/matrig-study$' "$tmp/all.txt"; }
contains() { # LIST PART...
    local list part
    list=" $(packages "$1") "
    shift
    for part in "$@"; do [[ $list == *" $part "* ]] || { echo "no $part in $list"; return 1; }; done
}

if command -v dpkg >/dev/null && dpkg -L libsqlite3-dev >/dev/null 2>&1; then
    check "each library that make demo installs is linked by a program that it runs" libraries
else
    check "each library that make demo installs is linked # SKIP the packages are not Debian's here" true
fi
check "beside libraries it installs the compiler of the firmware and the pages' plots, and no more" tools
check "it does not build matrig-study" builds_no_study
check "make all does" all_builds_it
check "studies have their libraries in a list of their own" contains STUDY_PACKAGES libgsl-dev libsundials-dev
finish
