#!/usr/bin/env bash
# Each board's image on the emulated board of its name: landing 5 logged, reported and replayed; what a board lacks; an image for another board.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
board=
trap 'kill $board 2>/dev/null; rm -rf "$sockets"' EXIT

elf_of() { if [ "$1" = zg ]; then echo build/firmware/matrig.elf; else echo "build/firmware/$1/matrig.elf"; fi; }
in_json() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.$2')"; }
record() { # NAME: landing 5, logged into NAME.db
    played --elf "$(elf_of "$1")" --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --rig tests/runs/landing5.run 2>"$tmp/$1.err" &&
        $matrig log --all --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --db "$tmp/$1.db" >"$tmp/$1.txt"
}
gear() { grep -E '^  (touchdown|deceleration|stop) ' "$tmp/$1.txt"; }
movements() { grep -E '^ +[0-9]+ +[0-9]+\.[0-9] +-?[0-9]+\.[0-9]{4} \+- ' "$tmp/$1.txt"; } # number station peak +- error end +- error valid
tensions() { grep -E '^ +[0-9]+ +[0-9]+ +[0-9]+\.[0-9] +-?[0-9]+\.[0-9] ' "$tmp/$1.txt"; }
# lands NAME TRANSDUCERS GAGES: as zg, on the channels that the board has. The converters' noise is drawn in another order: of a peak, the
# greatest of some hundred means of 2 LSB over 5 blocks, no more than 0.0015 in; of the mean at the end 0.3 lb.
lands() {
    record "$1" && diff <(gear zg) <(gear "$1") && [ "$(gear "$1" | wc -l)" = 3 ] || return 1
    [ "$(movements "$1" | wc -l)" = "$2" ] && [ "$(tensions "$1" | wc -l)" = "$3" ] || return 1
    paste <(movements zg | head -n "$2") <(movements "$1") | awk '{ print; d = $3 - $12; e = $6 - $15
        if ($2 != $11 || $9 != "100.0" || $18 != "100.0" || d * d > 0.0015 ^ 2 || e * e > 0.0015 ^ 2) bad = 1 } END { exit bad }' || return 1
    paste <(tensions zg | head -n "$3") <(tensions "$1") | awk '{ print; n = NF / 2; e = $(n - 3) - $(NF - 3)
        if ($3 != $(n + 3) || $n != "100.0" || $NF != "100.0" || e * e > 0.3 ^ 2) bad = 1 } END { exit bad }'
}
# the record, its faults and what is said of links are sound, and the page is there
is_sound() {
    grep -Eq '^  faults +none$' "$tmp/$1.txt" && grep -Eq '^  gaps +none$' "$tmp/$1.txt" &&
        $matrig --quiet report "$tmp/$1.db" -o "$tmp/$1.html" >/dev/null && [ "$(sqlite3 "$tmp/$1.db" 'select count(*) from channels where kind in (1, 2)')" = "$2" ]
}
says_the_same() { # NAME: 3 s of it, with the warning; without naming the image
    played --elf "$(elf_of "$1")" --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --rig tests/runs/landing5.run --for 3 2>"$tmp/$1.err" &&
        $matrig --quiet log --can "file:$tmp/$1.can" --serial "file:$tmp/$1.serial" --db "$tmp/$1.begun.db" >/dev/null || return 1
    $matrig --json --quiet replay "$tmp/$1.begun.db" 1 >"$tmp/$1.json" && cat "$tmp/$1.json"
    [ "$(in_json "$tmp/$1.json" differ)" = 0 ] && [ "$(in_json "$tmp/$1.json" compared)" = exactly ]
}

# the image that a replay takes is the one that is bundled: it is named nowhere
bundles() {
    $matrig --quiet bundle "$tmp/$1.begun.db" 1 -o "$tmp/$1.bundle" && $matrig --json --quiet replay "$tmp/$1.bundle" >"$tmp/$1.json" || return 1
    [ "$(in_json "$tmp/$1.json" compared)" = exactly ] && [ "$(sqlite3 "$tmp/$1.bundle" 'select length(image) > 100000 from bundles')" = 1 ]
}
no_replay_on_another() {
    fails_with 4 'recorded by board zg, but the image is for discovery: build/firmware/discovery/matrig.elf; leave --elf out' \
        $matrig replay "$tmp/zg.db" 1 --elf build/firmware/discovery/matrig.elf &&
        fails_with 4 'recorded by board discovery, but the image is for zg' $matrig --quiet replay "$tmp/discovery.bundle" --elf build/firmware/matrig.elf
}

start_board() { # NAME OPTION...
    timeout 600 build/matrig-board --elf "$(elf_of "$1")" --serial "unix:$sockets/serial" --can "unix:$sockets/can" --for 60 "${@:2}" 2>"$tmp/board.err" &
    board=$!
    await test -S "$sockets/can"
}
stop_board() { kill $board 2>/dev/null; wait $board 2>/dev/null; rm -f "$sockets"/*; }
is_ready() { # the channels that it has, and no word of others
    start_board discovery --rig hil/rest.run || return 1
    timeout 600 $matrig --quiet ready "$tmp/ready.db" --serial "unix:$sockets/serial" --can "unix:$sockets/can" >"$tmp/ready.txt" 2>&1
    local status=$?
    stop_board
    cat "$tmp/ready.txt"
    [ $status = 0 ] && [ "$(grep -Ec '^GO +(transducer|gage) +[0-9]' "$tmp/ready.txt")" = 11 ] && tail -n 1 "$tmp/ready.txt" | grep -q '^GO, UNCALIBRATED '
}
alone() { # NAME ARGUMENTS...: matrig against this board, serial alone: $link
    timeout 600 build/matrig-board --elf "$(elf_of "$1")" --serial "$link" --for 60 2>"$tmp/board.err" &
    board=$!
    await test -e "$sockets/serial"
    timeout 600 $matrig --quiet "${@:2}" >"$tmp/said" 2>&1
    local status=$?
    stop_board
    cat "$tmp/said"
    return $status
}
link=unix:$sockets/serial
says_its_kind() { alone discovery board --serial "unix:$sockets/serial" && grep -Eq '^kind of board +discovery$' "$tmp/said"; }
is_refused() { # PATTERN ARGUMENTS of alone...
    alone "${@:2}"
    [ $? != 0 ] && grep -Eq "$1" "$tmp/said"
}
no_configuration_of_another() {
    alone zg board config get --serial "unix:$sockets/serial" -o "$tmp/zg.cfg" && sed -i 's/^revision .*/revision 1/' "$tmp/zg.cfg" &&
        is_refused 'no such input' discovery board config set --serial "unix:$sockets/serial" "$tmp/zg.cfg"
}
no_such_board() {
    make -s BOARD=nosuch help >"$tmp/out" 2>&1
    [ $? = 2 ] && grep -q 'BOARD=nosuch: there is no such board; there are: zg discovery' "$tmp/out" &&
        fails_with 2 '--board cannot be .nosuch.; there are: zg discovery nucleo446$' build/matrig-board --board nosuch || return 1
    for two in 'zg discovery' '%'; do # a name, no list and no pattern
        make -s BOARD="$two" help >"$tmp/out" 2>&1
        [ $? = 2 ] && grep -q "BOARD=$two: there is no such board" "$tmp/out" || { echo "BOARD='$two'"; return 1; }
    done
}
on_another_board() {
    fails_with 4 'is an image for board discovery, but the emulated board is zg' build/matrig-board --board zg --elf build/firmware/discovery/matrig.elf --for 0.1 &&
        fails_with 2 'cannot be reached on its serial link' build/matrig-board --board discovery --boot0 --for 0.1
}
# The flash of a Discovery, as a run leaves it.
flash_of_another_board() {
    build/matrig-board --elf build/firmware/discovery/matrig.elf --flash "$tmp/discovery.flash" --for 0.1 &&
        cp "$tmp/discovery.flash" "$tmp/before" &&
        fails_with 4 'is an image for board discovery, but the emulated board is zg' build/matrig-board --board zg --flash "$tmp/discovery.flash" --for 0.1 &&
        fails_with 2 'cannot be reached on its serial link' build/matrig-board --boot0 --flash "$tmp/discovery.flash" --for 0.1 &&
        fails_with 4 'is an image for board discovery, but the emulated board is zg' build/matrig-board --board zg --boot0 --flash "$tmp/discovery.flash" --for 0.1 &&
        cmp "$tmp/before" "$tmp/discovery.flash" &&
        build/matrig-board --flash "$tmp/discovery.flash" --for 0.1
}
check "zg: landing 5" record zg
check "discovery: landing 5, five transducers and six gages" lands discovery 5 6
check "nucleo446: landing 5, all channels" lands nucleo446 8 14
check "discovery: nothing lost, no fault, its page" is_sound discovery 11
check "nucleo446: nothing lost, no fault, its page" is_sound nucleo446 22
check "discovery: replay finds its image, no field differs" says_the_same discovery
check "discovery: bundled with its image" bundles discovery
check "a landing is not replayed on another board" no_replay_on_another
check "discovery: go before a landing" is_ready
check "discovery: it says which board it is" says_its_kind
check "a configuration with channels that the board lacks is refused by name" no_configuration_of_another
link=pty:$sockets/serial # for stm32flash
check "an image for another board is not flashed" is_refused 'the board is zg, but the image is for discovery' zg flash "$link" build/firmware/discovery/matrig.elf
check "a board whose boot ROM would not hear does not go there" is_refused 'does not use this serial link' discovery flash "$link" build/firmware/discovery/matrig.elf --force
check "a board that is none is refused" no_such_board
check "the emulated board refuses an image for another" on_another_board
check "flash files of another board are refused, and stay as they are" flash_of_another_board
finish
