#!/bin/sh
# fetch.sh FOLDER: uPlot of the version and the checksum in package-lock.json, into FOLDER/node_modules/uplot. By npm where there is npm;
# else the same archive by whatever fetches files: a bare Debian has apt's own helper, and npm would bring 372 packages for one file.
set -eu
page=$(dirname "$0")
mkdir -p "$1"
cp "$page/package.json" "$page/package-lock.json" "$1/"
cd "$1"
die() {
    echo "cannot fetch uPlot$1; it needs a network once" >&2
    exit 2
}
if command -v npm >/dev/null; then
    npm ci --ignore-scripts --no-audit --no-fund --omit-lockfile-registry-resolved --cache ./cache >npm.log 2>&1 || {
        grep -i err npm.log | head -n 3 >&2
        die " by npm; see $1/npm.log"
    }
    exit 0
fi

entry=$(sed -n '/"node_modules\/uplot"/,/}/p' package-lock.json)
version=$(printf '%s\n' "$entry" | sed -n 's/.*"version": "\([^"]*\)".*/\1/p')
sha512=$(printf '%s\n' "$entry" | sed -n 's/.*"integrity": "sha512-\([^"]*\)".*/\1/p' | base64 -d | od -An -v -tx1 | tr -d ' \n')
[ -n "$version" ] && [ ${#sha512} = 128 ] || die ": no version and sha512 of node_modules/uplot in $page/package-lock.json"
url=${npm_config_registry:-https://registry.npmjs.org}
url=${url%/}/uplot/-/uplot-$version.tgz
archive=uplot-$version.tgz
rm -f "$archive"
if command -v curl >/dev/null; then
    curl -fsSL --max-time 120 -o "$archive" "$url" >fetch.log 2>&1
elif command -v wget >/dev/null; then
    wget -q -T 30 -t 3 -O "$archive" "$url" >fetch.log 2>&1
else
    /usr/lib/apt/apt-helper -o Acquire::Retries=2 -o Acquire::http::Timeout=30 -o Acquire::https::Timeout=30 \
        download-file "$url" "$archive" >fetch.log 2>&1
fi || die " from $url; see $1/fetch.log"
echo "$sha512  $archive" | sha512sum --check --status || die ": $url is not what package-lock.json names (sha512)"
mkdir -p node_modules/uplot
tar -xzf "$archive" -C node_modules/uplot --strip-components=1
