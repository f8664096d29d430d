#!/usr/bin/env bash
# Campaigns of older versions at the command line: said, brought forward, and read as the matrig of their time read them.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
for v in 1 2 3; do gzip -dc tests/host/campaigns/v$v.db.gz >"$tmp/v$v.db"; done

says_the_version() {
    $matrig migrate "$tmp/v2.db" --check >"$tmp/out"
    [ $? -eq 1 ] && grep -qx "$tmp/v2.db: version 2, older than this matrig's" "$tmp/out" || return 1
    $matrig --json migrate "$tmp/v1.db" --check | grep -q '"found":1,.*"older":true' && [ ! -e "$tmp/v1.db.v1" ]
}
# The last row that `matrig export` of version 1 wrote: displacements in inches, tensions in pounds; a converter's digit is 0.0004 in and
# 0.02 lb, zeros are taken a little differently now.
reads_as_before() {
    local was=-0.00114,-0.00037,0.00242,0.00051,-0.00113,-0.00104,0.00087,0.00093,100.763,100.521,99.635,100.682,101.408,101.791,99.212,62.905,62.401,59.278,60.789,59.480,64.255,57.888
    $matrig export "$1" 1 --format csv >"$tmp/is.csv" && [ "$(grep -c '^[-0-9]' "$tmp/is.csv")" = 1404 ] &&
        tail -n 1 "$tmp/is.csv" | cut -d, -f5-26 | awk -F, -v was="$was" '{split(was, w); for (i = 1; i <= 22; i++) {
            d = $i - w[i]; if (d < 0) d = -d; if (d > (i <= 8 ? 0.0001 : 0.03)) {print i, $i, w[i]; bad = 1}}} END {exit bad || NR != 1}'
}
# Of version 3 the last row is the same to the digit; only the column of sources is new.
reads_version_3() {
    local was=0.5784185,2185,,,-0.00016,-0.00019,-0.00062,-0.00013,0.00005,0.00076,0.00246,-0.00090,100.707,100.143,99.821,100.586,101.492,101.412,99.418,62.749,62.326,59.789,60.615,59.467,64.320,57.816,0000000000000000000000
    $matrig export "$tmp/v3.db" 1 --format csv >"$tmp/is.csv" && [ "$(grep -c '^[-0-9]' "$tmp/is.csv")" = 1403 ] &&
        [ "$(tail -n 1 "$tmp/is.csv")" = "$was,SSSSSSSSSSSSSSSSSSSSSS" ]
}
version_3_too() { reads_version_3 && $matrig migrate "$tmp/v3.db" && $matrig migrate "$tmp/v3.db" --check && reads_version_3; }
one_that_writes_brings_it_forward() {
    $matrig --json log --serial "file:/dev/null" --db "$tmp/v2.db" >"$tmp/log.json" 2>"$tmp/log.err"
    grep -q "brought forward from version 2 to .*v2.db; as it was: .*v2.db.v2" "$tmp/log.err" &&
        $matrig migrate "$tmp/v2.db" --check && [ "$(sqlite3 "$tmp/v2.db.v2" 'pragma user_version')" = 2 ]
}
tables_are_added() { # of the same version: no versions are told
    cp "$tmp/v2.db" "$tmp/same.db" && sqlite3 "$tmp/same.db" 'drop table bringups' && $matrig migrate "$tmp/same.db" 2>"$tmp/err" &&
        grep -q "tables of this matrig added: .*same.db; as it was: .*same.db.v4" "$tmp/err" && ! grep -q version "$tmp/err" && $matrig migrate "$tmp/same.db" --check
}
drawn() { sed '/<section id="provenance">/q' "$1"; } # the database's version and size come after it
same_page_before_and_after() {
    $matrig report "$tmp/v1.db" -o "$tmp/before.html" && $matrig migrate "$tmp/v1.db" --no-backup && [ ! -e "$tmp/v1.db.v1" ] &&
        $matrig report "$tmp/v1.db" -o "$tmp/after.html" && cmp <(drawn "$tmp/before.html") <(drawn "$tmp/after.html")
}
newer_is_refused() {
    cp "$tmp/v1.db" "$tmp/newer.db" && sqlite3 "$tmp/newer.db" 'pragma user_version=99' || return 1
    fails_with 4 'version 99, this matrig has version' $matrig report "$tmp/newer.db" -o "$tmp/x.html" &&
        fails_with 4 'version 99' $matrig migrate "$tmp/newer.db"
}

check "--check says the version, and exit 1 that it is an older one" says_the_version
check "version 1 reads as its own matrig read it" reads_as_before "$tmp/v1.db"
check "one that writes brings it forward, and says so" one_that_writes_brings_it_forward
check "tables are added without a word of versions" tables_are_added
check "version 3 reads as its own matrig read it, before and after" version_3_too
check "the same page before and after" same_page_before_and_after
check "and then the same readings" reads_as_before "$tmp/v1.db"
check "a newer version is refused" newer_is_refused
check "silly words" fails_with 2 'either --check or --no-backup' $matrig migrate "$tmp/v1.db" --check --no-backup
finish
