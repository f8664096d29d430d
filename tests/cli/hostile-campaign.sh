#!/usr/bin/env bash
# Campaigns that somebody else made: a schema with programs in it, pages that lead in circles, values that no matrig writes. Every
# command ends by itself, in time, with one line that says what is foreign and where, and leaves the file as it was.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
good=$tmp/good.db
endless="WITH RECURSIVE c(n) AS (SELECT 1 UNION ALL SELECT n+1 FROM c)"

played --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --rig tests/runs/landing5.run >/dev/null 2>&1
$matrig --quiet log --can "file:$tmp/can.log" --db "$good" >/dev/null
sqlite3 "$good" "PRAGMA wal_checkpoint(TRUNCATE)" >/dev/null

# hostile NAME SQL: a copy of the campaign on which the SQL was run
hostile() {
    cp "$good" "$tmp/$1.db" && { echo ".dbconfig defensive off"; echo "$2"; } | sqlite3 -bail "$tmp/$1.db" >/dev/null
}
# refused CODE NAME PATTERN COMMAND...: ends in time with this line, and the campaign's bytes stay; DB in the command is the campaign
refused() {
    local code=$1 db=$tmp/$2.db pattern=$3 word words=() before status
    shift 3
    for word; do words+=("${word/#DB/$db}"); done
    before=$(sha256sum <"$db")
    (ulimit -v 4000000; timeout 300 "${words[@]}") >"$tmp/out" 2>"$tmp/err" </dev/null
    status=$?
    echo "exit $status; stderr:"
    cat "$tmp/err"
    [ "$status" -eq "$code" ] && [ "$(wc -l <"$tmp/err")" -eq 1 ] && grep -Eq -- "$pattern.*$db" "$tmp/err" && [ "$before" = "$(sha256sum <"$db")" ]
}

# ---- what a schema can hold: every command that opens a campaign ----

# Every reader meets the landings; the view has their columns and no end.
hostile view "ALTER TABLE landings RENAME TO landings_kept; DROP TABLE landings_kept;
    CREATE VIEW landings AS $endless SELECT n AS id, 1 AS session, 0 AS boot, 5 AS board_landing, 0 AS armed_block, 0 AS armed_us, 4 AS state,
    '' AS board_uid, '' AS firmware, 0 AS image_crc, 0 AS config_crc, 0 AS clock_source, 26.5 AS touchdown_ft, 0.0 AS switch_error_ft,
    '' AS image_commit FROM c;"
hostile trigger "$(for t in sessions landings landing_changes observations series gage_surveys gage_readings imports simulations recalibrations; do
    echo "CREATE TRIGGER on_$t BEFORE INSERT ON $t BEGIN SELECT count(*) FROM ($endless SELECT n FROM c); END;"; done)"
printf 'value,code\n0,2048\n1,2400\n' >"$tmp/points.csv"
while read -r name words; do
    # shellcheck disable=SC2086
    check "a view without end: $name" refused 4 view 'view landings' timeout 300 $matrig $words
    # shellcheck disable=SC2086
    check "triggers without end: $name" refused 4 trigger 'trigger on_' timeout 300 $matrig $words
done <<EOL
report report DB -o $tmp/none.html
export export DB 1 --format csv -o $tmp/none.csv
compare compare DB 1
fit fit DB --draws 60
replay replay DB 1
bundle bundle DB 1 -o $tmp/none.bundle
live --json live DB
landing landing DB
show show DB
show-one show DB 1
landing-note landing DB 1 --note text
survey survey DB --new
survey-show survey DB --show
log log --can file:$tmp/can.log --db DB
import import DB $tmp/can.log
EOL
check "nothing was written" test ! -e "$tmp/none.html" -a ! -e "$tmp/none.csv" -a ! -e "$tmp/none.bundle"

# ---- what else a schema can hold ----

while IFS='|' read -r what pattern sql; do
    n=$((n + 1))
    hostile "schema$n" "$sql"
    check "$what" refused 4 "schema$n" "$pattern" $matrig landing DB
done <<EOL
a view of another name|view mine|CREATE VIEW mine AS SELECT 1;
a trigger that took the name of matrig's|trigger observations_stay|DROP TRIGGER observations_stay; CREATE TRIGGER observations_stay BEFORE UPDATE ON observations BEGIN SELECT count(*) FROM ($endless SELECT n FROM c); END;
a computed column|table gaps|DROP TABLE gaps; CREATE TABLE gaps(id INTEGER PRIMARY KEY, session INTEGER, landing INTEGER, link INTEGER, message TEXT AS (hex(zeroblob(100000000))), channels TEXT, cause TEXT, count INTEGER, from_block INTEGER, to_block INTEGER);
a condition on a column|table series|DROP TABLE series; CREATE TABLE series(id INTEGER PRIMARY KEY, made_us INTEGER NOT NULL, who TEXT, name TEXT NOT NULL CHECK(length(hex(zeroblob(400000000))) > 1), runway TEXT, pattern TEXT, modification TEXT, notes TEXT);
a computed index|index slow|CREATE INDEX slow ON frames(length(hex(zeroblob(10 + id))));
a partial index|index some|CREATE INDEX some ON frames(id) WHERE length(hex(zeroblob(10))) > 0;
an index that wants rows to be unique|index only|CREATE UNIQUE INDEX only ON landing_changes(landing);
a virtual table|table edges|DROP TABLE edges; CREATE VIRTUAL TABLE edges USING fts5(landing, count, position, tick, step_codes, board_us, links);
a view disguised as a table|frames_film|PRAGMA writable_schema=ON; UPDATE sqlite_schema SET sql='CREATE VIEW frames_film AS $endless SELECT n FROM c' WHERE name='frames_film';
a trigger disguised as an index|frames_by_landing|PRAGMA writable_schema=ON; UPDATE sqlite_schema SET sql='CREATE TRIGGER frames_by_landing BEFORE INSERT ON frames BEGIN SELECT 1; END' WHERE name='frames_by_landing';
another table's text|gaps|DROP TABLE gaps; CREATE TABLE gaps(x); PRAGMA writable_schema=ON; UPDATE sqlite_schema SET sql='CREATE TABLE series(id, made_us, name)' WHERE name='gaps';
EOL
cp "$good" "$tmp/named.db" && sqlite3 "$tmp/named.db" "$(printf 'CREATE VIEW "a\n\033[31mb" AS SELECT 1')"
check "a name is told without what a terminal obeys" refused 4 named 'view a  \[31mb' $matrig landing DB

# ---- tables of other kinds ----

hostile mine 'CREATE TABLE my_notes(id INTEGER PRIMARY KEY, "what I saw" TEXT)'
check "a table of the user's own" refused 4 mine 'table my_notes' $matrig landing DB
hostile lacks "DROP TABLE readiness"
check "a table that is missing" refused 4 lacks 'no table readiness' $matrig landing DB
hostile analysed ANALYZE
check "what ANALYZE keeps is no hindrance" timeout 300 $matrig landing "$tmp/analysed.db" 1 --note text

bundle() {
    $matrig bundle "$good" 1 -o "$tmp/whole.db" && $matrig --quiet report "$tmp/whole.db" -o "$tmp/whole.html" || return 1
    cp "$tmp/whole.db" "$tmp/bundle.db"
    sqlite3 "$tmp/bundle.db" "DROP TABLE gaps; CREATE VIEW gaps AS $endless SELECT n AS id, 1 AS session, 1 AS landing, 1 AS link, '' AS message, '' AS channels,
        '' AS cause, 1 AS count, 0 AS from_block, 0 AS to_block FROM c"
    refused 4 bundle 'view gaps' $matrig report DB -o "$tmp/none.html"
}
check "a page of a bundle; of one with a view, none" bundle

# ---- pages in circles ----

# A table's pages that name each other: 500 to the fourth rows in a file of some pages. `landing`: what each row has there.
circles() { # NAME LANDING
    cp "$good" "$tmp/$1.db" && python3 - "$tmp/$1.db" "$2" <<'PYTHON'
import sqlite3, struct, sys
path, landing = sys.argv[1], int(sys.argv[2])
with sqlite3.connect(path) as db:
    db.execute("PRAGMA journal_mode=DELETE")
    size = db.execute("PRAGMA page_size").fetchone()[0]
    db.execute("DELETE FROM gaps")
    db.execute("INSERT INTO gaps VALUES(1,1,?,1,'m','c','x',1,0,0)", (landing,))
    root = db.execute("SELECT rootpage FROM sqlite_schema WHERE name='gaps'").fetchone()[0]
    db.execute("CREATE TABLE spare(x)")
    for _ in range(4):
        db.execute("INSERT INTO spare VALUES(zeroblob(?))", (size - 100,))
db.close()
with open(path, "r+b") as file:
    def page(n):
        file.seek((n - 1) * size)
        return bytearray(file.read(size))
    def put(n, data):
        file.seek((n - 1) * size)
        file.write(data)
    with sqlite3.connect(path) as db:
        spare = db.execute("SELECT rootpage FROM sqlite_schema WHERE name='spare'").fetchone()[0]
    db.close()
    count = struct.unpack(">H", page(spare)[3:5])[0]
    leaves = [struct.unpack(">I", page(spare)[struct.unpack(">H", page(spare)[12 + 2 * i:14 + 2 * i])[0]:][:4])[0] for i in range(count)]
    put(leaves[0], page(root))
    def interior(child):
        cells = (size - 12) // 8
        data = bytearray(size)
        struct.pack_into(">BHHHBI", data, 0, 5, 0, cells, size - 5 * cells, 0, child)
        for i in range(cells):
            at = size - 5 * (i + 1)
            struct.pack_into(">I", data, at, child)
            data[at + 4] = 1
            struct.pack_into(">H", data, 12 + 2 * i, at)
        return data
    put(leaves[1], interior(leaves[0]))
    put(leaves[2], interior(leaves[1]))
    put(root, interior(leaves[2]))
with sqlite3.connect(path) as db:
    db.execute("PRAGMA writable_schema=ON")
    db.execute("DELETE FROM sqlite_schema WHERE name='spare'")
db.close()
PYTHON
}
check "a table's pages are led in circles" circles endless 99
check "...a search of rows that are not there ends" refused 4 endless 'damaged|more than the file can hold' $matrig report DB -o "$tmp/none.html"
check "a table's pages are led in circles, with rows that are asked for" circles rows 1
check "...they end" refused 4 rows 'damaged|more (rows )?than the file can hold' $matrig report DB -o "$tmp/none.html"

# ---- values that no matrig writes ----

# An answer or an error, in time and in bounds.
ends() {
    (ulimit -v 4000000; timeout 60 "$@") >"$tmp/out" 2>"$tmp/err" </dev/null
    local status=$?
    echo "exit $status of $*"
    tail -n 3 "$tmp/err"
    [ $status -le 5 ]
}
survives() { # SQL
    hostile values "$1" || return 1
    ends $matrig report "$tmp/values.db" -o "$tmp/values.html" && ends $matrig export "$tmp/values.db" 1 --format csv -o "$tmp/values.csv" &&
        ends $matrig export "$tmp/values.db" 1 --format mdf4 -o "$tmp/values.mf4" && ends $matrig --json live "$tmp/values.db" &&
        ! grep -aiqE '(^|[^a-z])(inf|nan)([^a-z]|$)' "$tmp/values.csv"
}
while IFS='|' read -r what sql; do
    check "$what" survives "$sql"
done <<'EOL'
words where numbers are|UPDATE edges SET position='abc', tick='', board_us='later'; UPDATE OR IGNORE motion SET speed_ft_s='fast', block='abc'; UPDATE channels SET number='x', unit_per_code='y';
numbers without end|UPDATE edges SET board_us=9e999; UPDATE motion SET position_ft=-9e999, speed_error_ft_s=9e999; UPDATE zones SET lead_s=9e999, start_ft=-9e999; UPDATE channels SET unit_per_code=9e999; UPDATE results SET speed_ft_s=9e999;
numbers beyond all|UPDATE edges SET position=9223372036854775807, tick=-9223372036854775807; UPDATE OR IGNORE channels SET idx=9000000000000000000, band=-9000000000000000000; UPDATE zones SET mats=9223372036854775807; UPDATE events SET board_us=9223372036854775807, detail=-9223372036854775807; UPDATE landings SET armed_block=9223372036854775807, armed_us=-9223372036854775807;
bytes where numbers are, and no frame's bytes|UPDATE frames SET data=zeroblob(70000) WHERE id%100=1; UPDATE frames SET dlc=x'00ff' WHERE id%100=2; UPDATE frames SET board_us='x', can_id=-1 WHERE id%100=3; UPDATE landings SET touchdown_ft=x'00', firmware=zeroblob(70000);
EOL
longest() { # a value that takes more memory than any of matrig's
    hostile longest "UPDATE landings SET firmware=zeroblob(280000000)" && refused 4 longest 'it contains a value that is too long' $matrig landing DB && rm "$tmp/longest.db"
}
check "a value of 280 MB" longest

# ---- a file that is no campaign is none afterwards ----

foreign() { # NAME COMMAND...: refused, and its bytes and its journal's stay
    local name=$1 before
    shift
    before=$(cd "$tmp" && sha256sum "$name".db $([ ! -e "$name.db-wal" ] || echo "$name.db-wal"))
    refused 4 "$name" 'not a campaign database' "$@" && [ "$before" = "$(cd "$tmp" && sha256sum "$name".db $([ ! -e "$name.db-wal" ] || echo "$name.db-wal"))" ]
}
seq 1 2000 >"$tmp/text.db"
rm -f "$tmp/other.db" "$tmp/wal.db"
sqlite3 "$tmp/other.db" "CREATE TABLE letters(x); INSERT INTO letters VALUES(1)"
python3 - "$tmp/wal.db" <<'PYTHON' # somebody's database with changes that are still in its journal
import os, sqlite3, sys
db = sqlite3.connect(sys.argv[1])
db.execute("PRAGMA journal_mode=WAL")
db.execute("CREATE TABLE letters(x)")
db.commit()
os._exit(0)
PYTHON
for name in text other wal; do
    check "$name: refused by log" foreign $name $matrig log --can "file:$tmp/can.log" --db DB
    check "$name: refused by import" foreign $name $matrig import DB "$tmp/can.log"
    check "$name: refused by survey" foreign $name $matrig survey DB --new
    check "$name: refused by report" foreign $name $matrig report DB -o "$tmp/none.html"
done
finish
