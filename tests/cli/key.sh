#!/usr/bin/env bash
# A board's key, from its setting to its clearing: the file on this computer, orders that are proven unseen, over CAN, over serial and by
# a running log; a stranger's day on the bus, with proofs that Python computes; a landing with proven and refused orders, replayed.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
work=$(mktemp -d /tmp/matrig.XXXXXX)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; wait; rm -rf "$work"' EXIT
export XDG_CONFIG_HOME=$work/config
can=unix:$work/can serial=unix:$work/serial

cat >"$work/stranger.py" <<'P'
# stranger.py BUS KEYFILE: with the key in hand what one may, and without it what one may not.
import hashlib, os, struct, sys
sys.path.insert(0, "tests/link")
from can_bus import connect
bus = connect(sys.argv[1])
key = bytes.fromhex(open(sys.argv[2]).read())
SURVEY, WANTS, LOCKED = 5, -22, -23
heard, rest, uid, tag = {}, b"", {}, 30000
def turn():
    global rest
    rest += bus.recv(65536)
    while len(rest) >= 16:
        number, length, data = struct.unpack("<IB3x8s", rest[:16])
        rest = rest[16:]
        heard[number & 0x7ff] = data[:length]
        if number & 0x7ff == 0xb0:
            code, status, of = struct.unpack("<BbH", data[:4])
            answers[of] = status
answers = {}
def until(number):
    heard.pop(number, None)
    while number not in heard:
        turn()
    return heard[number]
def order(segment=3, proof=None):
    global tag
    tag += 1
    command = struct.pack("<BBHi", SURVEY, segment, tag, 100)
    if callable(proof):
        proof = proof(command)
    if proof:
        bus.sendall(struct.pack("<IB3x8s", 0x3ff, 8, proof))
    bus.sendall(struct.pack("<IB3x8s", 0x400, 8, command))
    while tag not in answers:
        turn()
    return answers[tag]
def prove(command, by=None, of=None, chip=None):
    return hashlib.blake2s((of or heard[0x1fe]) + command + (chip or uid), digest_size=8, key=by or key).digest()
uid = until(0x1f1)
uid += until(0x1f2)[:4]
old = until(0x1fe)
def expect(what, got, wanted):
    print(what, got)
    assert got == wanted, what
expect("without a proof", order(), WANTS)
until(0x1fe)
expect("a proof", order(proof=prove), 0)
expect("an old nonce", order(proof=lambda c: prove(c, of=old)), WANTS)
until(0x1fe)
kept = []
def keep(command):
    kept.append(prove(command))
    return kept[0]
expect("a proof, overheard", order(proof=keep), 0)
expect("said again", order(proof=kept[0]), WANTS)
until(0x1fe)
expect("of another board", order(proof=lambda c: prove(c, chip=bytes(12))), WANTS)
expect("a proof after it", order(proof=prove), 0)
until(0x1fe)
for i in range(3):
    expect("a guess", order(proof=os.urandom(8)), WANTS)
expect("a proof behind three", order(proof=prove), LOCKED)
for i in range(2):
    until(0x1fe)
expect("a second later", order(proof=prove), 0)
P

cat >"$work/unplugged.py" <<'P'
# unplugged.py BOARD HOST: a serial line that is pulled out when the host has sent a key and the order to set it: 9 frames.
import select, socket, sys, time
board, door = socket.socket(socket.AF_UNIX), socket.socket(socket.AF_UNIX)
door.bind(sys.argv[2])
door.listen(1)
host = door.accept()[0]
while board.connect_ex(sys.argv[1]):
    time.sleep(0.02)
frames = 0
while frames < 9:
    for s in select.select([board, host], [], [])[0]:
        data = s.recv(65536)
        (board if s is host else host).sendall(data)
        frames += data.count(b"\0") if s is host else 0
P

boot() { # BOARD-OPTION...: the board whose key is in $work/nor, on a bus
    build/matrig-board --elf build/firmware/matrig.elf --nor "$work/nor" --can "unix:$work/board" --speed real "$@" 2>"$work/board.err" &
    board=$!
    python3 tests/link/can_bus.py "$work/board" "$work/can" &
    bus=$!
    pids=($board $bus)
}
by_serial() { # BOARD-OPTION... -- COMMAND...: with a serial line in its place, which one program has
    with_board --nor "$work/nor" --serial "$serial" --speed real "$@"
}
off() {
    kill $board
    wait $board
    kill $bus 2>/dev/null
    wait $bus
    rm -f "$work/can" "$work/board" "$work/serial"
} 2>/dev/null
keys() { ls "$work/config/matrig" 2>/dev/null | wc -l; }
says() {
    by_serial -- $matrig board --serial "$serial" >"$tmp/out" && cat "$tmp/out" && grep -q "orders.*$1" "$tmp/out"
}

check "a board without a key says that its bus is open" says "open bus"

refused_without_jumper() {
    by_serial -- $matrig board --serial "$serial" key new 2>"$tmp/err"
    [ $? = 2 ] && cat "$tmp/err" && grep -q 'refused `key-set`: .*; only over serial and with the maintenance jumper' "$tmp/err"
}
check "a key is set with the maintenance jumper alone" refused_without_jumper
check "... and nothing is left of it" test "$(keys)" = 0
check "a key is made and set" by_serial --jumper -- $matrig board --serial "$serial" key new
file=$(ls "$work"/config/matrig/*.key)
check "... into a file that its owner alone may read" test "$(stat -c %a "$file") $(wc -c <"$file")" = "600 65"
check "the board says that it has one" says "a key is set"
cp -p "$file" "$work/first"
check "another one takes its place" by_serial --jumper -- $matrig board --serial "$serial" key new
check "... in the file too" eval '! cmp -s "$file" "$work/first" && [ "$(keys)" = 1 ]'

cp -p "$file" "$work/kept"
unplugged() {
    python3 "$work/unplugged.py" "$work/serial" "$work/line" &
    pids=($!)
    await test -S "$work/line"
    by_serial --jumper -- $matrig board --serial "unix:$work/line" key new 2>"$tmp/err"
    [ $? = 3 ] && cat "$tmp/err" && grep -q 'the board may have the new key, but this computer did not store it: repeat key new' "$tmp/err"
}
check "who does not get the board's answer to a new key is told what that means" unplugged
check "... and the file of the key before is kept" cmp "$file" "$work/kept"
check "it is repeated" by_serial --jumper -- $matrig board --serial "$serial" key new

boot
check "a stranger is not obeyed, who has the key is" python3 "$work/stranger.py" "$work/can" "$file"
chmod 644 "$file"
check "a file that others may read is refused" fails_with 3 'other users may read the key of the board: .*; run chmod 600' $matrig board --can "$can" arm 12
chmod 600 "$file"
cp -p "$file" "$work/kept"
tr -d '\n' <"$work/kept" | cat - "$work/kept" >"$file"
check "more than 64 digits are no key" fails_with 4 'the key file does not contain 64 hexadecimal digits' $matrig board --can "$can" arm 12
cp -p "$work/kept" "$file"
check "a computer without the key is told where it belongs" fails_with 2 'accepts commands only with its key, and the key file is missing: .*none/matrig/.*key' \
    env XDG_CONFIG_HOME="$work/none" $matrig board --can "$can" arm 12
mkdir -p "$work/other/matrig"
cp -p "$work/first" "$work/other/matrig/$(basename "$file")"
check "an old key is not the board's" fails_with 2 'replace this file, which does not contain the key of the board: .*other/matrig/.*key' env XDG_CONFIG_HOME="$work/other" $matrig board --can "$can" arm 12
off

# a landing: armed and disarmed by the log, a stranger's order in it
boot --serial "$serial"
mkfifo "$work/typed"
$matrig log --can "$can" --serial "$serial" --db "$work/x.db" --commands <"$work/typed" >"$work/log.out" 2>"$work/log.err" &
log=$!
pids+=($log)
exec 8>"$work/typed"
said() { await grep -Eq -- "$1" "$work/log.err" && return 0; cat "$work/log.err"; return 1; }
typed() {
    local i
    said 'on CAN and serial' || return 1
    for ((i = 0; i < 20; i++)); do
        echo 'arm 5' >&8
        echo 'yes' >&8
        await eval '[ "$(grep -cE "matrig: (armed|arm refused)" "$work/log.err")" -gt '$i' ]'
        grep -q 'matrig: armed' "$work/log.err" && return 0
    done
    cat "$work/log.err"
    return 1
}
check "the log arms, and proves it unseen" typed
python3 - "$work/can" <<'P'
import socket, struct, sys
s = socket.socket(socket.AF_UNIX)
s.connect(sys.argv[1])
s.sendall(struct.pack("<IB3x8s", 0x400, 8, bytes([3, 0, 7, 0, 0, 0, 0, 0])))
P
check "another program's order is refused, and the log says why" said "another program sent \"disarm\"; the board refused it: the command needs the board's key"
await eval '[ "$(sqlite3 "$work/x.db" "select count(*) from runways" 2>/dev/null)" = 1 ]' # whole: a replay begins with it
echo disarm >&8
said 'disarm the board\?' && echo yes >&8
check "the log disarms" said 'matrig: disarmed'
kill -INT $log
wait $log
exec 8>&-
off
$matrig show "$work/x.db" 1 >"$tmp/show"
check "who ordered what is in the campaign" grep -q "disarm, sent by another program at .* s: refused, the command needs the board's key" "$tmp/show"
check "the landing replays, proofs or not" $matrig replay "$work/x.db" 1
check "the report says that a key was set" bash -c "$matrig report '$work/x.db' -o '$work/x.html' && grep -q 'a key is set' '$work/x.html'"

python3 - "$work/nor" "$file" <<'P' # a bit of the key is lost
import sys
memory, key = bytearray(open(sys.argv[1], "rb").read()), bytes.fromhex(open(sys.argv[2]).read())
assert memory.count(key) == 1
memory[memory.find(key) + 9] ^= 1
open(sys.argv[1], "r+b").write(memory)
P
boot
check "a damaged key is told from a missing one" fails_with 2 'because its key is damaged: .*; set a new key with matrig board key new' $matrig board --can "$can" arm 12
off
check "a lost key is cleared, without it" by_serial --jumper -- env XDG_CONFIG_HOME="$work/none" $matrig board --serial "$serial" key clear
check "... and the bus is open again" says "open bus"
boot
check "... for orders too" await env XDG_CONFIG_HOME="$work/none" $matrig board --can "$can" arm 12
off
finish
