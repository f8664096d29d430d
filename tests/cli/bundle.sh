#!/usr/bin/env bash
# matrig bundle and matrig replay BUNDLE: landing 5 in one file, its digests done again by another program, replayed where there is
# nothing but the two programs; cut off, changed and hostile ones are told, and nothing is written where it should not be.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
elf=build/firmware/matrig.elf
db=$tmp/campaign.db
bundle=$tmp/landing5.bundle
other() { python3 tests/cli/bundle_check.py "$@"; }
in_json() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.$2')"; }

record() { # the session of a day: series, survey, landing, what people say of it
    played --elf $elf --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --rig tests/runs/landing5.run 2>"$tmp/board.err" &&
        $matrig --quiet log --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$db" >"$tmp/log.txt" || return 1
    # a session later than the landings below: the slice must take this board's rows and no others'
    sqlite3 "$db" "insert into series(made_us, name) values(1, 'before'), (4e15, 'after');
        insert into gage_surveys(made_us, pattern, edges, error_in) values(1, 'standard', 'left', 0.005), (2, 'standard', 'left', 0.005), (3, 'standard', 'left', 0.005), (4e15, 'standard', 'left', 0.005), (5e15, 'standard', 'left', 0.005);
        insert into gage_readings(survey, kind, line, place, value_in, skipped, confirmed, taken_us, source) select id, 'line', 1, 0, 33, 0, 0, 1, 'typed' from gage_surveys;
        insert into slow_log(board_uid, seq, boot, block, time_us) select board_uid, 1, 0, 0, armed_us - 60000000 from landings union all select board_uid, 2, 0, 0, armed_us - 90000000000 from landings union all select 'other', 1, 0, 0, armed_us from landings"
    $matrig --quiet compare "$db" 1 >/dev/null && $matrig --quiet landing "$db" 1 --note 'gusts from the left' >/dev/null
}
made() {
    $matrig bundle "$db" 1 -o "$bundle" && [ "$(stat -c %s "$bundle")" -lt 10000000 ] && [ "$(ls "$tmp" | grep -c -e making -e slice -e wal)" = 0 ]
}
archive() { # by another reader of the layout, and what is in it is what matrig makes
    mkdir -p "$tmp/unpacked" && sqlite3 "$bundle" -A --list | sort >"$tmp/names.txt" && (cd "$tmp/unpacked" && sqlite3 ../landing5.bundle -A --extract) &&
        cmp "$tmp/unpacked/firmware.elf" $elf && $matrig --quiet export "$db" 1 --format candump -o "$tmp/export.log" && cmp "$tmp/export.log" "$tmp/unpacked/can.log" &&
        [ "$(tr '\n' ' ' <"$tmp/names.txt")" = 'can.log firmware.elf report.html scene.json ' ] && grep -q 'gusts from the left' "$tmp/unpacked/report.html" &&
        [ "$(sqlite3 "$bundle" 'select scene from simulations')" = "$(cat "$tmp/unpacked/scene.json")" ]
}
slice_has_its_own() { # first survey, the one before and the one after the landing; its series; the slow log's day before
    [ "$(sqlite3 "$bundle" "select group_concat(id) from gage_surveys")" = 1,3,4 ] && [ "$(sqlite3 "$bundle" "select count(*) from gage_readings")" = 3 ] &&
        [ "$(sqlite3 "$bundle" "select group_concat(name) from series")" = before ] && [ "$(sqlite3 "$bundle" "select count(*), min(seq) from slow_log")" = '1|1' ] &&
        [ "$(sqlite3 "$bundle" "select count(*) from landing_changes")" = 1 ]
}
says_the_same() { # FILE: what replay said, as JSON
    in_json "$1" first
    [ "$(in_json "$1" differ)" = 0 ] && [ "$(in_json "$1" compared)" = exactly ] && [ "$(in_json "$1" fields)" -gt 700000 ] && [ "$(in_json "$1" bundle.complete)" = 1 ]
}
replays() { $matrig --json --quiet replay "$bundle" >"$tmp/replay.json" && says_the_same "$tmp/replay.json"; }

# A root of its own: two programs, the libraries that they load, the bundle; no other process, no network, no /proc, of /dev only null.
container() {
    local root=$tmp/root library
    mkdir -p "$root/tmp" "$root/dev" && cp build/matrig build/matrig-board "$bundle" "$root/" && touch "$root/dev/null" || return 1
    for library in $(ldd build/matrig build/matrig-board | grep -o '/[^ ]*' | grep -v ':$' | sort -u); do
        mkdir -p "$root$(dirname "$library")" && cp -L "$library" "$root$library" || return 1
    done
    (cd "$root" && find . -type f | sort) >"$tmp/root.txt"
    timeout 120 unshare --map-root-user --mount --pid --net --fork sh -c \
        'mount --bind /dev/null "$1/dev/null" && exec chroot "$1" /matrig --json --quiet replay /landing5.bundle' sh "$root" >"$tmp/bare.json" || return 1
    [ "$(grep -v -e '^\./lib' -e '^\./usr/lib' "$tmp/root.txt" | tr '\n' ' ')" = './dev/null ./landing5.bundle ./matrig ./matrig-board ' ] && says_the_same "$tmp/bare.json"
}

verdict() { # FILE PATTERN: exit 4, and a line that matches
    timeout 60 $matrig replay "$1" --verify >"$tmp/verdict.txt" 2>"$tmp/verdict.err"
    local status=$?
    cat "$tmp/verdict.txt" "$tmp/verdict.err"
    [ $status = 4 ] && grep -Eq -- "$2" "$tmp/verdict.txt" "$tmp/verdict.err"
}
# A smaller one to be damaged in many ways: one reading in twenty, and all files.
kinds="within:sqlar:data within:blocks:record row hash gone trigger table empty many parent absolute extra nul long symlink claims less bomb huge view computed"
damage_it() {
    sqlite3 "$db" ".backup $tmp/short.db" "pragma synchronous=off" && mkdir -p "$tmp/damaged" &&
        sqlite3 "$tmp/short.db" 'pragma synchronous=off; delete from frames where id % 20; delete from blocks where idx % 20' >/dev/null &&
        $matrig --quiet bundle "$tmp/short.db" 1 -o "$tmp/short.bundle" && other "$tmp/short.bundle" "$tmp/damaged" $kinds $(any_places)
}
any_places() { # ten bytes, wherever they are
    local i size
    size=$(stat -c %s "$tmp/short.bundle")
    for i in $(seq 10); do echo "flip:$((i * 2654435761 % size))"; done
}
damaged() { # KIND PATTERN
    verdict "$tmp/damaged/$1" "$2"
}
only() { damaged "$1" "changed since it was made: $2; [0-9]+ of [0-9]+ parts are whole"; }
any_byte() {
    local file count=0
    for file in "$tmp"/damaged/flip:*; do
        verdict "$file" . || { echo "$file"; return 1; }
        count=$((count + 1))
    done
    [ $count = 10 ]
}
cut_off() {
    head -c 1500000 "$bundle" >"$tmp/cut" && mkdir -p "$tmp/saved" && ! $matrig --quiet replay "$tmp/cut" --save "$tmp/saved" >"$tmp/cut.txt" 2>"$tmp/cut.err" &&
        grep -q 'truncated at byte 1500000 of' "$tmp/cut.err" && cmp "$tmp/saved/can.log" "$tmp/unpacked/can.log" && cmp "$tmp/saved/report.html" "$tmp/unpacked/report.html" &&
        grep -q 'can.log .*saved' "$tmp/cut.txt" && verdict "$tmp/cut" 'frames  *lost: ' && head -c 3000 "$bundle" >"$tmp/cut" && verdict "$tmp/cut" 'before anything that could be saved'
}
saves_only_what_is_whole() {
    mkdir -p "$tmp/part" && fails_with 4 'changed since it was made: firmware.elf;' $matrig replay "$tmp/damaged/within:sqlar:data" --save "$tmp/part" &&
        [ "$(ls "$tmp/part" | tr '\n' ' ')" = 'can.log report.html scene.json ' ] && echo >>"$tmp/part/report.html" && fails_with 2 "is there already, .*part/report.html" $matrig replay "$tmp/damaged/within:sqlar:data" --save "$tmp/part"
}
nothing_escapes() { # KIND PATTERN: not one file but of bundle's own names, in the folder
    rm -rf "$tmp/cage" && mkdir -p "$tmp/cage/in" && damaged "$1" "$2" && ! timeout 60 $matrig --quiet replay "$tmp/damaged/$1" --save "$tmp/cage/in" >/dev/null 2>&1 &&
        (cd "$tmp/cage" && [ -z "$(find . -type f | grep -Ev '^./in/(report.html|can.log|scene.json|firmware.elf)$')" ] && [ -z "$(find . -type l)" ]) && [ ! -e /tmp/matrig-escaped ]
}
opened_for_writing() { # its parts are whole, so it can be replayed, but it is no more as it was sealed
    cp "$tmp/short.bundle" "$tmp/opened" && sqlite3 "$tmp/opened" 'pragma journal_mode=wal; pragma user_version=3' >/dev/null &&
        verdict "$tmp/opened" 'between its parts: all [0-9]+ of them are whole' &&
        ! $matrig --json --quiet replay "$tmp/opened" --verify >"$tmp/opened.json" 2>/dev/null && [ "$(in_json "$tmp/opened.json" sound)$(in_json "$tmp/opened.json" complete)" = 10 ]
}
another_image_is_refused() {
    fails_with 2 'not the image that recorded it \(image [0-9a-f]{8}, commit [^)]*\): build/tests/variant/rest.elf is image [0-9a-f]{8}, commit .*--without firmware' \
        $matrig bundle "$db" 1 -o "$tmp/none" --elf build/tests/variant/rest.elf && [ ! -e "$tmp/none" ] &&
        $matrig --quiet bundle "$db" 1 -o "$tmp/none" --elf build/tests/variant/rest.elf --without firmware,page && [ "$(sqlite3 "$tmp/none" -A --list | sort | tr '\n' ' ')" = 'can.log scene.json ' ]
}
too_long() { # what cannot be packed: a scene with a long remark of noise
    { echo '{"_noise":'; head -c 11250000 /dev/urandom | base64 -w 0 | sed 's/^/"/; s/$/",/'; sed 1d host/scenes/model_runway.json; } >"$tmp/long.json"
    cp "$tmp/short.db" "$tmp/long.db" && sqlite3 "$tmp/long.db" 'delete from simulation_channels; delete from simulations' &&
        fails_with 4 "bytes, a bundle has at most 10000000: .*; its largest part is scene.json with [0-9]{8} bytes: leave it out with --without scene" \
            $matrig bundle "$tmp/long.db" 1 -o "$tmp/none2" --scene "$tmp/long.json" && [ ! -e "$tmp/none2" ] && rm "$tmp/long.json"
}
without_a_page() { # a landing of which none can be made is what somebody else is to look at
    sqlite3 "$tmp/short.db" "update blocks set record = x'00'" && $matrig bundle "$tmp/short.db" 1 -o "$tmp/nopage" 2>"$tmp/nopage.err" &&
        grep -q 'without report.html: none can be made: damaged block record' "$tmp/nopage.err" && $matrig --quiet replay "$tmp/nopage" --verify
}
of_a_bundle() { # a bundle is a campaign: it can be bundled, and is the same landing
    cp "$tmp/short.bundle" "$tmp/again" && $matrig --quiet bundle "$tmp/again" 1 -o "$tmp/twice" && other "$tmp/twice" && $matrig --quiet replay "$tmp/twice" --verify >/dev/null &&
        [ "$(sqlite3 "$tmp/twice" "select sha256 from bundle_manifest where name='frames'")" = "$(sqlite3 "$tmp/short.bundle" "select sha256 from bundle_manifest where name='frames'")" ]
}

check "landing 5 is recorded, compared, spoken of" record
check "it fits into one file of at most 10 MB, and leaves nothing beside it" made
check "SQLite's own archiver extracts page, candump log, scene and image" archive
check "the slice has the surveys, series and slow log around the landing, and no others" slice_has_its_own
check "another program comes to the same digests, and to the same seal" other "$bundle"
check "it verifies" $matrig replay "$bundle" --verify
if timeout 20 unshare --map-root-user --mount --pid --net --fork true 2>"$tmp/unshare.err"; then
    check "in a root with nothing but the two programs, their libraries and the bundle it replays, 0 fields different" container
else
    check "it replays, 0 fields different; not in a bare root # SKIP no namespaces here: $(head -n 1 "$tmp/unshare.err")" replays
fi
check "one is damaged in many ways" damage_it
check "a changed byte is found, wherever it is" any_byte
check "in the image, which is named" only within:sqlar:data firmware.elf
check "in a block, whose table is named" only within:blocks:record 'table blocks'
check "a changed number of an edge" only row 'table edges'
check "another digest in the manifest" only hash can.log
check "a part that is gone" damaged gone 'firmware.elf  *lost: it is not in the archive'
check "a trigger that is gone" only trigger schema
check "a table too many" damaged table 'more  *foreign: the manifest does not have it'
check "a manifest without parts" damaged empty 'bundle_manifest  *lost: it is empty'
check "a thousand files" damaged many 'file[0-9]+  *foreign: no bundle has a file of this name'
check "cut off: where, and page and candump log are saved" cut_off
check "of a damaged one, what is whole is saved, once" saves_only_what_is_whole
check "a file named ../escaped" nothing_escapes parent '\.\./escaped  *foreign'
check "a file named /tmp/matrig-escaped" nothing_escapes absolute '/tmp/matrig-escaped  *foreign'
check "a file that the manifest does not have" nothing_escapes extra '\.\./extra  *foreign'
check "a NUL in a name" nothing_escapes nul 'report.html.x  *foreign'
check "a name of 5,000 letters" nothing_escapes long 'x+  *foreign: no bundle has a name so long'
check "a symbolic link" nothing_escapes symlink 'report.html  *lost: it is no plain file \(mode 120777\)'
check "a file that claims a terabyte" nothing_escapes claims 'report.html  *lost: it claims to be 1099511627776 bytes long'
check "a file that claims less than nothing" nothing_escapes less 'report.html  *lost: it claims to be -1 bytes long'
check "30 MiB packed as 30 KiB" nothing_escapes bomb 'report.html  *lost: its packed bytes are damaged'
check "a blob of 40 MB" nothing_escapes huge 'report.html  *lost: it cannot be read'
check "a view without end in a table's place" damaged view 'view edges is none that a bundle has'
check "a computed column" damaged computed 'table edges is none that a bundle has'
check "one that was opened for writing is told from one that was changed" opened_for_writing
check "another image than the one that recorded it is refused, or left out" another_image_is_refused
check "one that would be too long names its largest part" too_long
check "a bundle of a bundle" of_a_bundle
check "a damaged landing is passed on without a page" without_a_page
check "a campaign is no bundle" fails_with 4 'no bundle .*bundle_manifest.*give a RUN: matrig replay DB RUN' $matrig replay "$db"
check "a text is no bundle" fails_with 4 'no bundle: README.md' $matrig replay README.md
check "a folder is no bundle" fails_with 3 'cannot be read .*: build; ' $matrig replay build
check "one that is not there" fails_with 3 'cannot be read .No such file' $matrig replay "$tmp/nothing"
check "--verify is for a bundle" fails_with 2 "verify is for a bundle, which has no RUN: '1'" $matrig replay "$db" 1 --verify
check "an unknown part" fails_with 2 "no such part: 'elf' for --without" $matrig bundle "$db" 1 -o "$tmp/none3" --without page,elf
finish
