#!/usr/bin/env bash
# matrig bundle: landing 5 as a campaign of its own, with its image; replayed where there is nothing but the two programs, written into like
# any campaign, and one that was changed is told.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
elf=build/firmware/matrig.elf
db=$tmp/campaign.db
bundle=$tmp/landing5.db
in_json() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.$2')"; }

record() { # the session of a day: series, survey, landing, what people say of it
    campaign_of "$db" 5 || return 1
    # a session later than the landings below: the slice must take this board's rows and no others'
    sqlite3 "$db" "insert into series(made_us, name) values(1, 'before'), (4e15, 'after');
        insert into gage_surveys(made_us, edges, error_in) values(1, 'left', 0.005), (2, 'left', 0.005), (3, 'left', 0.005), (4e15, 'left', 0.005), (5e15, 'left', 0.005);
        insert into gage_readings(survey, kind, line, place, value_in, skipped, confirmed, taken_us, source) select id, 'line', 1, 0, 33, 0, 0, 1, 'typed' from gage_surveys;
        insert into slow_log(board_uid, block, time_us) select board_uid, 1, armed_us - 60000000 from landings union all select board_uid, 2, armed_us - 90000000000 from landings union all select 'other', 1, armed_us from landings"
    $matrig --quiet compare "$db" 1 >/dev/null && $matrig --quiet landing "$db" 1 --note 'gusts from the left' >/dev/null
}
made() { $matrig bundle "$db" 1 -o "$bundle" && [ "$(ls "$tmp" | grep -c -e making -e wal)" = 0 ]; }
digests() { # by another program; the image is the file
    sqlite3 "$bundle" "select writefile('$tmp/image.elf', image) from bundles" >/dev/null && cmp "$tmp/image.elf" $elf &&
        [ "$(sqlite3 "$bundle" 'select image_sha256 from bundles')" = "$(sha256sum <$elf | cut -c 1-64)" ] &&
        [ "$(sqlite3 "$bundle" 'select record_sha256 from bundles')" = "$(sqlite3 "$db" 'select hex(record) from blocks where landing = 1 order by idx' | python3 -c 'import sys; sys.stdout.buffer.write(bytes.fromhex(sys.stdin.read()))' | sha256sum | cut -c 1-64)" ]
}
slice_has_its_own() { # first survey, the one before and the one after the landing; its series; the slow log's day before
    [ "$(sqlite3 "$bundle" "select group_concat(id) from gage_surveys")" = 1,3,4 ] && [ "$(sqlite3 "$bundle" "select count(*) from gage_readings")" = 3 ] &&
        [ "$(sqlite3 "$bundle" "select group_concat(name) from series")" = before ] && [ "$(sqlite3 "$bundle" "select count(*), min(block) from slow_log")" = '1|1' ] &&
        [ "$(sqlite3 "$bundle" "select count(*) from landing_changes")" = 1 ]
}
says_the_same() { # FILE: what replay said, as JSON
    in_json "$1" first
    [ "$(in_json "$1" differ)" = 0 ] && [ "$(in_json "$1" compared)" = exactly ] && [ "$(in_json "$1" fields)" -gt 700000 ]
}
# A root of its own: two programs, the libraries that they load, the bundle; no other process, no network, no /proc, of /dev only null.
container() {
    local root=$tmp/root library
    mkdir -p "$root/tmp" "$root/dev" && cp build/matrig build/matrig-board "$bundle" "$root/" && touch "$root/dev/null" || return 1
    for library in $(ldd build/matrig build/matrig-board | grep -o '/[^ ]*' | grep -v ':$' | sort -u); do
        mkdir -p "$root$(dirname "$library")" && cp -L "$library" "$root$library" || return 1
    done
    timeout 600 unshare --map-root-user --mount --pid --net --fork sh -c \
        'mount --bind /dev/null "$1/dev/null" && exec chroot "$1" /matrig --json --quiet replay /landing5.db' sh "$root" >"$tmp/bare.json" || return 1
    says_the_same "$tmp/bare.json"
}
is_a_campaign() { # read, written into, bundled; and all that the replay was made of is there again
    cp "$bundle" "$tmp/mine.db" && $matrig --quiet landing "$tmp/mine.db" 1 --note 'looked at' >/dev/null && $matrig compare "$tmp/mine.db" 1 >/dev/null && $matrig --quiet report "$tmp/mine.db" -o "$tmp/mine.html" && grep -q 'gusts from the left' "$tmp/mine.html" && grep -q 'looked at' "$tmp/mine.html" &&
        $matrig --quiet export "$tmp/mine.db" 1 --format candump -o "$tmp/mine.log" && cmp "$tmp/mine.log" <($matrig --quiet export "$db" 1 --format candump) &&
        $matrig --quiet bundle "$tmp/mine.db" 1 -o "$tmp/again.db" && [ "$(sqlite3 "$tmp/again.db" 'select image_sha256 from bundles')" = "$(sqlite3 "$bundle" 'select image_sha256 from bundles')" ] &&
        rows_of "$tmp/again.db" >"$tmp/again.sum" && [ -s "$tmp/again.sum" ] && rows_of "$bundle" | diff - "$tmp/again.sum"
}
rows_of() { # DB: a sum of each table's rows, but for what says when and by whom
    local table
    for table in $(sqlite3 "$1" "select name from sqlite_schema where type = 'table' and name not like 'sqlite%' and name not in ('bundles', 'landing_changes', 'simulations', 'simulation_channels') order by name"); do
        echo "$table $(sqlite3 "$1" ".mode quote" "select * from $table" | sha256sum)"
    done
}
changed() { # WHAT SQL
    cp "$bundle" "$tmp/changed.db" && sqlite3 "$tmp/changed.db" "$2" && fails_with 4 "the $1 of the bundle was changed after the bundle was written" $matrig --quiet replay "$tmp/changed.db"
}
damaged() { # cut off
    head -c 1500000 "$bundle" >"$tmp/cut.db" && ! $matrig --quiet replay "$tmp/cut.db" >"$tmp/cut.txt" 2>&1 && grep -q 'cut.db' "$tmp/cut.txt"
}
images() { # another one is refused; without the one that recorded it, a bundle has none
    fails_with 2 'a different image recorded this landing \(image [0-9a-f]{8}, commit [^)]*\): build/tests/variant/rest.elf' $matrig bundle "$db" 1 -o "$tmp/none.db" --elf build/tests/variant/rest.elf && [ ! -e "$tmp/none.db" ] || return 1
    sqlite3 "$db" ".backup $tmp/other.db" "pragma synchronous=off" && sqlite3 "$tmp/other.db" 'update landings set image_crc = 1' &&
        $matrig bundle "$tmp/other.db" 1 -o "$tmp/none.db" 2>"$tmp/err" && grep -q 'lacks the image that recorded the landing (image 00000001' "$tmp/err" && [ "$(sqlite3 "$tmp/none.db" 'select image is null or length(image) = 0 from bundles')" = 1 ]
}
check "a landing is recorded" record
check "one file, nothing beside it" made
check "SHA-256 of image and record, by another program" digests
check "what belongs to the landing and nothing else" slice_has_its_own
check "replayed where there is nothing but two programs: 0 fields differ" container
check "a bundle is a campaign: read, written into, bundled with all that it had" is_a_campaign
check "another record is told" changed record "update blocks set record = zeroblob(length(record)) where idx = (select max(idx) from blocks)"
check "another image is told" changed image "update bundles set image = cast(image as blob) || x'00'"
check "one that is cut off is no campaign" damaged
check "the image is the one that recorded the landing, or none" images
check "a bundle takes no file's place" fails_with 2 'file exists already: README.md' $matrig bundle "$db" 1 -o README.md
check "an unknown landing" fails_with 2 'no such landing: RUN 9' $matrig bundle "$db" 9 -o "$tmp/none9.db"
finish
