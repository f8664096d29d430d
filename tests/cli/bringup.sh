#!/usr/bin/env bash
# The bring-up image on the emulated boards, and what matrig board bringup makes of what it says. Expected values: the emulated boards'
# own oscillators, supplies and memories, which the image is not told.
. "$(dirname "$0")/tap.sh"
sockets=$(mktemp -d)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$sockets"' EXIT

# say NAME ELF BOARD-OPTION...: what a board says from power on, in $tmp/NAME.txt
say() {
    timeout 600 build/matrig-board --elf "$2" --serial "file:$tmp/$1.txt" --baud 115200 --times typical --for 4.5 "${@:3}" 2>"$tmp/$1.err"
}
# start ELF BOARD-OPTION...: an emulated board at the pseudo-terminal $sockets/tty; stop: its end, what it says in $tmp/board.err
start() {
    timeout 600 build/matrig-board --elf "$1" --serial "pty:$sockets/tty" --times typical --for 600 "${@:2}" 2>"$tmp/board.err" &
    board=$!
    await test -L "$sockets/tty"
}
stop() { kill $board; wait $board 2>/dev/null; }
bringup() { timeout 600 build/matrig board --serial "pty:$sockets/tty" bringup "$@"; }
judge() { build/matrig board --serial "file:$tmp/$1.txt" bringup "${@:2}"; } # of text that was kept
value() { awk -v n="$2" '$1 == n { print $2 }' "$tmp/$1.txt"; }
says() { [ "$(value "$1" "$2")" = "$3" ] || { echo "$1: $2 is $(value "$1" "$2"), not $3"; return 1; }; }
# The text with lines changed by a sed script and a new end: it is whole again.
reseal() { # FROM TO SCRIPT
    python3 - "$tmp/$1.txt" "$tmp/$2.txt" "$3" <<'P'
import subprocess, sys, zlib
text = open(sys.argv[1]).read()
body = text[text.index("begin "):text.index("\nend ") + 1]
body = subprocess.run(["sed", sys.argv[3]], input=body, capture_output=True, text=True).stdout
lines = body.count("\n") - 1
open(sys.argv[2], "w").write(body + "end %s %d %08x\n" % (body.split()[1], lines, zlib.crc32(body.encode())))
P
}

zg=build/firmware/bringup.elf
discovery=build/firmware/discovery/bringup.elf
# Two memories: one with an empty end, one without an empty sector.
python3 - "$tmp" <<'P'
import sys
full = bytes(range(256)) * 65536
open(sys.argv[1] + "/nor.full", "wb").write(full)
open(sys.argv[1] + "/nor.part", "wb").write(full[:16000000] + bytes([255]) * 777216)
P
cp "$tmp/nor.full" "$tmp/nor.full.was"
cp "$tmp/nor.part" "$tmp/nor.part.was"
say zg $zg --nor "$tmp/nor.part" &
say discovery $discovery
wait
say nucleo446 build/firmware/nucleo446/bringup.elf
say strange $zg --hsi-ppm 5000 --lsi 40000 --hse 0 &
say slow $zg --lsi 17500 --hsi-ppm -4000 --nor "$tmp/nor.full"
wait

whole_and_in_order() { # one to look at: brown-out is off from the factory
    judge "$1" >"$tmp/out" && tail -n 1 "$tmp/out" | grep -qx "$2 lines ok, 1 to be checked, 0 wrong" && grep -q '^  look  *brown_out  *0 level  *2 to 3$' "$tmp/out" &&
        [ "$(wc -L <"$tmp/out")" -le 100 ]
}
each_its_inputs() {
    [ "$(grep -c '^noise_' "$tmp/zg.txt")" = 24 ] && [ "$(grep -c '^noise_' "$tmp/discovery.txt")" = 13 ] &&
        says zg board zg && says discovery board discovery && says nucleo446 chip 0x421 && says zg supply 3.300 && says discovery supply 2.999
}
# The emulated board's cycle counter counts instructions: those that the budget was made of must be of these very sources.
budget_holds() { awk '$1 == "of_budget_predict" { ok = $2 > 0.65 && $2 < 0.68; print } END { exit !ok }' "$tmp/zg.txt"; }
# The watchdog's 40 and 17.5 kHz by a core that runs 0.5 % fast: 40 / 1.005; by the crystal: as it is.
oscillators_as_given() {
    says strange clock internal_pll && says strange crystal none && says strange can_frames none && says strange low_speed 39.801 &&
        says slow clock crystal && says slow crystal 8032 && says slow internal 15936 && says slow low_speed 17.500
}
stack_is_caught() { says zg stack_overflow bus_fault && says zg stack_address 0x1fffffe0 && grep -q 'resets 2, faults 1' "$tmp/zg.err"; }
wrong_is_exit_1() {
    judge strange >"$tmp/out"
    [ $? = 1 ] && grep -Eq '^wrong: clock: no 8 MHz crystal' "$tmp/out" && grep -Eq '^look: can_frames: ' "$tmp/out"
}
each_limit_is_looked_at() { # a line, what it says now, what is said of it
    local what to verdict
    while read -r what to verdict; do
        reseal zg changed "s/^$what [^ ]*/$what $to/" && judge changed >"$tmp/out"
        grep -Eq "^$verdict: $what: " "$tmp/out" || { echo "$what $to is not $verdict"; return 1; }
    done <<'L'
chip 0x419 wrong
chip 0x421 wrong
read_protection 0xff wrong
write_protected 0x10 wrong
options_stored differ look
cycles_per_tick 1.900 wrong
timer_offset 20 wrong
conversion_last 10499 wrong
supply_error -0.021 look
level_staircase 100.1 look
noise_gage_3 3.1 look
noise_gage_3 0.000 look
of_budget_predict 1.001 look
mat_updates 300 wrong
can_frames 99 wrong
memory_id 0xffffff wrong
memory_wrong 1 wrong
stack_overflow no_fault wrong
watchdog none wrong
low_speed 47.1 wrong
L
}
missing_is_wrong() { reseal zg changed '/^watchdog /d' && ! judge changed >"$tmp/out" && grep -q '^  wrong  *watchdog  *not reported ' "$tmp/out"; }
unknown_is_looked_at() { reseal zg changed 's/^low_speed/oxygen/' && ! judge changed >"$tmp/out" && grep -q '^look: oxygen: unknown line of' "$tmp/out"; }
cut_and_damaged() {
    sed '/^can_errors/,$d' "$tmp/zg.txt" >"$tmp/bad.txt" && fails_with 4 'the output stopped in section report after [0-9]+ lines; check cable' build/matrig board --serial "file:$tmp/bad.txt" bringup &&
        sed '/^can_errors/d' "$tmp/zg.txt" >"$tmp/bad.txt" && fails_with 4 'only 96 of 97 lines were received' build/matrig board --serial "file:$tmp/bad.txt" bringup &&
        sed 's/^watchdog 5/watchdog 4/' "$tmp/zg.txt" >"$tmp/bad.txt" && fails_with 4 'the received lines have the checksum' build/matrig board --serial "file:$tmp/bad.txt" bringup &&
        sed 's/^begin report 1/begin report 2/' "$tmp/zg.txt" >"$tmp/bad.txt" && fails_with 4 'format 2, but this matrig uses format 1' build/matrig board --serial "file:$tmp/bad.txt" bringup &&
        fails_with 4 'no output of a bring-up image' build/matrig board --serial file:README.md bringup &&
        sed 's/$/\r/' "$tmp/zg.txt" >"$tmp/dos.txt" && judge dos >"$tmp/out"
}
numbers_are_finite() { # nan and inf are words
    reseal zg changed 's/^low_speed [^ ]*/low_speed inf/; s/^supply [^ ]*/supply nan/' && build/matrig --json board --serial "file:$tmp/changed.txt" bringup >"$tmp/out"
    [ $? = 1 ] && grep -q '"value":"inf"' "$tmp/out" && grep -q '"value":"nan"' "$tmp/out"
}
json_says_the_same() {
    build/matrig --json board --serial "file:$tmp/zg.txt" bringup >"$tmp/out.json" && python3 - "$tmp/out.json" <<'P'
import json, sys
d = json.load(open(sys.argv[1]))
lines = {l["name"]: l for l in d["lines"]}
assert d["verdict"] == "look" and d["board"] == "00310042554D450F20343635" and d["section"] == "report" and len(d["lines"]) == 97
assert lines["watchdog"]["value"] == 500.999 and lines["watchdog"]["least"] == 340 and lines["watchdog"]["verdict"] == "ok"
assert lines["brown_out"]["verdict"] == "look" and "brown-out" in lines["brown_out"]["advice"]
assert lines["package"]["value"] is None and lines["chip"]["value"] == "0x413"
P
}
# A board by hand: the level that its supply allows, the ROM, the firmware; which then says the level, of the same option bytes.
brown_out_rom_and_firmware() { # 3 where 3.3 V are measured
    start $zg --flash "$tmp/flash"
    bringup brown-out >"$tmp/out" && grep -Eq 'supply +3.(299|300) V' "$tmp/out" && grep -Eq 'brown_out_set +written' "$tmp/out" && grep -Eq 'brown_out +3 level' "$tmp/out" &&
        bringup rom && build/matrig --quiet flash "pty:$sockets/tty" build/firmware/matrig.elf --baud 460800 &&
        build/matrig board --serial "pty:$sockets/tty" health >"$tmp/health" && grep -Eq 'brown-out +2.8 V' "$tmp/health"
    local status=$?
    stop
    cat "$tmp/out" "$tmp/health"
    return $status
}
brown_out_at_3_volts() { # level 2, of 2.5 V; and its boot ROM listens elsewhere
    start $discovery
    bringup brown-out >"$tmp/out" && grep -Eq 'supply +(2.999|3.000) V' "$tmp/out" && grep -Eq 'brown_out +2 level' "$tmp/out" &&
        fails_with 2 'boot ROM of this board cannot be reached on this port' build/matrig board --serial "pty:$sockets/tty" bringup rom
    local status=$?
    stop
    return $status
}
brown_out_of_a_wrong_supply() { # more than 5 % off the board's own: nothing is set
    start $1 --vdda $2
    bringup brown-out >"$tmp/out"
    local status=$?
    stop
    cat "$tmp/out"
    [ $status = 1 ] && grep -Eq 'brown_out_set +supply_not_the_boards' "$tmp/out" && grep -Eq 'brown_out +0 level' "$tmp/out" &&
        grep -q '^wrong: brown_out_set: the level was not set;' "$tmp/out"
}
memory_is_spared() { # nothing but an empty sector is touched; with none it says so and leaves all alone
    says zg memory_sector 4091 && says zg memory_wrong 0 && cmp "$tmp/nor.part" "$tmp/nor.part.was" &&
        says slow memory_sector none && cmp "$tmp/nor.full" "$tmp/nor.full.was" && judge slow >"$tmp/out" && grep -q '^look: memory_sector: no empty sector' "$tmp/out"
}
# A board of few words, at $sockets/few. When a word comes it says $tmp/few.txt up to byte FROM, then nothing for 5 s, then the rest up
# to byte TO. $tmp/words: what else it was told.
few_words() { # FROM TO
    rm -f "$sockets/few" "$tmp/words"
    python3 - "$sockets/few" "$tmp/few.txt" "$tmp/words" "$@" <<'P' &
import socket, sys, time
path, text, words, first, last = sys.argv[1:]
text = open(text, "rb").read()
s = socket.socket(socket.AF_UNIX)
s.bind(path)
s.listen(1)
c, _ = s.accept()
c.recv(100)
c.sendall(text[:int(first)])
time.sleep(5)
told = b""
try:
    c.sendall(text[int(first):int(last)])
    while b := c.recv(100):
        told += b
except OSError:
    pass
open(words, "wb").write(told)
P
    few=$!
    await test -S "$sockets/few"
}
a_word_is_said_once() { # within the section a silence of 5 s
    reseal zg few 's/^begin report/begin brown-out/'
    few_words 100 99999
    timeout 600 build/matrig board --serial "unix:$sockets/few" bringup brown-out >"$tmp/out"
    wait $few
    grep -q ' ok, ' "$tmp/out" && [ -e "$tmp/words" ] && [ ! -s "$tmp/words" ]
}
broken_off_is_said() { # text, and then nothing
    printf 'matrig bring-up\n' >"$tmp/few.txt"
    few_words 16 16
    fails_with 3 'sent 16 bytes, but they do not answer `report`: .*cable' build/matrig board --serial "unix:$sockets/few" bringup || return 1
    [ -n "${MATRIG_LONG:-}" ] || return 0 # half a minute of silence
    cp "$tmp/zg.txt" "$tmp/few.txt"
    few_words 100 300
    fails_with 4 'the output stopped in section report after 300 bytes: .*cable' build/matrig board --serial "unix:$sockets/few" bringup
}
unplugged() { # the device goes away when the word is said: it failed, and the usage is right
    python3 - "$sockets/port" <<'P' &
import os, sys, tty
ours, theirs = os.openpty()
tty.setraw(theirs)
os.symlink(os.ttyname(theirs), sys.argv[1])
os.read(ours, 100)
os.unlink(sys.argv[1])
P
    local port=$!
    await test -L "$sockets/port"
    fails_with 3 'the device is disconnected: serial:.*; plug it in again' build/matrig board --serial "serial:$sockets/port" bringup
    local status=$?
    wait $port
    return $status
}
nobody_there() { # the firmware speaks at another rate
    timeout 600 build/matrig-board --elf build/firmware/matrig.elf --serial "unix:$sockets/s" --speed real --for 30 2>"$tmp/board.err" &
    fails_with 3 'no bring-up image answered at 115200 baud \([0-9]+ bytes received\): unix:.*bring-up.md' build/matrig board --serial "unix:$sockets/s" bringup
    local status=$?
    kill %% 2>/dev/null
    return $status
}
silly_words() {
    fails_with 2 "unknown action of bringup: 'x'" build/matrig board --serial file:x bringup x && fails_with 2 'no link' build/matrig board bringup &&
        fails_with 2 'the link is a file' build/matrig board --serial file:x bringup rom
}

check "board zg says all of it, and all is well but the brown-out level" whole_and_in_order zg 96
check "board discovery likewise" whole_and_in_order discovery 74
check "board nucleo446 likewise" whole_and_in_order nucleo446 96
check "each board its own inputs and supply" each_its_inputs
check "instructions of the predictor are those that the budget assumes" budget_holds
check "oscillators are measured as they are" oscillators_as_given
check "a stack that overflows is a fault, told with its address" stack_is_caught
check "without a crystal: wrong, exit 1, and what follows from it" wrong_is_exit_1
check "each limit is looked at" each_limit_is_looked_at
check "a line that is missing is wrong" missing_is_wrong
check "a line that nobody knows is said" unknown_is_looked_at
check "cut off, damaged, of another format, no text at all" cut_and_damaged
check "no number but finite ones" numbers_are_finite
check "the same as JSON" json_says_the_same
check "the brown-out level of 3.3 V; then the boot ROM on a word, and the firmware" brown_out_rom_and_firmware
check "the brown-out level of 3.0 V; no boot ROM where it does not listen" brown_out_at_3_volts
check "no brown-out level of a supply that is not the board's" brown_out_of_a_wrong_supply $discovery 3.3
check "the memory test spares what is kept" memory_is_spared
check "another image answers nothing that is understood" nobody_there
check "a word that is obeyed is not said again" a_word_is_said_once
check "what breaks off is said so" broken_off_is_said
check "a line that is unplugged is a device that failed" unplugged
check "silly words" silly_words
finish
