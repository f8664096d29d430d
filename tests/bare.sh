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

# In the new root: its own mounts and processes, which end with the command.
inside() { # NETWORK USER COMMAND...: NETWORK is none or the computer's; the shell becomes it
    local network=$1 user=$2
    shift 2
    # shellcheck disable=SC2016
    exec timeout -k 5 "$limit_s" unshare --mount --pid --fork --kill-child $([ "$network" = none ] && echo --net) bash -c '
        root=$1 user=$2 network=$3; shift 3
        mount -t proc proc "$root/proc" && mount --rbind /dev "$root/dev" && mount -t tmpfs tmpfs "$root/tmp" && chmod 1777 "$root/tmp" || exit 2
        [ "$network" != none ] || ip link set lo up || exit 2
        exec chroot --userspec="$user" "$root" env -i HOME="/home/tester" PATH=/usr/sbin:/usr/bin:/sbin:/bin TERM=dumb LANG=C TZ=Asia/Kathmandu \
            NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt "$@"' bash "$root" "$user" "$network" "$@"
}

if [ ! -e "$root/.made" ]; then
    rm -rf "$root"
    mkdir -p "$root"
    echo "# a bare Debian 12: build/bare/debootstrap.log"
    debootstrap --variant=minbase --include=git,make,gcc,ca-certificates bookworm "$root" >build/bare/debootstrap.log 2>&1 ||
        die "debootstrap failed; see build/bare/debootstrap.log"
    chroot "$root" useradd --create-home --shell /bin/bash tester
    touch "$root/.made"
fi
# What this computer needs to reach a network, the new one needs too: names, certificates.
cp -L /etc/resolv.conf "$root/etc/resolv.conf"
cp -L /etc/hosts "$root/etc/hosts"
[ ! -e /etc/ssl/certs/ca-certificates.crt ] || cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
rm -rf "$root$place"
git clone -q . "$root$place"
echo "# packages, and what npm brings"
(inside the-computer root bash -c "cd '$place' && git config --global --add safe.directory '*' && make deps && make \$(make -s npm-files) && chown -R tester: .") \
    >build/bare/deps.log 2>&1 || die "the packages cannot be installed; see build/bare/deps.log"

rm -f "$root/etc/resolv.conf" "$root/etc/hosts"
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
