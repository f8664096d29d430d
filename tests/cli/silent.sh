#!/usr/bin/env bash
# Who answers matrig log, and that it fell silent, idle or armed: both are said, also into a pipe.
. "$(dirname "$0")/tap.sh"
work=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'kill -CONT $board; kill $board $log; wait; rm -rf "$work"' EXIT
mkfifo "$work/typed"
build/matrig-board --elf build/firmware/matrig.elf --can "unix:$work/can" --serial "unix:$work/serial" --speed real --for 600 2>"$work/board.err" &
board=$!
await test -S "$work/serial"
timeout 600 build/matrig log --commands --can "unix:$work/can" --serial "unix:$work/serial" --db "$work/x.db" <"$work/typed" 2>&1 >"$work/out" | cat >"$work/err" &
log=$!
exec 9>"$work/typed"
said() { grep -Eq -- "$1" "$work/err"; }
times() { [ "$(grep -c -- "$1" "$work/err")" -eq "$2" ]; }
answers() {
    await said '^matrig: board [0-9A-F]{24}, firmware [0-9.]+, on CAN and serial: idle, waiting to be armed$' && times '^matrig: board' 1
}
falls_silent() { # STATE TIMES MORE-S: the log's own time of the silence is 1.7 s, and at most 0.5 s in which it did not run
    local line
    kill -STOP $board
    await times 'board is SILENT' "$2" && line=$(grep 'board is SILENT' "$work/err" | tail -n 1)
    sleep "$3"
    kill -CONT $board
    echo "$line"
    [[ $line =~ SILENT:\ no\ data\ for\ (1\.[789]|2\.[012])\ s,\ last\ state\ $1\; ]] && await times "sends again: $1" 1 && ! said 'the other link does'
}
is_armed() {
    local i
    for ((i = 1; i < 100; i++)); do # not before the black box is ready
        printf 'arm 7\nyes\n' >&9
        await times 'yes: matrig: arm\(ed\| refused.*\)$' $i || return 1
        said 'yes: matrig: armed$' && return 0
        sleep 0.2
    done
}
check "who answered, its firmware and what it does" answers
check "a board that falls silent while idle is told within 2 s, and when it is back" falls_silent 'idle, waiting to be armed' 1 0
check "it is armed" is_armed
check "a board that falls silent while armed is told within 2 s" falls_silent 'armed, landing 7' 2 3
finish
