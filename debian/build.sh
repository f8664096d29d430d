#!/usr/bin/env bash
# make deb: the packages of the sources as they stand (of the files that git knows), into build/deb. They are built in a folder of their
# own, whose name has no blanks; the packages do not depend on it: those of one commit are the same bytes wherever they are built.
# usage: debian/build.sh [FOLDER]: the packages go there instead.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-build/deb}
case $out in /*) ;; *) out=$PWD/$out ;; esac
log=$out/build.log
die() { echo "deb: $*" >&2; exit 2; }
commit=$(git describe --always --dirty --abbrev=12 --exclude='*') || die "no git here: packages say from which commit they are; make them in a clone"
epoch=$(git log -1 --format=%ct)
place=$(mktemp -d /tmp/matrig-deb.XXXXXX)
trap 'rm -rf "$place"' EXIT
source=$place/matrig

mkdir -p "$source" "$out"
git ls-files -z | tar --null --create --files-from=- | tar --extract --no-same-permissions --directory="$source"
find "$source" -exec touch -h -d "@$epoch" {} +

rm -f "$out"/*.deb "$out"/*.changes "$out"/*.buildinfo
(cd "$source" && env -u MAKEFLAGS -u MFLAGS -u MAKELEVEL -u CFLAGS -u CPPFLAGS -u LDFLAGS LC_ALL=C.UTF-8 TZ=UTC COMMIT="$commit" \
    SOURCE_DATE_EPOCH="$epoch" dpkg-buildpackage --build=binary --no-sign --jobs=auto) >"$log" 2>&1 || {
    tail -n 15 "$log" >&2
    die "the packages cannot be built; see $log"
}
mv "$place"/matrig*.{deb,changes,buildinfo} "$out/"
(cd "$out" && ls -- *.deb)
