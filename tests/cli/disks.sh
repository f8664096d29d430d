#!/usr/bin/env bash
# Where a campaign lies: media that cannot be written, network drives without locks or shared memory (tests/link/faults.c), files that may not
# grow, a full disk, a terminal that goes away.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/here/c.db there=$tmp/there
mkdir "$tmp/here" "$there"
faulty=(env LD_PRELOAD=build/tests/link/faults.so)
on() { # WHAT COMMAND...: on a disk that is WHAT
    "${faulty[@]}" "PLACE=disks/there:$1" "${@:2}"
}
played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run >/dev/null 2>&1
$matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >/dev/null
cp "$db" "$there/c.db"

# What nine reading commands say, into DIR.
nine() { # DIR DB PREFIX...
    local to=$1 from=$2 n=0 command
    shift 2
    mkdir -p "$to"
    for command in "show DB" "show DB 1" "--json show DB 1" "report DB -o $to/page" "export DB 1 --format csv -o $to/csv" "export DB 1 --format mdf4 -o $to/mdf4" \
        "bundle DB 1 -o $to/bundle" "landing DB 1" "export DB 1 --format candump -o $to/candump"; do
        n=$((n + 1))
        "$@" $matrig --quiet ${command//DB/$from} >"$to/$n" 2>"$to/$n.err" || { echo "$command"; cat "$to/$n.err"; return 1; }
    done
    sed -i "s|$from|DB|g" "$to"/[0-9] "$to/csv"
    sed -i '/<dt>made</d' "$to/page"
    sqlite3 "$to/bundle" 'SELECT count(*) FROM blocks' >"$to/blocks" && rm "$to/bundle"
}
same_answers() { # WHAT
    nine "$tmp/on-$1" "$there/c.db" on "$1" && diff -r "$tmp/known" "$tmp/on-$1"
}
nine "$tmp/known" "$db" env >"$tmp/out" 2>&1 || sed 's/^/# /' "$tmp/out"
check "nine commands read what is on read-only media" same_answers read-only
check "and on a drive without locks" same_answers no-locks
check "and without shared memory" same_answers no-shared
# compare stores its result with the landing where it can.
compares() {
    local what
    $matrig compare "$db" 1 >"$tmp/compared" || return 1
    for what in read-only no-locks no-shared; do
        on $what $matrig compare "$there/c.db" 1 >"$tmp/out" 2>"$tmp/err" && cmp "$tmp/compared" "$tmp/out" &&
            grep '^matrig: the comparison was not stored: ' "$tmp/err" || { cat "$tmp/err"; return 1; }
    done
}
check "compare reads there, too, and says that it stores nothing" compares
check "and on a full one" same_answers no-quota
check "and on one that takes nothing" same_answers failing

# A snapshot of a campaign that is written to: the journal counts.
with_its_journal() {
    python3 - "$db" "$there" <<'PYTHON' || return 1
import shutil, sqlite3, sys
db = sqlite3.connect(sys.argv[1], isolation_level=None)
db.execute("PRAGMA journal_mode=WAL")
db.execute("INSERT INTO landing_changes(landing, field, value, was, made_us, who, reason) VALUES(1, 'note', 'in the journal alone', '', 1764000000000000, 'kl', '')")
for end in ("", "-wal"):
    shutil.copy(sys.argv[1] + end, sys.argv[2] + "/s.db" + end)
db.execute("CREATE TABLE foreign_one(x)")
for end in ("", "-wal"):
    shutil.copy(sys.argv[1] + end, sys.argv[2] + "/f.db" + end)
db.execute("DROP TABLE foreign_one")
PYTHON
    local what before=$(sha256sum "$there"/*.db "$there/s.db-wal")
    mkdir "$tmp/temporary"
    for what in read-only no-locks no-shared; do
        TMPDIR=$tmp/temporary on $what $matrig show "$there/s.db" 1 >"$tmp/out" 2>&1 && grep -q 'in the journal alone' "$tmp/out" || { cat "$tmp/out"; return 1; }
    done
    TMPDIR=$tmp/temporary on read-only $matrig show "$there/f.db" 2>&1 | grep 'table foreign_one' || return 1 # read aside, and refused
    [ "$(sha256sum "$there"/*.db "$there/s.db-wal")" = "$before" ] && [ -z "$(ls "$tmp/temporary")" ] && ! grep -q 'in the journal alone' "$there/c.db"
}
check "of a snapshot with a journal all is read, and nothing left behind" with_its_journal

# Said before a link is read, and nothing made.
writing_is_refused() { # WHAT WORDS
    local command
    for command in "log --can file:$tmp/can --db $there/c.db" "log --can file:$tmp/can --db $there/new.db" "import $there/c.db $tmp/can" "landing $there/c.db 1 --note x"; do
        fails_with 3 "$2" "${faulty[@]}" "PLACE=disks/there:$1" $matrig --quiet $command || return 1
    done
    [ ! -e "$there/new.db" ] && cmp "$there/c.db" "$tmp/kept.db"
}
cp "$there/c.db" "$tmp/kept.db"
check "what writes says that it is read-only, on which file system" writing_is_refused read-only 'cannot write \(Read-only file system; [a-z0-9.]+ at /'
check "that there are no locks" writing_is_refused no-locks 'a campaign needs locks, which this file system does not provide \(No locks available; [a-z0-9.]+ at /.*log to a local disk'
check "that there is no shared memory" writing_is_refused no-shared 'a campaign needs shared memory, which this file system does not provide \(No such device; [a-z0-9.]+ at /.*log to a local disk'

# What the file system said, and which one it is.
on_failing_disk() { # WHAT WORDS
    fails_with 3 "$2" "${faulty[@]}" "PLACE=disks/there:$1" $matrig --quiet landing "$there/c.db" 1 --note x && cmp "$there/c.db" "$tmp/kept.db"
}
check "an error of the disk says which one, and where" on_failing_disk failing 'cannot (read|write) \(Input/output error; [a-z0-9.]+ at /.*\): .*there/c\.db; check path, rights and disk'
check "a quota that is used up is a full disk" on_failing_disk no-quota 'cannot (read|write) \(Disk quota exceeded; [a-z0-9.]+ at /.*\): .*there/c\.db; free space on the disk'
nothing_read_is_told() { # no command takes what could not be read for what is not there
    local command
    for command in "show DB" "show DB 1" "report DB -o $tmp/none" "export DB 1 --format csv -o $tmp/none" "bundle DB 1 -o $tmp/none" "landing DB 1"; do
        fails_with 3 'cannot (read|open)[a-z ]* \(Input/output error; [a-z0-9.]+ at /.*\): .*there/c\.db; check path, rights and disk' \
            "${faulty[@]}" PLACE=disks/there:unreadable $matrig --quiet ${command//DB/$there/c.db} || return 1
    done
    [ ! -e "$tmp/none" ]
}
check "a disk that cannot be read is told by every command" nothing_read_is_told
no_bundle_on() { # WHAT WORDS
    fails_with 3 "$2" "${faulty[@]}" "PLACE=disks/there:$1" $matrig --quiet bundle "$db" 1 -o "$there/b.db" && [ -z "$(ls "$there" | grep b.db)" ]
}
no_bundle() { no_bundle_on failing 'Input/output error' && no_bundle_on no-quota 'Disk quota exceeded.*free space'; }
check "a bundle that cannot be written fails, and leaves nothing" no_bundle
limited() { # LIMIT WORDS COMMAND...: one line, or none and all is well
    local limit=$1 words=$2
    shift 2
    bash -c "ulimit -c 0 $limit; exec \"\$@\"" - $matrig --quiet "$@" >"$tmp/out" 2>"$tmp/err"
    local status=$?
    echo "$limit $*: exit $status"
    cat "$tmp/err"
    if [ -z "$words" ]; then [ $status = 0 ] && [ ! -s "$tmp/err" ]; else [ $status = 3 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && grep -Eq "$words" "$tmp/err"; fi
}
little_memory() {
    local small='stack too small: the limit is 256 kB, but matrig needs 1024 kB; run ulimit -s 1024'
    limited "-s 256" "$small" show "$db" 1 && limited "-s 256" "$small" log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/l1.db" &&
        limited "-S -s 256" '' log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/l2.db" && limited "-s 1024" '' report "$db" -o "$tmp/l.html" &&
        limited "-s 1024" '' log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/l3.db" && limited "-v 60000" '' show "$db" 1 &&
        limited "-v 60000" 'out of memory: cannot allocate [0-9]+ bytes' replay "$db" 1
}
! nm $matrig | grep -q "__[at]san_init" || little_memory() { :; } # those take memory as they like
check "a small stack, little memory: one line, or all is well" little_memory
strange_bytes_are_shown() {
    printf '\001\002 a sheet\n' >"$tmp/strange"
    fails_with 4 "not a CAN frame: file:.*strange line 1, column 1: '\?\? a sheet'" $matrig import "$tmp/new.db" "$tmp/strange" && [ ! -e "$tmp/new.db" ]
}
check "a file that is no log is shown as it reads" strange_bytes_are_shown
# The campaign is locked while a log ends: by whom is said.
the_holder_is_named() {
    cp "$tmp/kept.db" "$tmp/held.db"
    mkfifo "$tmp/held.pipe"
    $matrig --quiet log --can "file:$tmp/held.pipe" --db "$tmp/held.db" >"$tmp/out" 2>"$tmp/err" &
    local log=$! holder
    exec 7>"$tmp/held.pipe"
    await has_session "$tmp/held.db" || return 1
    python3 -c 'import signal, sqlite3, sys
sqlite3.connect(sys.argv[1], isolation_level=None).execute("BEGIN IMMEDIATE")
open(sys.argv[2], "w"); signal.pause()' "$tmp/held.db" "$tmp/held.now" &
    holder=$!
    await test -e "$tmp/held.now" || return 1
    head -n 1000 "$tmp/can" >&7
    exec 7>&-
    kill -TERM $log
    wait $log
    kill $holder
    cat "$tmp/err"
    grep -Eq "cannot (write|read) \(database is locked\): .*held\.db; process $holder, python3 has locked the campaign" "$tmp/err"
}
has_session() { [ "$(sqlite3 "$1" 'SELECT count(*) FROM sessions')" = 2 ]; }
check "who holds a campaign is named" the_holder_is_named

# Somebody has the campaign open while the log ends: all of it is in the file all the same.
no_journal_is_left() {
    cp "$tmp/kept.db" "$tmp/read.db"
    python3 - "$tmp/read.db" $matrig --quiet log --can "file:$tmp/can" --db "$tmp/read.db" <<'PYTHON'
import os, shutil, sqlite3, subprocess, sys
path, *log = sys.argv[1:]
reader = sqlite3.connect(path)
before = reader.execute("SELECT count(*) FROM frames").fetchone()[0]
subprocess.run(log, check=True, stdout=subprocess.DEVNULL)
size = os.path.getsize(path + "-wal")
shutil.copy(path, path + ".alone")
after = sqlite3.connect(path + ".alone").execute("SELECT count(*) FROM frames").fetchone()[0]
print(before, after, size)
assert size == 0 and after > before > 20000
PYTHON
}
check "a log's end leaves nothing in the journal, also beside a reader" no_journal_is_left

# --- files that may not grow ---
in_all() { # SQL: the sum over the campaign and those beside it
    local file sum=0
    for file in "$tmp"/grown*.db; do
        sum=$((sum + $(sqlite3 "$file" "$1")))
    done
    echo $sum
}
goes_on_in_another_file() {
    local known=$(sqlite3 "$tmp/kept.db" 'SELECT count(*) FROM frames') blocks=$(sqlite3 "$tmp/kept.db" 'SELECT count(*) FROM blocks')
    bash -c "ulimit -c 0 -f 1500; exec $matrig --quiet log --can file:$tmp/can --serial file:$tmp/serial --db $tmp/grown.db" >"$tmp/out" 2>"$tmp/err"
    [ $? = 3 ] && tail -n 1 "$tmp/err" | grep -Eq '\.db has reached the maximum file size \(by ulimit -f or the file system\) and keeps its data; the data logged since [0-9:]* is in .*grown-saved-' || { cat "$tmp/err"; return 1; }
    ls -l "$tmp"/grown*
    echo "frames $(in_all 'SELECT count(*) FROM frames') of $known, blocks $(in_all 'SELECT count(*) FROM blocks') of $blocks"
    [ "$(ls "$tmp"/grown*.db | wc -l)" -ge 2 ] && [ "$(in_all 'SELECT count(*) FROM frames')" = "$known" ] && [ "$(in_all 'SELECT count(*) FROM blocks')" = "$blocks" ]
}
check "a file that may not grow: the log goes on in another one, nothing is lost" goes_on_in_another_file

# --- the terminal goes away ---
frames_are() { [ "$(sqlite3 "$1" 'SELECT count(*) FROM frames' 2>/dev/null)" = "$2" ]; }
ends_by() { # SIGNAL SHELL-WORDS DB: how a log ends that gets the signal when all it was sent is in its campaign
    mkfifo "$3.pipe"
    bash -c "$2 exec $matrig --quiet log --can file:$3.pipe --db $3" >"$tmp/out" 2>&1 &
    local log=$! status
    exec 7>"$3.pipe"
    head -n 5000 "$tmp/can" >&7
    await frames_are "$3" 5000 && kill -"$1" $log || return 1
    [ "$1" != HUP ] || [ -z "$2" ] || { sed -n '5001,6000p' "$tmp/can" >&7; await frames_are "$3" 6000 && kill -TERM $log || return 1; }
    wait $log
    status=$?
    exec 7>&-
    [ $status = 0 ] && [ "$(sqlite3 "$3" 'SELECT ended_by, ended_us > started_us FROM sessions')" = 'signal|1' ] || { echo "exit $status"; cat "$tmp/out"; return 1; }
}
hangup_ends_it() { ends_by TERM '' "$tmp/term.db" && ends_by HUP '' "$tmp/hangup.db" && grep -q '^RUN 1: landing 5' "$tmp/out"; }
check "a terminal that goes away ends a log as kill does" hangup_ends_it
check "but one under nohup goes on" ends_by HUP "trap '' HUP;" "$tmp/nohup.db"
finish
