#!/usr/bin/env bash
# make test-deb: the packages of build/deb in a bare Debian 12, without the sources and without a network: installed, used by a user who is
# not root, removed without a trace. TWICE=1: built once more, and compared (some minutes). Needs root, and a network once: the Debian, with what the packages depend on, is kept in build/bare.
. "$(dirname "$0")/cli/tap.sh"
root=$PWD/build/bare/deb
limit_s=200
die() { echo "test-deb: $*" >&2; exit 2; }
[ "$(id -u)" = 0 ] || die "a Debian of its own needs root; run: sudo make test-deb"
. tests/bare-root.sh
mkdir -p build/bare

version=$(sed -n 's/^## \([0-9.]*\), .*/\1/p' docs/changelog.md | head -n 1)
packages="matrig matrig-board matrig-study"
deb() { echo build/deb/"$1"_*.deb; }
as_root() { (inside none root "$@"); }
as_user() { (inside none tester:tester env -C /home/tester "$@"); }
from_elsewhere() { # of a package's dependencies those that are none of ours
    dpkg-deb -f "$(deb "$1")" Depends | tr ',' '\n' | sed 's/^ *//' | grep -v '^matrig'
}

# What the packages name, and nothing else, is in the root before they are: so what they leave can be seen.
prepare() {
    local depends
    bare_root man-db
    depends=$(for package in $packages; do from_elsewhere $package; done | sort -u | paste -sd ,)
    if [ "$depends" != "$(cat "$root.depends" 2>/dev/null)" ]; then
        echo "# what they depend on: $root.apt.log"
        with_names
        (inside the-computer root bash -c "apt-get update && apt-get satisfy -y --no-install-recommends '$depends' && apt-get clean") >"$root.apt.log" 2>&1 ||
            die "what the packages depend on cannot be installed; see $root.apt.log"
        echo "$depends" >"$root.depends"
    fi
    without_names
    # what an earlier test that was ended may have left
    as_root dpkg --purge matrig-study matrig-board matrig >/dev/null 2>&1
    rm -rf "$root/home/tester" "$root/srv/debs"
    as_root install -d -o tester -g tester /home/tester || die "no bare Debian in $root"
}
# Each file: kind, mode, owner, where a link leads; and its content, but for what dpkg and man keep of their own work (the cache of man pages is another file each time).
everything() {
    (cd "$root" && find . -xdev \( -path ./proc -o -path ./dev -o -path ./tmp -o -path ./srv/debs -o -path ./var/cache/man \) -prune -o -printf '%p %y %m %U:%G %l\n' | sort
    find . -xdev -type f -not -path './var/lib/dpkg/*' -not -path './var/log/*' -not -path './var/cache/*' -not -path './srv/debs/*' -print0 | sort -z | xargs -0 sha256sum)
}
install_debs() { # PACKAGE...
    mkdir -p "$root/srv/debs" && local package files=()
    for package; do cp "$(deb "$package")" "$root/srv/debs/" && files+=("/srv/debs/$(basename "$(deb "$package")")"); done
    as_root dpkg --install "${files[@]}"
}

# --- the files themselves
are_of_the_version() {
    local package
    for package in $packages; do [ "$(dpkg-deb -f "$(deb $package)" Version)" = "$version" ] || { echo "$package is not $version"; return 1; }; done
}
is_clean() { # but for what debian/*.lintian-overrides name, each with a reason
    lintian --fail-on error,warning --no-tag-display-limit build/deb/*.changes
}
are_the_same_again() { # built once more, in another folder and without a cache of compilations
    local package path
    path=$(tr ':' '\n' <<<"$PATH" | grep -v ccache | paste -sd :)
    env PATH="$path" CCACHE_DISABLE=1 debian/build.sh "$tmp/again" || return 1
    for package in build/deb/*.deb; do cmp "$package" "$tmp/again/$(basename "$package")" || return 1; done
}
build_depends_are_ours() { # one list in packages.mk, one in debian/control
    diff <(make -s -np help | sed -n 's/^STUDY_PACKAGES := //p' | tr ' ' '\n' | grep . | sort) \
        <(sed -n '/^Build-Depends:/,/^[A-Z]/p' debian/control | grep '^ ' | tr -d ' ,' | sort)
}

# --- with the program alone
needs_the_others() {
    install_debs matrig && as_user bash -c '
        matrig demo 2>told; [ $? = 3 ] && grep "package matrig-board" told && [ ! -e matrig-demo ] || exit 1
        matrig fit x 1 2>told; [ $? = 3 ] && grep "package matrig-study" told || exit 1
        rm told; matrig sim /usr/share/matrig/scenes/friction_block.json'
}

# --- with all three
says_version() { as_user sh -c "matrig --version && matrig-board --version" | diff - <(printf 'matrig %s\nmatrig-board %s\n' "$version" "$version"); }
has_pages() {
    as_user sh -c 'MANWIDTH=80 man --warnings matrig 2>errors | grep -A 3 "^ *ready" && MANWIDTH=80 man --warnings matrig-fit 2>>errors | grep -- --prior && MANWIDTH=80 man --warnings matrig-board 2>>errors | grep -- --boot0 && ! grep . errors && rm errors'
}
plays() { # the image that comes with the board
    as_user bash -c 'matrig-board --can unix:can --serial unix:serial --rig /usr/share/matrig/runs/landing5.run &
        matrig log --can unix:can --serial unix:serial --db c.db >log.txt && wait $! && cat log.txt && grep "warned [0-9.]* s after touchdown" log.txt &&
        matrig report c.db -o c.html && grep -q "<html" c.html && matrig replay c.db 1 | tee replay.txt && rm c.db c.html log.txt replay.txt'
}
demo() { as_user bash -c 'matrig demo && [ -s matrig-demo/report.html ] && [ -s matrig-demo/campaign.db ] && rm -r matrig-demo'; }
studies() { as_user sh -c 'matrig sim /usr/share/matrig/scenes/consistent_flat.json --solver cvode | grep -i cvode'; }
parts_are_the_image() {
    local place=$root/usr/share/matrig
    cmp -n "$(stat -c %s "$place/vectors.bin")" "$place/matrig.bin" "$place/vectors.bin" && cmp --ignore-initial=65536:0 "$place/matrig.bin" "$place/program.bin"
}
flashes() { # through the emulated boot ROM
    as_user bash -c 'matrig-board --boot0 --flash flash.bin --serial pty:tty & board=$!
        for i in $(seq 500); do [ ! -e tty ] || break; sleep 0.02; done
        matrig flash pty:tty /usr/share/matrig/matrig.elf --baud 460800; status=$?; kill -INT $board; wait $board
        rm -f flash.bin tty; exit $status'
}
documentation_links() { # the root's doc folder is as the sources' for its links; LICENCES.md is a copy at another place
    python3 - "$root/usr/share/doc/matrig" <<'PYTHON'
import os, re, sys
lost = ["%s: %s" % (page, link) for folder, _, files in os.walk(sys.argv[1]) for page in files if page.endswith(".md") and page != "LICENCES.md"
        for link in re.findall(r"\]\(([^)#\s]+)", open(os.path.join(folder, page), encoding="utf-8").read())
        if not re.match("[a-z]+:", link) and not os.path.exists(os.path.join(folder, link))]
print("\n".join(lost))
sys.exit(bool(lost))
PYTHON
}
names_no_builder() { # where it was built, and whose files these are
    ! grep -rlE '/tmp/matrig-deb|/build/deb' "$root"/usr/bin/matrig* "$root/usr/libexec/matrig" "$root/usr/share/matrig" "$root"/usr/share/doc/matrig* &&
        [ -z "$(find "$root/usr/share/matrig" "$root"/usr/bin/matrig* -not -user 0)" ]
}
leaves_nothing() {
    as_root dpkg --purge matrig-study matrig-board matrig && rm -rf "$root/srv/debs" && everything >"$tmp/after" && diff "$tmp/before" "$tmp/after"
}

prepare
check "each package is of the changelog's version" are_of_the_version
check "lintian has nothing to say" is_clean
[ -z "${TWICE:-}" ] || check "two builds are the same bytes" are_the_same_again
check "they are built of what packages.mk names" build_depends_are_ours
everything >"$tmp/before"
check "the program alone says which package has what it lacks" needs_the_others
check "all three are installed" install_debs $packages
check "they say their version" says_version
check "man pages are rendered" has_pages
check "the board plays a landing, which is logged, reported and replayed" plays
check "matrig demo" demo
check "matrig-study is found" studies
check "vectors.bin and program.bin are the image's two parts" parts_are_the_image
check "the image is programmed through a boot ROM" flashes
check "links between pages hold" documentation_links
check "nothing tells where it was built" names_no_builder
check "removed, they leave nothing" leaves_nothing
finish
