#!/usr/bin/env bash
# The programs for 64-bit ARM, under QEMU, against this computer's: what they write is the same, byte by byte.
. "$(dirname "$0")/../cli/tap.sh"
sysroot=build/aarch64/sysroot
other() { qemu-aarch64-static -L $sysroot "build/aarch64/$1" "${@:2}"; }
of_landing_s=3 # with the warning; the whole of it takes minutes under QEMU
. tests/agree.sh
