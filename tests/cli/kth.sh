#!/usr/bin/env bash
# One call of the system fails: write, sync, rename, open or mmap, of log, import, survey, landing --note, report, bundle and export; each call in
# turn in `make long`, three of each in `make test` (kth.py).
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
begun_landing "$tmp/base.db"
played --elf build/firmware/matrig.elf --can "file:$tmp/can" --rig tests/runs/landing4.run --for 2.2 >/dev/null 2>&1
printf '33.6\n34.0\n33.7\nn dirt\n34.2\nq\n' >"$tmp/keys"
FEW=$(take yes '') exec python3 tests/cli/kth.py "$tmp"
