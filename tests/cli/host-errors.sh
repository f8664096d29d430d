#!/usr/bin/env bash
# Logs, databases and scenes that matrig refuses, and what it keeps of them; tests/cli/mistakes.txt has what is typed wrongly.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
hello='(1.000000) can0 1F0#0700000100000000'

check "nothing on the link" fails_with 3 "no hello from a board" $matrig --quiet log --can file:/dev/null --db "$tmp/empty.db"
check "nobody within --for" fails_with 3 "no hello from a board" $matrig log --serial file:/dev/null --db "$tmp/empty.db" --for 0.2
echo "this is no log" >"$tmp/foreign.log"
check "foreign candump file" fails_with 4 "foreign.log line 1" $matrig log --can "file:$tmp/foreign.log" --db "$tmp/a.db"
printf '%s\n(1.5) can0 1F1#11' "$hello" >"$tmp/short.log"
check "truncated candump file" fails_with 4 "truncated at line 2.*short.log" $matrig --quiet log --can "file:$tmp/short.log" --db "$tmp/b.db"
check "what came before the truncation is kept" test "$(sqlite3 "$tmp/b.db" 'select count(*) from frames')" = 1
head -c 4000 /dev/zero | tr '\0' 'x' >"$tmp/foreign.bin"
check "foreign serial bytes" fails_with 4 "foreign.bin" $matrig --quiet log --serial "file:$tmp/foreign.bin" --db "$tmp/c.db"
printf '(1.0) can0 123#00\n(1.0) can0 124#00\n' >"$tmp/other.log"
check "another bus" fails_with 4 "no data from a matrig board.*other.log" $matrig --quiet log --can "file:$tmp/other.log" --db "$tmp/d.db"
printf '(1.0) can0 180#0500000000000100\n(1.1) can0 1F0#0800090807000000\n(1.2) can0 1F1#1100000022000000\n' >"$tmp/layout.log"
check "board of another layout" fails_with 4 "the board uses layout 8, but this matrig uses layout 7: file:.*layout.log" \
    $matrig --quiet log --can "file:$tmp/layout.log" --db "$tmp/e.db"
check "what came before the refusal is kept" test "$(sqlite3 "$tmp/e.db" 'select count(*) from frames')" = 2

# --- databases ---
echo "$hello" >"$tmp/hello.log"
check "a board that only says hello is logged" $matrig --quiet log --can "file:$tmp/hello.log" --db "$tmp/f.db"
sqlite3 "$tmp/recipes.db" 'create table recipes(name)'
check "somebody else's database" fails_with 4 "not a campaign database: $tmp/recipes.db" $matrig log --can "file:$tmp/hello.log" --db "$tmp/recipes.db"
cp "$tmp/f.db" "$tmp/g.db"
sqlite3 "$tmp/g.db" 'pragma user_version=9'
check "database of another version, reading" fails_with 4 "version 9, written by matrig [0-9.]+; this is matrig [0-9.]+ and reads version 1: $tmp/g.db" $matrig report "$tmp/g.db"
check "database of another version, logging" fails_with 4 "version 9, written by matrig" $matrig log --can "file:$tmp/hello.log" --db "$tmp/g.db"
check "an empty campaign has a report" $matrig --quiet report "$tmp/f.db" -o "$tmp/f.html"

# --- scenes ---
echo '{"model": "chain", "Nn": 5}' >"$tmp/key.json"
check "scene with an unknown key" fails_with 4 "Nn" $matrig compare "$tmp/f.db" 1 "$tmp/key.json"

# --- help ---
check "help names every command" bash -c "for c in log sim compare report export import; do $matrig --help | grep -q \"^  \$c \" || exit 1; done"
check "every command has help" bash -c "for c in log sim compare report export import; do $matrig \$c --help | grep -q \"^Usage: matrig .* \$c\" || exit 1; done"
check "help of a command needs nothing else" $matrig log --db --help
finish
