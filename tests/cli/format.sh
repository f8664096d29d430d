#!/usr/bin/env bash
# The C files are laid out as .clang-format says, in 100 columns; and the checks find what is not.
. "$(dirname "$0")/tap.sh"

c_files() { find "$@" -name '*.[ch]' -not -path '*/node_modules/*'; }
is_laid_out() { ! c_files "$@" | xargs clang-format --dry-run 2>&1 | grep .; }
is_narrow() { ! c_files "$@" | LC_ALL=C.UTF-8 xargs grep -nE '^.{101}'; }
ends_lines_well() { ! grep -rnIE '[[:blank:]]$' --include='*.[ch]' --include='*.def' --include='*.sh' --include='*.py' --include='*.mk' "$@"; }
folders="common firmware hil host docs tests"

# finds CHECK TEXT: red on a file with that line
finds() {
    mkdir -p "$tmp/room" && cp .clang-format "$tmp" && printf "$2" >"$tmp/room/wall.c" && ! "$1" "$tmp/room"
}
# as an editor would ask for it
tells_how_each_is_compiled() {
    make -Bnk V=1 all 2>/dev/null | python3 tests/house/compile_commands.py "$PWD" >"$tmp/compile_commands.json" &&
        python3 - "$tmp/compile_commands.json" <<'P'
import json, subprocess, sys
told = {c['file'] for c in json.load(open(sys.argv[1]))}
there = set(subprocess.check_output(['find', 'common', 'firmware', 'hil', 'host', '-name', '*.c'], text=True).split())
missing = sorted(there - told)
print(len(told), 'told; missing:', missing)
sys.exit(bool(missing))
P
}

check "every C file is laid out" is_laid_out $folders
check "a file that is not is found" finds is_laid_out 'int  wall;\n'
check "no line of C is longer than 100 columns" is_narrow $folders
check "a comment of 101 columns is found" finds is_narrow "/* $(printf '%095d' 0) */\n"
check "no line ends in blanks" ends_lines_well Makefile packages.mk $folders
check "one that does is found" finds ends_lines_well 'int wall; \n'
check "compile_commands.json tells how every product file is compiled" tells_how_each_is_compiled
finish
