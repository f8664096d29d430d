#!/usr/bin/env bash
# make test-linux: real Linux CAN and serial with no hardware, in a guest of its own. See README.md here.
set -u
cd "$(dirname "$0")/../.." || exit 99
dir=build/linux
load_s=${1:-20}   # how long the bus is kept full
limit_s=${2:-1200} # for each guest, from power on to power off: two minutes on a free computer
guests=${3:-links load}
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
children=()
trap 'kill "${children[@]}" 2>/dev/null; rm -rf "$sockets"' EXIT
mkdir -p $dir
die() { echo "test-linux: $*" >&2; exit 2; }

# --- the kernel: Debian's package, unpacked, not installed ---
as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi; }
kernel_name() { apt-cache depends linux-image-amd64 2>/dev/null | sed -n 's/^ *Depends: \(linux-image-[^ ]*\)$/\1/p' | head -n 1; }
download_kernel() {
    local name
    name=$(kernel_name)
    [ -n "$name" ] && (cd $dir && apt-get download "$name" >apt.log 2>&1)
}
get_kernel() {
    ls $dir/linux-image-*.deb >/dev/null 2>&1 && return
    echo "# downloading Debian's kernel package (70 MB, kept in $dir)"
    download_kernel && return
    as_root apt-get update -qq >$dir/apt.log 2>&1
    download_kernel || die "no kernel: package linux-image-amd64 cannot be downloaded; see $dir/apt.log, or put its .deb into $dir"
}

modules=(can can-raw can-dev vcan slcan sja1000 kvaser_pci virtio virtio_ring virtio_pci virtio_pci_legacy_dev virtio_pci_modern_dev
    virtio_console usb-common usbcore xhci-hcd xhci-pci usbserial ftdi_sio)
unpack_kernel() {
    local deb patterns=()
    deb=$(ls $dir/linux-image-*.deb | head -n 1)
    [ $dir/kernel/done -nt "$deb" ] && [ $dir/kernel/done -nt tests/linux/run.sh ] && return
    rm -rf $dir/kernel
    mkdir -p $dir/kernel
    for module in "${modules[@]}"; do patterns+=("*/$module.ko"); done
    dpkg-deb --fsys-tarfile "$deb" | tar -x -C $dir/kernel --wildcards './boot/vmlinuz-*' '*/modules.order' '*/modules.builtin*' \
        "${patterns[@]}" || die "cannot unpack $deb; remove it and run again"
    touch $dir/kernel/done
}

# --- what the guest runs from: programs with their libraries, as they are installed here ---
put() { # PROGRAM [NAME]
    local library
    install -D "$(command -v "$1")" "$root/usr/bin/${2:-$(basename "$1")}" || die "no $1: run make deps"
    ldd "$(command -v "$1")" | grep -o '/[^ ]*' | while read -r library; do
        [ -e "$root$library" ] || install -D "$library" "$root$library"
    done
}
make_root() {
    local program
    root=$dir/root
    rm -rf $root
    mkdir -p $root/{bin,dev,proc,sys,tmp,data,etc} $root/lib/modules
    printf '%s\n' 'root:x:0:0::/tmp:/bin/sh' 'user:x:1000:1000::/tmp:/bin/sh' >$root/etc/passwd
    cp "$(command -v busybox)" $root/bin/busybox
    export PATH=$PATH:/usr/sbin:/sbin
    for program in build/matrig build/tests/linux/bridge ip sqlite3 candump cansend cangen canplayer canbusload slcanpty slcand stm32flash; do
        put $program
    done
    cp -r $dir/kernel/lib/modules/* $root/lib/modules/
    busybox depmod -b "$PWD/$root" "$(ls $root/lib/modules)" || die "no module index: busybox depmod failed"
    cp tests/linux/{init,guest.sh,links.sh,load.sh} $root/
    build/matrig-board --elf build/firmware/matrig.elf --can "file:$root/data/landing5.can" --serial "file:$root/data/landing5.serial" \
        --rig tests/runs/landing5.run 2>$dir/board.log || die "the board does not run; see $dir/board.log"
    # an image for the boot ROM, short because the line is slow: vectors, and 8000 bytes of program
    perl -e 'srand(9); print pack("VV", 0x20001000, 0x08010001), "\x11" x 500, "\xff" x (0x10000 - 508),
        join("", map chr(int(rand(256))), 1 .. 8000)' >$root/data/small.bin
    (cd $root && find . | busybox cpio -o -H newc 2>/dev/null) >$dir/initramfs
}

# --- boards, outside ---
# A board plays the landing and goes on until it is stopped: QEMU throws away what it has not read yet when the other end
# of a socket closes. At full speed it waits for the guest.
board() { # N: which links
    local can="unix:$sockets/can$1" serial="unix:$sockets/serial$1" more=()
    local runs=(--elf build/firmware/matrig.elf --rig tests/runs/landing5.run)
    case $1 in
    4) # its boot ROM, on the 16550: what the guest's port is set to, 115200 baud 8E1, is what it insists on
        can=none serial="unix:$sockets/serial2"
        runs=(--boot0 --baud 115200 --parity even --times typical --flash "$sockets/flash") more=(--speed real) ;; # waiting, hours pass
    1) ;;                              # both links
    2) can=none ;;                     # a 16550
    3) can=none more=(--speed real) ;; # a USB port that is plugged in while the board runs
    esac
    timeout $limit_s build/matrig-board "${runs[@]}" --can "$can" --serial "$serial" --for 3600 "${more[@]}" 2>>$dir/board$1.log &
    boards[$1]=$!
    children+=($!)
}
declare -A boards

# --- the guests ---
guest() { # NAME OPTION...: runs /NAME.sh in it; its console on stdout
    local name=$1 kernel
    shift
    kernel=$(ls $dir/kernel/boot/vmlinuz-*)
    exec timeout -k 5 $limit_s qemu-system-x86_64 -accel tcg -m 384 -nodefaults -no-user-config -display none -no-reboot \
        -kernel "$kernel" -initrd $dir/initramfs -append "console=ttyS0 quiet loglevel=2 panic=-1 matrig.checks=$name matrig.load_s=$load_s" \
        -chardev stdio,id=console,signal=off -serial chardev:console \
        -object can-bus,id=bus -device kvaser_pci,canbus=bus -device kvaser_pci,canbus=bus "$@" 2>$dir/$name-qemu.log </dev/null
}
socket() { echo "socket,id=$1,path=$sockets/$1,reconnect=1"; }
links_guest() {
    guest links -chardev "$(socket serial2)" -serial chardev:serial2 \
        -device virtio-serial-pci \
        -chardev "$(socket can1)" -device virtserialport,nr=1,chardev=can1 \
        -device qemu-xhci,id=usb \
        -chardev "$(socket serial1)" -device usb-serial,bus=usb.0,port=1,chardev=serial1,serial=board,always-plugged=on \
        -chardev "$(socket serial3)" -device usb-serial,bus=usb.0,port=2,chardev=serial3,serial=plugged \
        -chardev "$(socket null1)" -device usb-serial,bus=usb.0,port=3,chardev=null1,serial=adapter,always-plugged=on \
        -chardev "$(socket null2)" -device usb-serial,bus=usb.0,port=4,chardev=null2,serial=host,always-plugged=on
}
# Time of this one is its count of instructions, one a nanosecond; nothing outside takes part.
load_guest() { guest load -icount shift=0,sleep=off; }

passed=0 failed=0 figures=()
follow() { # NAME: reads its console, does what it asks for, counts its checks
    local line seen=0 planned=0
    while IFS= read -r line; do
        line=${line%$'\r'}
        echo "$line" >&3
        case $line in
        "# host: start board "*) board "${line##* }" ;;
        "# host: stop board "*) kill "${boards[${line##* }]}" && wait "${boards[${line##* }]}" ;; # its sockets are free then
        "# figure: "*) figures+=("${line#\# figure: }") ;;
        "ok "*) passed=$((passed + 1)) seen=$((seen + 1)); echo "ok $1 ${line#ok }" ;;
        "not ok "*) failed=$((failed + 1)) seen=$((seen + 1)); echo "not ok $1 ${line#not ok }" ;;
        1..*) planned=${line#1..} ;;
        "#"*) echo "$line" ;;
        esac
    done 3>"$dir/$1.log"
    [ "$planned" -gt 0 ] && [ $seen -eq "$planned" ] && return
    failed=$((failed + 1))
    echo "not ok $1 - the guest ended before its last check (limit $limit_s s); the end of $dir/$1.log and $dir/$1-qemu.log:"
    tail -n 5 "$dir/$1.log" "$dir/$1-qemu.log" | sed 's/^/# /'
}

get_kernel
unpack_kernel
make_root
rm -f $dir/board?.log
begun_s=$SECONDS
if [[ $guests = *load* ]]; then
    load_guest >$dir/load.console &
    load=$!
    children+=($load)
fi
if [[ $guests = *links* ]]; then
    python3 tests/linux/null_modem.py "$sockets/null1" "$sockets/null2" &
    children+=($!)
    exec 4< <(links_guest)
    children+=($!)
    follow links <&4
    echo "# links: $((SECONDS - begun_s)) s"
fi
if [[ $guests = *load* ]]; then
    wait $load
    follow load <$dir/load.console
    echo "# load: $((SECONDS - begun_s)) s"
fi
printf '%s\n' "" "Linux $(basename "$(ls $dir/kernel/boot/vmlinuz-*)" | cut -c9-), guests $guests:" "${figures[@]/#/  }"
echo "$passed passed, $failed failed"
[ $failed -eq 0 ]
