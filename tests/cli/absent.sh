#!/usr/bin/env bash
# A landing of a rig that lacks channels: logged, read out of the black box, replayed without a difference.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
variants=build/tests/variant

in_json() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.$2')"; }
# record NAME ELF: landing 5, logged into NAME.db
record() {
    played --elf "$2" --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --rig tests/runs/landing5.run 2>"$tmp/$1.err" &&
        $matrig log --all --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --db "$tmp/$1.db" >"$tmp/$1.txt"
}
tells() { # NAME: speed and stop as with all channels; what else it has
    grep -E '^  (touchdown|deceleration|stop) ' "$tmp/full.txt" >"$tmp/wanted"
    grep -E '^  (touchdown|deceleration|stop) ' "$tmp/$1.txt" | diff "$tmp/wanted" - && [ "$(wc -l <"$tmp/wanted")" -ge 3 ]
}
four_tell() {
    record full build/firmware/matrig.elf && record four $variants/four.elf && tells four || return 1
    grep -E '^ +[0-9]+ +[4-7]0\.0 ' "$tmp/full.txt" >"$tmp/wanted"
    grep -E '^ +[0-9]+ +[0-9]+\.0 ' "$tmp/four.txt" >"$tmp/got"
    # station, peak, end: the noise of the converters is drawn in another order
    paste "$tmp/wanted" "$tmp/got" | awk '{ print; d = $3 - $12; e = $6 - $15
        if ($2 != $11 || d * d > 0.003 ^ 2 || e * e > 0.003 ^ 2) bad = 1 } END { exit bad || NR != 4 }' && ! grep -q 'tension' "$tmp/four.txt"
}
switches_tell() { record switches $variants/switches.elf && tells switches && ! grep -Eq '^ +[0-9]+ +[0-9]+\.0 |tension|movement' "$tmp/switches.txt"; }
channels_of() { [ "$(sqlite3 "$tmp/$1.db" 'select count(*) from channels where kind in (1, 2)')" = "$2" ]; }
only_those_are_stored() { channels_of full 22 && channels_of four 4 && channels_of switches 0; }
begun() { # NAME: 3 s of it, with the warning
    played --elf "$variants/$1.elf" --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --rig tests/runs/landing5.run --for 3 2>"$tmp/$1.err" &&
        $matrig --quiet log --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --db "$tmp/$1.begun.db" >/dev/null
}
says_the_same() { # NAME
    begun "$1" && $matrig --json --quiet replay "$tmp/$1.begun.db" 1 --elf "$variants/$1.elf" >"$tmp/$1.json" && in_json "$tmp/$1.json" first
    [ "$(in_json "$tmp/$1.json" differ)" = 0 ] && [ "$(in_json "$tmp/$1.json" compared)" = exactly ] && [ "$(in_json "$tmp/$1.json" messages)" -gt 2000 ]
}
other_image_is_found_out() { # one that has all channels: the blocks have more
    ! $matrig --json --quiet replay "$tmp/four.begun.db" 1 --exact >"$tmp/other.json" && [ "$(in_json "$tmp/other.json" differ)" -gt 1000 ]
}

# Without the predictor: the same landing, and not a word, a warning, a page of memory or an instruction of it.
quiet_tells() {
    record quiet $variants/quiet.elf && tells quiet || return 1
    [ "$(sqlite3 "$tmp/quiet.db" 'select (select count(*) from zones) + (select count(*) from predictions) + (select count(*) from runways) + (select count(*) from predict_items) + (select count(*) from risks) + (select count(*) from risk_items)')" = 0 ] &&
        [ "$(sqlite3 "$tmp/quiet.db" 'select count(*) from frames where can_id between 128 and 143')" = 0 ] && grep -q 'zone  *no warning' "$tmp/quiet.txt"
}
instructions() { sed -n 's/.*), \([0-9]*\) instructions.*/\1/p' "$tmp/$1.err"; }
it_costs_nothing() { # landing 5 took 142 million instructions before there was a predictor
    echo "with $(instructions full), without $(instructions quiet) instructions"
    [ "$(instructions quiet)" -lt $(($(instructions full) / 2)) ] && [ "$(instructions quiet)" -lt 150000000 ]
}
check "transducers 1 to 4 alone: the same speed and movements" four_tell
check "switches alone: the same speed" switches_tell
check "without the predictor: the same speed, not a word" quiet_tells
check "and it costs nothing" it_costs_nothing
check "the database has the channels that are fitted" only_those_are_stored
check "replay of transducers 1 to 4 alone: no field differs" says_the_same four
check "replay of switches alone: no field differs" says_the_same switches
check "replay without the predictor: no field differs" says_the_same quiet
check "replay on an image that has all channels differs" other_image_is_found_out
finish
