#!/usr/bin/env bash
# Every error of matrig that a person can meet: one line that says what, where and what to do, and the exit code of the
# contract (0 ok, 1 limit, 2 usage, 3 input/output, 4 malformed input, 5 numerics).
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
hello='(1.000000) can0 1F0#0500000100000000'

# --- usage: 2 ---
check "no command" fails_with 2 "^matrig: no command.*matrig --help" $matrig
check "unknown command" fails_with 2 "unknown command: 'fly'" $matrig fly
check "unknown global option" fails_with 2 "'--fast'" $matrig --fast log
check "unknown option of a command" fails_with 2 "'--fast' of log" $matrig log --fast
check "global option after the command" fails_with 2 "put it before the command: matrig --json log" $matrig log --json
check "option without value" fails_with 2 "--db of log" $matrig log --db
check "option twice" fails_with 2 "twice: --db" $matrig log --db a --db b
check "log without a link" fails_with 2 "--can LINK or --serial LINK" $matrig log --db "$tmp/x.db"
check "log without a database" fails_with 2 "--db DB" $matrig log --can file:x
check "log with a stray word" fails_with 2 "one word too many: 'now'" $matrig log now --can file:x --db "$tmp/x.db"
check "time that is no number" fails_with 2 "'soon' for --for" $matrig log --can file:x --db "$tmp/x.db" --for soon
check "time out of range" fails_with 2 "out of range: 0 for --for" $matrig log --can file:x --db "$tmp/x.db" --for 0
check "not a link" fails_with 2 "not a link: 'tty'" $matrig log --serial tty --db "$tmp/x.db"
check "can: without such an interface, or without CAN" fails_with 3 "CAN.*can:no_such_can; " $matrig log --can can:no_such_can --db "$tmp/x.db"
check "serial: without such a port" fails_with 3 "no serial port .*serial:/dev/no-such-port; there " $matrig log --serial serial:/dev/no-such-port --db "$tmp/x.db"
check "serial: with a wrong rate" fails_with 2 "not a baud rate: .7." $matrig log --serial serial:/dev/ttyS0:7 --db "$tmp/x.db"
check "a file is no serial port" fails_with 3 "not a serial device" $matrig log --serial serial:/dev/null --db "$tmp/x.db"
check "can: carries no serial bytes" fails_with 2 "carries no serial bytes: can:can0; give it as --can" $matrig log --serial can:can0 --db "$tmp/x.db"
check "compare without RUN" fails_with 2 "compare needs DB RUN" $matrig compare x.db
check "RUN that is no number" fails_with 2 "not a RUN: 'last'" $matrig compare x.db last
check "RUN 0" fails_with 2 "not a RUN: '0'" $matrig export x.db 0 --format csv
check "export without a format" fails_with 2 "--format csv, candump, dbc, frames or mdf4" $matrig export x.db 1
check "unknown format" fails_with 2 "unknown format: 'mdf'" $matrig export x.db 1 --format mdf
check "JSON and data on one output" fails_with 2 "needs -o F" $matrig --json export x.db 1 --format csv
check "report without a database" fails_with 2 "report needs DB" $matrig report
check "a failed log leaves no database" test ! -e "$tmp/x.db"

# --- links: 3 and 4 ---
check "file that is not there" fails_with 3 "cannot open.*no/such" $matrig log --can file:no/such --db "$tmp/x.db"
check "folder as a file" fails_with 3 "directory" $matrig log --can file:build --db "$tmp/x.db"
check "socket that never appears" fails_with 3 "cannot connect.*none.socket" $matrig log --can "unix:$tmp/none.socket" --db "$tmp/x.db"
check "database in no folder" fails_with 3 "cannot open.*no/folder" $matrig log --can file:/dev/null --db "$tmp/no/folder/x.db"
check "nothing on the link" fails_with 3 "no hello from a board" $matrig log --can file:/dev/null --db "$tmp/empty.db"
check "nobody within --for" fails_with 3 "no hello from a board" $matrig log --serial file:/dev/null --db "$tmp/empty.db" --for 0.2

echo "this is no log" >"$tmp/foreign.log"
check "foreign candump file" fails_with 4 "foreign.log line 1" $matrig log --can "file:$tmp/foreign.log" --db "$tmp/a.db"
printf '%s\n(1.5) can0 1F1#11' "$hello" >"$tmp/short.log"
check "truncated candump file" fails_with 4 "short.log line 2" $matrig log --can "file:$tmp/short.log" --db "$tmp/b.db"
check "what came before the truncation is kept" test "$(sqlite3 "$tmp/b.db" 'select count(*) from frames')" = 1
head -c 4000 /dev/zero | tr '\0' 'x' >"$tmp/foreign.bin"
check "foreign serial bytes" fails_with 4 "foreign.bin" $matrig log --serial "file:$tmp/foreign.bin" --db "$tmp/c.db"
printf '(1.0) can0 123#00\n(1.0) can0 124#00\n' >"$tmp/other.log"
check "another bus" fails_with 4 "nothing of a matrig board.*other.log" $matrig log --can "file:$tmp/other.log" --db "$tmp/d.db"
printf '(1.0) can0 180#0500000000000100\n(1.1) can0 1F0#0600090807000000\n(1.2) can0 1F1#1100000022000000\n' >"$tmp/layout.log"
check "board of another layout" fails_with 4 "board speaks layout 6, this matrig layout 5: file:.*layout.log" \
    $matrig log --can "file:$tmp/layout.log" --db "$tmp/e.db"
check "what came before the refusal is kept" test "$(sqlite3 "$tmp/e.db" 'select count(*) from frames')" = 2

# --- databases ---
echo "$hello" >"$tmp/hello.log"
check "a board that only says hello is logged" $matrig --quiet log --can "file:$tmp/hello.log" --db "$tmp/f.db"
check "no such database" fails_with 3 "no such database: $tmp/none.db" $matrig report "$tmp/none.db"
check "no such landing" fails_with 2 "RUN 3 in $tmp/f.db" $matrig export "$tmp/f.db" 3 --format csv
check "no such landing to compare" fails_with 2 "RUN 3" $matrig compare "$tmp/f.db" 3
check "not a database" fails_with 4 "no campaign database.*foreign.log" $matrig report "$tmp/foreign.log"
sqlite3 "$tmp/recipes.db" 'create table recipes(name)'
check "somebody else's database" fails_with 4 "no campaign database: $tmp/recipes.db" $matrig log --can "file:$tmp/hello.log" --db "$tmp/recipes.db"
cp "$tmp/f.db" "$tmp/g.db"
sqlite3 "$tmp/g.db" 'pragma user_version=9'
check "database of another version, reading" fails_with 4 "version 9, written by matrig [0-9.]+; this is matrig [0-9.]+ and reads version 1: $tmp/g.db" $matrig report "$tmp/g.db"
check "database of another version, logging" fails_with 4 "version 9, written by matrig" $matrig log --can "file:$tmp/hello.log" --db "$tmp/g.db"
check "an empty campaign has a report" $matrig --quiet report "$tmp/f.db" -o "$tmp/f.html"
check "page that cannot be written" fails_with 3 "cannot write.*no/page.html" $matrig report "$tmp/f.db" -o "$tmp/no/page.html"
check "full output" fails_with 3 "cannot write.*/dev/full" $matrig export --format dbc -o /dev/full

# --- scenes ---
echo '{"model": "chain", "Nn": 5}' >"$tmp/key.json"
check "scene with an unknown key" fails_with 4 "Nn" $matrig compare "$tmp/f.db" 1 "$tmp/key.json"
check "scene that is not there" fails_with 3 "none.json" $matrig compare "$tmp/f.db" 1 "$tmp/none.json"

# --- help ---
check "help names every command" bash -c "for c in log sim compare report export import; do $matrig --help | grep -q \"^  \$c \" || exit 1; done"
check "every command has help" bash -c "for c in log sim compare report export import; do $matrig \$c --help | grep -q \"^usage: matrig .* \$c\" || exit 1; done"
check "help of a command needs nothing else" $matrig log --db --help
finish
