#!/usr/bin/env bash
# Arming from a terminal: matrig board arm and disarm, over CAN beside a running log and over serial; lines typed into matrig log.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
matrig=build/matrig
work=$(mktemp -d /tmp/matrig.XXXXXX)
pids=()
trap 'kill "${pids[@]}" 2>/dev/null; wait; rm -rf "$work"' EXIT

cat >"$work/terminal.py" <<'P'
# terminal.py COMMAND...: runs it on a terminal of its own, types what comes on standard input there, shows what it says.
import os, pty, select, sys
child, terminal = pty.fork()
if child == 0:
    os.execv(sys.argv[1], sys.argv[1:])
typed = sys.stdin.fileno()
watched = [terminal, typed]
while True:
    for fd in select.select(watched, [], [])[0]:
        try:
            data = os.read(fd, 4096)
        except OSError:
            sys.exit(0)
        if fd == terminal:
            os.write(1, data)
        elif data:
            os.write(terminal, data)
        else:
            watched = [terminal]
P

timeout 600 build/matrig-board --elf $elf --can "unix:$work/board" --serial "unix:$work/serial" --speed real 2>"$work/board.err" &
pids+=($!)
timeout 600 python3 tests/link/can_bus.py "$work/board" "$work/can" &
pids+=($!)
mkfifo "$work/typed"
timeout 600 $matrig log --can "unix:$work/can" --serial "unix:$work/serial" --db "$work/x.db" --commands <"$work/typed" >"$work/log.out" 2>"$work/log.err" &
log=$!
pids+=($log)
exec 8>"$work/typed"

said() { # PATTERN, by the log
    await grep -Eq -- "$1" "$work/log.err" && return 0
    cat "$work/log.err"
    return 1
}
over_can() { timeout 600 $matrig "$@" --can "unix:$work/can"; }
armed_when_ready() { # COMMAND...: the black box is looked through for a second or two first
    local i
    for ((i = 0; i < 40; i++)); do
        "$@" >"$tmp/out" 2>"$tmp/err" && break
        grep -q 'black box is' "$tmp/err" || break
        sleep 0.2
    done
    cat "$tmp/out" "$tmp/err"
    grep -q '^armed for landing 12: ' "$tmp/out"
}
refused_when_armed() { fails_with 2 'refused `arm`: unix:.*can; the board is armed, with landing 12: wait for the end of the landing, or disarm the board' $matrig board arm 13 --can "unix:$work/can"; }
refused_in_json() {
    over_can --json board arm 2>/dev/null >"$tmp/refused.json"
    [ $? = 2 ] && python3 -c '
import json, sys
d = json.load(open(sys.argv[1]))
assert d["command"] == "arm" and d["done"] is False and d["state"] == "armed" and d["landing"] == 12 and "refused" in d["error"], d' "$tmp/refused.json"
}
disarmed() {
    over_can --json board disarm >"$tmp/disarmed.json" || return 1
    python3 -c '
import json, sys
d = json.load(open(sys.argv[1]))
assert d == {"command": "disarm", "done": True, "state": "idle", "landing": 12, "error": None}, d' "$tmp/disarmed.json"
}
counts_on() { over_can board arm >"$tmp/out" && cat "$tmp/out" && grep -q '^armed for landing 13: ' "$tmp/out" && over_can board disarm; }
answers_are_kept() { # accepted (status 0): armed 12, 13, 14, 21 and 24, each disarmed; refused: 13 and a JSON one, and 22, typed
    python3 - "$work/x.db" <<'P'
import sqlite3, sys
db = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
rows = db.execute("SELECT code, detail FROM events WHERE kind = 'ack' AND code IN (2, 3)").fetchall()
NOT_NOW, WAIT = -13, -18
signed = [(c, d - 256 if d > 127 else d) for c, d in rows]
print(signed)
assert signed.count((2, 0)) == 5 and signed.count((3, 0)) == 5 and signed.count((2, NOT_NOW)) == 3
assert all(d in (0, NOT_NOW, WAIT) for _, d in signed)
P
}
others_are_told() { # an armed board is told to go into its boot ROM by a frame from nobody, five times
    over_can board arm 14 && python3 - "$work/can" <<'P' || return 1
import socket, struct, sys
s = socket.socket(socket.AF_UNIX)
s.connect(sys.argv[1])
for tag in range(5):
    s.sendall(struct.pack("<IB3x8s", 0x400, 8, bytes([6, 0, tag, 0, 0, 0, 0, 0])))
P
    said 'another program sent "bootrom"; the board refused it: not allowed in the present state$' && over_can board disarm &&
        said 'another program sent "arm"; the board executed it$' && said 'another program sent "disarm"; the board executed it$' &&
        said 'another program sent "arm"; the board refused it: not allowed in the present state' && [ "$(grep -c '"bootrom"' "$work/log.err")" = 1 ]
}
orders_are_kept() { # who gave each, and in which landing; a file that is logged does not say who
    python3 - "$work/x.db" <<'P' && $matrig show "$work/x.db" 1 >"$tmp/show" && head -n 5 "$tmp/show" && grep -q '^  *disarm, sent by another program at .* s: executed' "$tmp/show" && ! grep 'the page' "$work/log.err"
import sqlite3, sys
db = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
rows = [(n, c, d if d < 128 else d - 256, v) for n, c, d, v in
        db.execute("SELECT board_landing, code, detail, value FROM events LEFT JOIN landings ON landings.id = landing WHERE kind = 'order'")]
print(rows)
for landing in 12, 13, 14, 24: # armed and disarmed by matrig board
    assert (landing, 2, 0, 0) in rows and (landing, 3, 0, 0) in rows, landing
assert (21, 2, 0, 1) in rows and (21, 3, 0, 1) in rows and (21, 2, -13, 1) in rows # typed
assert rows.count((14, 6, -13, 0)) == 1 and not [r for r in rows if r[1] in (1, 12, 14)]
P
}
typed_and_meant() {
    echo 'arm 21' >&8
    said 'arm the board for landing 21\? .*yes: ' && echo 'yes' >&8 && said 'matrig: armed$'
}
typed_and_refused() { echo 'arm 22' >&8 && said 'arm the board for landing 22\?' && echo ' yes ' >&8 && said 'arm refused: the board is armed, in a landing'; }
typed_disarm_asks() { echo 'disarm' >&8 && said 'disarm the board\? Its state is armed; the recording then ends' && echo yes >&8 && said 'matrig: disarmed$'; }
not_yes_sends_nothing() { # after it the board still arms for 24
    echo 'arm 23' >&8 && said 'arm the board for landing 23\?' && echo y >&8 && said 'the answer was not yes.: nothing was sent' &&
        over_can board arm 24 && over_can board disarm && sleep 0.3 && ! $matrig landing "$work/x.db" | grep -q 'landing 23,'
}
doubts_are_repeated() { # what advise, survey and ready had found; an order in the place of yes is obeyed as one
    sqlite3 -cmd '.timeout 20000' "$work/x.db" "insert into advices(made_us, verdict, reason, after_run) select 1 + max(armed_us), 'against', 'a zone is likely', 1 from landings;
        insert into gage_surveys(made_us, edges, error_in) values(1, 'left', 0.005); insert into readiness(board_uid, kind, made_us, verdict, checks) select board_uid, 'ready', 1772600000000000, 'go', '{}' from landings limit 1"
    echo 'arm 25' >&8 && said 'matrig: matrig advise recommends against the next landing: a zone is likely$' && said 'matrig: survey 1 is not finished; continue the survey with matrig survey DB$' &&
        said 'matrig: the result of matrig ready was go at 2026-03-04 04:53 UTC, more than 12 h ago$' && said 'arm the board for landing 25\?' && echo 'arm 26' >&8 && said 'arm the board for landing 26\?' && echo 'n' >&8 || return 1
    await eval '[ "$(grep -c "the answer was not yes.: nothing was sent" "$work/log.err")" = 3 ]'
    sqlite3 -cmd '.timeout 20000' "$work/x.db" "insert into advices(made_us, verdict, reason, after_run) select 2 + max(armed_us), 'clear', 'c', 1 from landings; update gage_surveys set ended_us = 2"
}
a_person_is_asked() { # at a terminal; `y` is no yes
    printf 'y\n' | TERM=dumb timeout 600 python3 "$work/terminal.py" $matrig board arm 27 --can "unix:$work/can" | tee "$tmp/asked" | grep 'Arm the board. It records until the gear has stopped .*yes: ' &&
        await grep -q 'the answer was not yes.: nothing was sent' "$tmp/asked"
}
typed_nonsense() {
    local i=0 line
    for line in 'reset' 'arm 70000' 'arm -1' 'arm 1 2' 'disarm 3' 'arm x'; do
        echo "$line" >&8
        said "not a command: '$line'; type arm \[N\]" || return 1
    done
    printf '%0600d\n' 0 >&8
    said "not a command: '000"
}
log_goes_on() { # without its input, to the end; nothing but what was meant reached the board
    exec 8>&-
    sleep 0.3
    kill -0 $log && kill -INT $log && wait $log && [ "$($matrig landing "$work/x.db" | sed 's/.*: landing \([0-9]*\),.*/\1/' | tr '\n' ' ')" = "12 13 14 21 24 " ]
}
silly() {
    fails_with 2 'no link: matrig board arm needs --can LINK or --serial LINK' $matrig board arm && fails_with 2 'uses only one; leave out --can or --serial' $matrig board disarm --can can:can0 --serial serial:/dev/x &&
        fails_with 2 'the landing' $matrig board arm 70000 --can can:can0 && fails_with 2 'whole number, not .1.5' $matrig board arm 1.5 --can can:can0 &&
        fails_with 2 'disarm takes no number: .3' $matrig board disarm 3 --can can:can0 && fails_with 2 'the link is a file: file:/dev/null' $matrig board arm --can file:/dev/null &&
        fails_with 2 'listen and --commands' $matrig log --can can:can0 --db "$tmp/no.db" --listen --commands
}
over_serial() { # the board alone, at one end of a line
    timeout 600 build/matrig-board --elf $elf --serial "unix:$work/alone" --speed real 2>"$work/alone.err" &
    pids+=($!)
    await test -S "$work/alone"
    timeout 600 $matrig board arm 12 --serial "unix:$work/alone" >"$tmp/out" 2>"$tmp/err"
    local status=$?
    cat "$tmp/out" "$tmp/err"
    [ $status = 0 ] && grep -q '^armed for landing 12: ' "$tmp/out" && return
    [ $status = 3 ] && grep -q 'black box is' "$tmp/err"
}
on_a_terminal() { # a file is no board: what is typed is taken, and said to go nowhere
    mkfifo "$work/keys" "$work/slow"
    sleep 20 >"$work/slow" &
    pids+=($!)
    TERM=dumb timeout 600 python3 "$work/terminal.py" $matrig log --can "file:$work/slow" --db "$work/t.db" --for 2 <"$work/keys" >"$tmp/terminal" 2>&1 &
    local pid=$!
    exec 9>"$work/keys"
    await grep -q 'to arm the board, press Enter' "$tmp/terminal"
    echo 'arm 5' >&9
    wait $pid
    exec 9>&-
    cat "$tmp/terminal"
    grep -q 'to arm the board, press Enter and type arm' "$tmp/terminal" && grep -q 'no hello from a board yet: nothing was sent' "$tmp/terminal"
}

check "armed over CAN while a log holds the links" armed_when_ready over_can board arm 12
check "armed already: refused, and it says for which landing" refused_when_armed
check "the refusal as JSON" refused_in_json
check "disarmed" disarmed
check "without a number the board counts on" counts_on
check "what another program orders is told, a repetition once" others_are_told
check "typed into the log: asked once more, then armed" typed_and_meant
check "typed while armed: refused, and why" typed_and_refused
check "typed disarm asks too while something is recorded" typed_disarm_asks
check "anything but yes sends nothing" not_yes_sends_nothing
check "what speaks against a landing is repeated when it is armed" doubts_are_repeated
check "board arm asks a person for yes, too" a_person_is_asked
check "what is no command" typed_nonsense
check "the log goes on when its input ends; its landings are those that were meant" log_goes_on
check "its campaign has the board's answers, one of each command" answers_are_kept
check "and who ordered what, with the landing" orders_are_kept
check "wrong usage" silly
check "over serial" over_serial
check "on a terminal lines are taken without --commands" on_a_terminal
finish
