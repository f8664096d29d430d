#!/usr/bin/env bash
# make test-bare: `make test` where nothing is as on a developer's desk: a bare Debian 12 in a folder of its own, a user who is not
# root, a path with a space, TERM=dumb, LANG=C, TZ=Asia/Kathmandu, no network but loopback, no name resolution; BUSY=2 busy loops
# beside it. Needs root, and a network once: the Debian is kept in build/bare. The committed state is tested.
set -euo pipefail
cd "$(dirname "$0")/.."
root=$PWD/build/bare/root
place="/srv/a place with spaces"
busy=${BUSY:-0}
limit_s=${LIMIT_S:-3600}
die() { echo "test-bare: $*" >&2; exit 2; }
[ "$(id -u)" = 0 ] || die "a Debian of its own needs root; run: sudo make test-bare"

. tests/bare-root.sh

bare_root git,make,gcc,ca-certificates
with_names
rm -rf "$root$place"
git clone -q . "$root$place"
echo "# packages"
(inside the-computer root bash -c "cd '$place' && git config --global --add safe.directory '*' && make deps && chown -R tester: .") \
    >build/bare/deps.log 2>&1 || die "the packages cannot be installed; see build/bare/deps.log"

without_names
beside=()
trap 'exit 143' INT TERM
trap '[ ${#beside[@]} = 0 ] || kill "${beside[@]}" 2>/dev/null || true' EXIT
for ((i = 0; i < busy; i++)); do
    timeout "$limit_s" sh -c 'while :; do :; done' &
    beside+=($!)
done
inside none tester:tester bash -c "cd '$place' && exec make -j2 test" & # so that it ends when this ends
beside+=($!)
wait $!
