# A bare Debian 12 in a folder of its own, kept from one time to the next. Source it with $root, the folder, $limit_s, and a function die.

# PACKAGES: beside what Debian itself cannot be without, by commas. Once it needs a network.
bare_root() {
    [ ! -e "$root/.made" ] || return 0
    rm -rf "$root"
    mkdir -p "$root"
    echo "# a bare Debian 12: $root.log"
    debootstrap --variant=minbase --include="$1" bookworm "$root" >"$root.log" 2>&1 || die "debootstrap failed; see $root.log"
    chroot "$root" useradd --create-home --shell /bin/bash tester
    touch "$root/.made"
}

# What this computer needs to reach a network, the new one needs too: names, certificates.
with_names() {
    cp -L /etc/resolv.conf "$root/etc/resolv.conf"
    cp -L /etc/hosts "$root/etc/hosts"
    [ ! -e /etc/ssl/certs/ca-certificates.crt ] || { mkdir -p "$root/etc/ssl/certs" && cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"; }
}
without_names() { rm -f "$root/etc/resolv.conf" "$root/etc/hosts"; }

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
