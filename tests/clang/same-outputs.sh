#!/usr/bin/env bash
# The programs as clang builds them against those of the usual compiler: what they write is the same, byte by byte.
. "$(dirname "$0")/../cli/tap.sh"
other() { "build/clang/$1" "${@:2}"; }
. tests/agree.sh
