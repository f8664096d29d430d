#!/usr/bin/env bash
# matrig board config against matrig-board: got, changed, refused, kept over a restart, logged with a landing, replayed.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

serial() { with_board --serial "unix:$sockets/serial" -- $matrig board --serial "unix:$sockets/serial" config "$@"; }
can() { with_board --can "unix:$sockets/can" -- $matrig board --can "unix:$sockets/can" config "$@"; }
edit() { sed -E "$2" "$tmp/first.cfg" >"$tmp/$1.cfg" && ! cmp -s "$tmp/first.cfg" "$tmp/$1.cfg"; }
value() { awk -v name="$2 = " 'index($0, name) == 1 { sub(/^[^=]*= /, ""); sub(/  # .*/, ""); print }' "$1"; }

a_new_board_tells_what_is_built_in() {
    serial get -o "$tmp/first.cfg" >"$tmp/got" && cat "$tmp/got" && grep -q 'revision 0.*built in' "$tmp/got" &&
        # values worked out here: 0.5 V/in, 3.3 V of 4096 codes; 50 mV; 5 mV/lb
        [ "$(value "$tmp/first.cfg" 'gate[24].station_ft')" = 112.5 ] && [ "$(value "$tmp/first.cfg" 'gate[2].step_codes')" = 120 ] &&
        python3 -c "import sys; a, b, c = map(float, sys.argv[1:]); sys.exit(not (abs(a - 3.3 / 2048) < 1e-9 and abs(b - 62.0606) < 1e-4 and abs(c - 3.3 / 4096 / 0.005) < 1e-7))" \
            "$(value "$tmp/first.cfg" 'channel[1].unit_per_code')" "$(value "$tmp/first.cfg" 'channel[8].zero_code')" "$(value "$tmp/first.cfg" 'channel[22].unit_per_code')" &&
        $matrig board config check "$tmp/first.cfg"
}
a_change_is_shown_and_stored() {
    edit second 's/^(gate\[24\]\.station_ft = ).*/\1112.625/; s/^(site\.name = ).*/\1"rig #2"  # renamed/; s/^(channel\[3\]\.calibrated_day = ).*/\12026-02-28/' || return 1
    serial set "$tmp/second.cfg" >"$tmp/set" || return 1
    cat "$tmp/set"
    grep -qx 'gate\[24\].station_ft: 112.5 -> 112.625' "$tmp/set" && grep -qx 'site.name: "rig" -> "rig #2"' "$tmp/set" &&
        grep -qx 'channel\[3\].calibrated_day: never -> 2026-02-28' "$tmp/set" && grep -q '^3 fields changed.*revision 1, CRC' "$tmp/set" && [ "$(wc -l <"$tmp/set")" = 4 ]
}
it_outlasts_the_power_and_comes_over_can() {
    can get -o "$tmp/back.cfg" >"$tmp/got" && cat "$tmp/got" && grep -q 'revision 1.*copy A' "$tmp/got" && [ "$(value "$tmp/back.cfg" site.name)" = '"rig #2"' ] &&
        [ "$(value "$tmp/back.cfg" 'gate[24].station_ft')" = 112.625 ] && [ "$(value "$tmp/back.cfg" 'channel[3].calibrated_day')" = 2026-02-28 ] &&
        # nothing else is another
        [ "$(diff <(grep -E '^[a-z]+(\[[0-9]+\])?\.' "$tmp/first.cfg") <(grep -E '^[a-z]+(\[[0-9]+\])?\.' "$tmp/back.cfg") | grep -c '^>')" = 4 ]
}
the_same_again_changes_nothing() { # and the CRC that the file has is the board's
    local before after
    before=$(cksum "$tmp/flash")
    can set "$tmp/back.cfg" >"$tmp/set" && grep -q 'the board already has this configuration, 0 fields changed: revision 1' "$tmp/set" || return 1
    after=$(cksum "$tmp/flash")
    cat "$tmp/set"
    [ "$before" = "$after" ] && [ "$(grep -o 'CRC .*' "$tmp/set")" = "$($matrig board config check "$tmp/back.cfg" | grep -o 'CRC .*')" ]
}
over_can_too() {
    sed 's/^\(site\.touchdown_ft = \).*/\14.25/' "$tmp/back.cfg" >"$tmp/third.cfg"
    can set "$tmp/third.cfg" 2>"$tmp/refused"
    [ $? = 2 ] && grep 'the board refused .config-apply.: .*only over serial, or over CAN with the maintenance jumper' "$tmp/refused" || return 1
    with_board --jumper --can "unix:$sockets/can" -- $matrig --json board --can "unix:$sockets/can" config set "$tmp/third.cfg" >"$tmp/set.json" || return 1
    cat "$tmp/set.json"
    [ "$(python3 -c 'import json,sys; d=json.load(open(sys.argv[1])); print(d["revision"], [c["field"] for c in d["changes"]])' "$tmp/set.json")" = "2 ['site.touchdown_ft']" ]
}
stale() { # made from revision 1, and 2 is in force
    sed 's/^\(site\.touchdown_ft = \).*/\15/' "$tmp/back.cfg" >"$tmp/stale.cfg"
    serial set "$tmp/stale.cfg" 2>"$tmp/stale.err"
    local status=$?
    cat "$tmp/stale.err"
    [ $status = 1 ] && grep -q 'based on revision 1, but the board has revision 2: .*stale.cfg; get and edit the present configuration' "$tmp/stale.err"
}
locked() { # a landing is armed: neither got nor set
    local board helper status
    rm -f "$tmp/can.log"
    timeout 600 build/matrig-board --elf $elf --flash "$tmp/flash" --can "file:$tmp/can.log" --serial "unix:$sockets/serial" --rig tests/runs/landing5.run \
        --speed real --for 60 2>"$tmp/board.err" &
    board=$!
    timeout 600 python3 tests/board/relay.py "$sockets/serial" "$sockets/relay" "$tmp/can.log" " 0A0#01" &
    helper=$!
    await test -S "$sockets/relay"
    timeout 600 $matrig --quiet board --serial "unix:$sockets/relay" config set "$tmp/third.cfg" 2>"$tmp/locked.err"
    status=$?
    kill $board
    wait $board $helper
    cat "$tmp/locked.err"
    [ $status = 2 ] && grep -q 'the configuration is locked because a landing is armed or in progress: .*; disarm the board' "$tmp/locked.err"
}

# refused EXIT PATTERN SED: the first file, changed so, is refused with a line that matches
refused() {
    edit bad "$3" && fails_with "$1" "^matrig: $2" $matrig board config check "$tmp/bad.cfg"
}
line_of() { awk -v name="$1 = " 'index($0, name) == 1 { print NR }' "$tmp/first.cfg"; }
files_are_refused_with_line_and_advice() {
    local gate=$(line_of 'gate[3].station_ft') kind=$(line_of 'channel[9].kind') mats=$(line_of site.mats)
    refused 4 "site.mats cannot be .many.: .*bad.cfg:$mats; give 1 to 512$" 's/^(site\.mats = ).*/\1many/' &&
        refused 4 "site.mats cannot be .600.: .*bad.cfg:$mats; give 1 to 512$" 's/^(site\.mats = ).*/\1600/' &&
        refused 4 "gate\[3\].station_ft cannot be .nan.: .*bad.cfg:$gate; give -1000 to 1000$" 's/^(gate\[3\]\.station_ft = ).*/\1nan/' &&
        refused 1 "gate\[3\].station_ft is 2.5, gate\[2\].station_ft is 2.5: the first value must be larger: .*bad.cfg:$gate; correct it$" 's/^(gate\[3\]\.station_ft = ).*/\12.5/' &&
        refused 1 "gate\[3\].station_ft is 1e\+09: above its maximum: .*bad.cfg:$gate; give -1000 to 1000$" 's/^(gate\[3\]\.station_ft = ).*/\11e9/' &&
        refused 1 "channel\[9\].kind is 1: this input cannot measure that kind: .*bad.cfg:$kind; set the kind of channel\[1\] to \[8\] to 1" 's/^(channel\[9\]\.kind = ).*/\11/' &&
        refused 1 'channel\[2\].number is 1, channel\[1\].number is 1: two channels of one kind have the same number: .*; correct it' 's/^(channel\[2\]\.number = ).*/\11/' &&
        refused 4 'channel\[2\].expires_day cannot be .2026-02-30.: .*; give YYYY-MM-DD up to 2243-10-17, or never' 's/^(channel\[2\]\.expires_day = ).*/\12026-02-30/' &&
        refused 2 'no such gate: 25: .*; use gate\[1\] to gate\[24\]' 's/^gate\[24\]/gate[25]/' &&
        refused 2 'no such group: .mat.: .*; use the group site, channel, gate, band or predict' 's/^site\.mats/mat.mats/' &&
        refused 2 'gate has no field .place.: .*; use a field from the comment above' 's/^gate\[4\]\.station_ft/gate[4].place/' &&
        refused 4 "site.mats is given twice: .*bad.cfg:$((mats + 1)); line $mats also sets this field" 's/^(site\.mats = .*)/\1\nsite.mats = 3/' &&
        refused 4 'field site.mats is missing: .*; give every field' '/^site\.mats/d' &&
        refused 4 'not a field: .hello world.: .*:1; write group' '1s/.*/hello world/' &&
        refused 4 'site.name cannot be .rig.: .*; give at most 16 printable characters in double quotes' 's/^(site\.name = ).*/\1rig/' &&
        fails_with 3 "cannot be read .No such file.*: $tmp/none.cfg; matrig board config get" $matrig board config check "$tmp/none.cfg" &&
        fails_with 4 "not a text file: $elf; give a file" $matrig board config check $elf
}
words_are_checked() {
    fails_with 2 "unknown action of config: 'put'" $matrig board config put &&
        fails_with 2 'matrig board config get needs one link' $matrig board config get &&
        fails_with 2 'no file' $matrig board --serial unix:/none config set &&
        fails_with 2 'uses no board' $matrig board --serial unix:/none config check "$tmp/first.cfg" &&
        fails_with 2 'matrig board config get needs one link' $matrig board --serial unix:/a --can unix:/b config get
}

record() { # SECONDS DB LOG-OPTIONS: a landing, or its beginning, by the configuration that is in flash, logged over sockets
    local board status seconds=$1
    shift
    timeout 600 build/matrig-board --elf $elf --flash "$tmp/flash" --can "unix:$sockets/can" --serial "unix:$sockets/serial" --rig tests/runs/landing5.run \
        --speed max --for "$seconds" 2>"$tmp/board.err" &
    board=$!
    timeout 600 $matrig --quiet log --all --can "unix:$sockets/can" --serial "unix:$sockets/serial" --db "$@" >"$tmp/log.txt"
    status=$?
    wait $board
    return $status
}
the_log_keeps_it_with_the_landing() {
    record 3 "$tmp/campaign.db" || return 1
    sqlite3 "$tmp/campaign.db" "select text from landings join configurations on crc = config_crc where landings.id = 1" >"$tmp/kept.cfg"
    head -n 20 "$tmp/kept.cfg"
    [ "$(value "$tmp/kept.cfg" site.revision)" = 2 ] && [ "$(value "$tmp/kept.cfg" site.touchdown_ft)" = 4.25 ] && $matrig board config check "$tmp/kept.cfg" &&
        [ "$(sqlite3 "$tmp/campaign.db" "select printf('%08x', config_crc) from landings")" = "$($matrig board config check "$tmp/kept.cfg" | sed 's/.*CRC //')" ]
}
a_replay_runs_under_it() { # and with what is built in it would not say the same
    $matrig --json --quiet replay "$tmp/campaign.db" 1 >"$tmp/replay.json" || return 1
    [ "$(python3 -c 'import json,sys; print(json.load(open(sys.argv[1]))["differ"])' "$tmp/replay.json")" = 0 ] || return 1
    cp "$tmp/campaign.db" "$tmp/without.db" && sqlite3 "$tmp/without.db" "delete from configurations" &&
        ! $matrig --json --quiet replay "$tmp/without.db" 1 >"$tmp/replay2.json" &&
        $matrig bundle "$tmp/campaign.db" 1 -o "$tmp/bundle.db" && [ "$(sqlite3 "$tmp/bundle.db" "select count(*) from configurations")" = 1 ]
}
listening_sends_nothing() {
    record 3 "$tmp/listen.db" --listen && cat "$tmp/board.err" && [ "$(sqlite3 "$tmp/listen.db" "select count(*) from configurations")" = 0 ] &&
        [ "$(sqlite3 "$tmp/listen.db" "select count(*) from landings where config_crc is not null")" = 1 ]
}
damage_is_told() { # a bit of the newer copy (B, 0x0800C000)
    python3 - "$tmp/flash" <<'P'
import sys
flash = open(sys.argv[1], 'r+b')
flash.seek(0xC000 + 100)
byte = flash.read(1)[0]
flash.seek(0xC000 + 100)
flash.write(bytes([byte ^ 1]))
P
    serial get -o "$tmp/fallen.cfg" >"$tmp/got" 2>"$tmp/got.err"
    cat "$tmp/got" "$tmp/got.err"
    grep -q 'revision 1.*copy A' "$tmp/got" && grep -q "copy B of the configuration in the board's flash is damaged: checksum does not match" "$tmp/got.err"
}

check "a new board tells what is built in" a_new_board_tells_what_is_built_in
check "a change is shown, stored and read back" a_change_is_shown_and_stored
check "it outlasts the power, comes over CAN, and nothing else is another" it_outlasts_the_power_and_comes_over_can
check "the same again changes nothing" the_same_again_changes_nothing
check "a change over CAN, told as JSON" over_can_too
check "a file made from an older revision is refused" stale
check "locked while a landing is armed, and said so" locked
check "files are refused with line, what and what to do" files_are_refused_with_line_and_advice
check "wrong words are refused" words_are_checked
check "the log keeps it with the landing" the_log_keeps_it_with_the_landing
check "a replay runs under it" a_replay_runs_under_it
check "log --listen sends nothing" listening_sends_nothing
check "a damaged copy is told, the other one is in force" damage_is_told
finish
