#!/usr/bin/env bash
# Bands from the emulated board to campaign, summary and report: figures of landing 5 against the run file, a gage that drifts
# between two shunt calibrations, a band that gives way.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

# seal NAME: end a run file on its checksum.
seal() {
    printf 'end %s\n' "$(gzip -c "$tmp/$1.run" | tail -c 8 | head -c 4 | od -An -tx4 | tr -d ' ')" >>"$tmp/$1.run"
}
# play NAME BOARD-OPTION...: play it, log it into NAME.db.
play() {
    local name=$1
    shift
    played --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --rig "$tmp/$name.run" "$@" 2>"$tmp/board.err" || return 1
    $matrig --json --quiet log --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$tmp/$name.db" >"$tmp/$name.json" 2>"$tmp/log.err" || grep -q 'the link ended inside a frame' "$tmp/log.err"
}
in_db() { sqlite3 "$tmp/$1.db" "$2"; }
in_report() { grep -q "$1" "$tmp/report.html"; }

# Landing 5, armed a quarter of a second later, between two shunt calibrations; gage 5's gain drifts by 3 % while it rolls.
grep -av '^end ' tests/runs/landing5.run | sed -E 's/^(command 0\.300 .*survey 0 .*)/command 0.02 can shunt\n\1/
    s/^command 0\.800 (.*)/command 1.050 \1/
    s/^command 8\.875/command 7.9 can disarm\ncommand 7.92 can shunt\n&/' >"$tmp/shunts.run"
seal shunts
printf 'matrig-faults 1\nat 3 gage 5 drift 1.03 0\n' >"$tmp/drift.faults"

shunts_are_stored() {
    play shunts --faults "$tmp/drift.faults" && [ "$(in_db shunts 'select count(*) from shunts where links = 2')" = 28 ] &&
        [ "$(in_db shunts 'select group_concat(gage) from shunts where verdict <> 0')" = 5 ] &&
        [ "$(in_db shunts 'select count(*) from shunts where abs(span_lb - 40) < 0.05')" = 27 ]
}
drift_is_reported() { # 3 % of 40 lb
    [ "$(in_db shunts 'select abs(a.span_lb - b.span_lb - 1.2) < 0.05 from shunts a join shunts b on a.gage = b.gage and a.number = 2 and b.number = 1 where a.gage = 5')" = 1 ] &&
        [ "$(in_db shunts 'select abs(change_lb - 1.2) < 0.05 from shunts where number = 2 and gage = 5')" = 1 ] &&
        $matrig report "$tmp/shunts.db" -o "$tmp/report.html" >/dev/null && in_report 'span before' && in_report '<td>good</td><td>wrong</td>'
}
# The truth in the run file: least and most by the columns of the gages from the first edge on, in 0.01 lb.
truth() { # BAND min|max
    awk -v band="$1" -v what="$2" '/^samples/ { on = 1; next } /^end/ { exit } on && NF == 22 { for (i = 9 + 7 * (band - 1); i <= 15 + 7 * (band - 1); i++)
        if (v == "" || (what == "min" ? $i < v : $i > v)) v = $i } END { print v / 100 }' tests/runs/landing5.run
}
figures_are_the_truth() {
    cp tests/runs/landing5.run "$tmp/plain.run" && play plain || return 1
    local band
    for band in 1 2; do
        [ "$(in_db plain "select abs(least_lb - $(truth $band min)) < 0.5 and abs(most_lb - $(truth $band max)) < 0.5 and links = 2 from bands where band = $band")" = 1 ] || return 1
    done
    [ "$(in_db plain 'select count(*) from band_events')" = 0 ]
}
summary_says_it() { # log says the same as the table; the least is ahead of the wheel, as appendix C asks
    grep -q '"recovered":1.0' "$tmp/plain.json" || grep -q '"recovered": 1.0' "$tmp/plain.json" || return 1
    rm "$tmp/plain.db"
    $matrig --quiet log --all --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$tmp/plain.db" >"$tmp/plain.txt" 2>/dev/null
    grep -Eq '^ +1 +100\.3 \+- 0\.[0-9] +[0-9.]+ +64\.1 \+- [0-9.]+ +65\.0 +[0-9.]+ +127\.2 \+- ' "$tmp/plain.txt" && grep -Eq '^ +1 +4\.[0-9]+ \+- [0-9.]+ +10[45]$' "$tmp/plain.txt"
}
# Band 2's truth falls at once, by 15 lb at each gage and 25 at gage 11, 3.2 s after power-on.
grep -av '^end ' tests/runs/landing5.run | awk '/^samples/ { on = 1; print "samples " $2, $3; next }
    on && /^x/ { for (n = substr($0, 2); n > 0; n--) out(last); next } on && NF == 22 { last = $0; out(last); next } { print }
    function out(row,   i, v) { k++; split(row, v, " "); if (k > 3200) for (i = 16; i <= 22; i++) v[i] -= i == 19 ? 2500 : 1500
        row = v[1]; for (i = 2; i <= 22; i++) row = row " " (v[i] < 0 ? 0 : v[i]); print row }' >"$tmp/slip.run"
seal slip
slip_is_named() {
    play slip && [ "$(in_db slip 'select band, gage, reason from band_events where reason between 3 and 7')" = '2|11|3' ] &&
        [ "$(in_db slip 'select abs(block - 3200) < 20 and abs(value_lb - 25) < 2 and links = 2 from band_events where reason = 3')" = 1 ] &&
        [ "$(in_db slip 'select change_lb < -8 from bands where band = 2')" = 1 ] &&
        $matrig report "$tmp/slip.db" -o "$tmp/report.html" >/dev/null && in_report '<td class="n">2</td><td>connection slip</td><td class="n">11</td>'
}
slip_replays() { $matrig --quiet replay "$tmp/slip.db" 1 >"$tmp/replay.txt" && grep -q ' 0 of [0-9]* fields differ' "$tmp/replay.txt"; }
bundled() {
    $matrig --quiet bundle "$tmp/shunts.db" 1 -o "$tmp/bundle.db" >/dev/null &&
        [ "$(sqlite3 "$tmp/bundle.db" 'select (select count(*) from bands), (select count(*) from shunts)')" = '2|28' ]
}
# with_board ARGUMENTS...: matrig against a board that idles, gage 5 with a gain 3 % high and an offset of 5 lb; its exit code
with_board() {
    local board status
    printf 'matrig-faults 1\nat 0.001 gage 5 drift 1.03 5\n' >"$tmp/idle.faults"
    timeout 600 build/matrig-board --elf build/firmware/matrig.elf --serial "unix:$sockets/serial" --faults "$tmp/idle.faults" --for 60 2>"$tmp/board.err" &
    board=$!
    timeout 600 $matrig "$@"
    status=$?
    kill $board 2>/dev/null
    wait $board 2>/dev/null
    return $status
}
shunt_by_hand() {
    with_board board shunt --serial "unix:$sockets/serial" >"$tmp/shunt.txt"
    [ $? = 1 ] && cat "$tmp/shunt.txt" && [ "$(grep -c 'good$' "$tmp/shunt.txt")" = 13 ] && grep -Eq '^ +5 +41\.[12][0-9]+ +40\.00 .*wrong$' "$tmp/shunt.txt"
}
shunt_in_newtons() { # 40 lb are 177.93 N
    with_board --si board shunt --serial "unix:$sockets/serial" >"$tmp/shunt.txt"
    cat "$tmp/shunt.txt"
    grep -Eq '^ +5 +18[23]\.[0-9]+ +177\.9[0-9]* .*wrong$' "$tmp/shunt.txt" && grep -Eq '^ +gage +N +N ' "$tmp/shunt.txt"
}
zero_by_hand() {
    with_board --json board zero 2 --serial "unix:$sockets/serial" >"$tmp/zero.json" && cat "$tmp/zero.json" &&
        [ "$(sqlite3 :memory: "select json_extract(cast(readfile('$tmp/zero.json') as text), '\$.good'), json_array_length(cast(readfile('$tmp/zero.json') as text), '\$.zeros')")" = '1|14' ]
}
check "a shunt calibration by hand names the wrong gage and exits 1" shunt_by_hand
check "and with --si in newtons" shunt_in_newtons
check "a zero by hand is taken" zero_by_hand
check "gages without a link are refused" fails_with 2 'no link: matrig board shunt needs --serial LINK' $matrig board shunt
check "shunt calibrations before and after a landing are in the campaign, the wrong gage named" shunts_are_stored
check "a gain that drifted between them is reported" drift_is_reported
check "least and most tension of both bands are those of the run file, with no finding" figures_are_the_truth
check "the log's summary says where the least was" summary_says_it
check "a connection that slips is named, with its gage and block" slip_is_named
check "and says the same when it is replayed" slip_replays
check "a bundle has bands and shunts" bundled
finish
