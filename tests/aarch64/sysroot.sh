#!/usr/bin/env bash
# Debian's arm64 libraries, unpacked into a folder, not installed: what matrig and matrig-board are linked with for a Raspberry Pi.
#     sysroot.sh FOLDER PACKAGE...
set -euo pipefail
folder=$1
shift
die() { echo "aarch64: $*" >&2; exit 2; }
rm -rf "$folder"
mkdir -p "$folder"/apt/{state/lists/partial,cache/archives/partial}
: >"$folder/apt/status" # nothing is installed there: dependencies come along
folder=$(cd "$folder" && pwd)
apt=(apt-get -qq -o "Dir::State=$folder/apt/state" -o "Dir::State::status=$folder/apt/status" -o "Dir::Cache=$folder/apt/cache"
    -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o "APT::Sandbox::User=")
"${apt[@]}" update >"$folder/apt.log" 2>&1 || die "no list of arm64 packages; see $folder/apt.log; it needs a network once"
"${apt[@]}" install -y --no-install-recommends --download-only "$@" >>"$folder/apt.log" 2>&1 ||
    die "arm64 packages cannot be downloaded; see $folder/apt.log"
for deb in "$folder"/apt/cache/archives/*.deb; do dpkg-deb --extract "$deb" "$folder"; done
rm -rf "$folder/apt"
# Links that begin at the root would lead to this computer's libraries.
find "$folder" -type l -lname '/*' | while read -r link; do ln -snf "$folder$(readlink "$link")" "$link"; done
touch "$folder/.made"
