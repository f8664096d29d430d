#!/usr/bin/env bash
# What make demo builds and installs is what it runs: nothing of studies, tests or browser is in its list of packages or its programs.
. "$(dirname "$0")/tap.sh"
export -n MAKEFLAGS MFLAGS MAKELEVEL
unset MAKEFLAGS MFLAGS
packages() { make -s -np npm-files | sed -n "s/^$1 := //p"; }
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
        libc6-dev | libnewlib-*) ;;
        *-dev) linked "$package" || return 1; count=$((count + 1)) ;;
        esac
    done
    echo "$count libraries"
    [ $count -ge 6 ]
}
tools() { # no library: the compiler of the firmware alone
    [ "$(printf '%s\n' $demo | grep -v -e '-dev$' | tr '\n' ' ')" = 'gcc-arm-none-eabi libnewlib-arm-none-eabi ' ]
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

# --- uPlot without npm: a page of the test's own, with an archive of its own and a curl that fetches it from a folder
page=$tmp/page
tools=$PWD/$tmp/tools
prepare() {
    local tool
    mkdir -p "$page" "$tools" "$tmp/package/dist" && cp host/live/page/fetch.sh host/live/page/package.json "$page/" && echo 'plot()' >"$tmp/package/dist/uPlot.iife.min.js" &&
        tar -czf "$tmp/archive.tgz" -C "$tmp" package && for tool in sh dirname mkdir cp sed base64 od tr rm sha512sum tar gzip; do ln -sf "$(command -v $tool)" "$tools/$tool" || return 1; done
    printf '#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done\necho "$3" >"$2.from"\n[ ! -e "%s" ] || cp "%s" "$2"\n' "$PWD/$tmp/archive.tgz" "$PWD/$tmp/archive.tgz" >"$tools/curl" && chmod +x "$tools/curl"
    sed "s|\(\"integrity\": \"sha512-\)[^\"]*|\1$(sha512_base64 "$tmp/archive.tgz")|" host/live/page/package-lock.json >"$page/package-lock.json"
}
sha512_base64() { python3 -c 'import base64, hashlib, sys; print(base64.b64encode(hashlib.sha512(open(sys.argv[1], "rb").read()).digest()).decode())' "$1"; }
fetch() { env -u npm_config_registry PATH="$tools" sh "$page/fetch.sh" "$tmp/fetched"; }
without_npm() {
    prepare && fetch && [ "$(cat "$tmp/fetched/node_modules/uplot/dist/uPlot.iife.min.js")" = 'plot()' ] &&
        grep -qx 'https://registry.npmjs.org/uplot/-/uplot-[0-9.]*.tgz' "$tmp"/fetched/uplot-*.tgz.from
}
another_archive() { # nothing of it is unpacked
    rm -rf "$tmp/fetched" && printf 'more' >>"$tmp/archive.tgz" && fails_with 2 'is not what package-lock.json names \(sha512\)' env PATH="$tools" sh "$page/fetch.sh" "$tmp/fetched" && [ ! -e "$tmp/fetched/node_modules" ]
}
no_network() {
    printf '#!/bin/sh\nexit 6\n' >"$tools/curl" && fails_with 2 'cannot fetch uPlot from https://.*; see .*/fetch.log; it needs a network once' env PATH="$tools" sh "$page/fetch.sh" "$tmp/fetched"
}

if command -v dpkg >/dev/null && dpkg -L libsqlite3-dev >/dev/null 2>&1; then
    check "each library that make demo installs is linked by a program that it runs" libraries
else
    check "each library that make demo installs is linked # SKIP the packages are not Debian's here" true
fi
check "beside libraries it installs the compiler of the firmware, and no more" tools
check "it does not build matrig-study" builds_no_study
check "make all does" all_builds_it
check "studies have their libraries in a list of their own" contains STUDY_PACKAGES libgsl-dev libsundials-dev
check "uPlot comes without npm, by its checksum" without_npm
check "another archive is refused" another_archive
check "no network is told" no_network
finish
