#!/usr/bin/env bash
# matrig-board as a program: it ends, with a line that says why, whatever the firmware or a host does; and its options.
. "$(dirname "$0")/tap.sh"
board=build/matrig-board
elf=build/firmware/matrig.elf
images=build/tests/hil/images
trap 'kill $(jobs -p) 2>/dev/null' EXIT

stopped_with() { # CODE PATTERN COMMAND...: as fails_with, with the line of statistics after the message
    local code=$1 pattern=$2 status
    shift 2
    timeout 600 "$@" >"$tmp/out" 2>"$tmp/err" </dev/null
    status=$?
    echo "exit $status; stderr:"
    cat "$tmp/err"
    [ "$status" -eq "$code" ] && [ "$(wc -l <"$tmp/err")" -eq 2 ] && head -n 1 "$tmp/err" | grep -Eq -- "$pattern" &&
        tail -n 1 "$tmp/err" | grep -q 'virtual in'
}
wall_limit() { stopped_with 3 'wall-clock limit ended the run at .*--wall-limit' $board --elf $elf --wall-limit 0.5; }
blocked_file() { # a pipe that nobody reads: opening it blocks
    mkfifo "$tmp/pipe"
    fails_with 3 'wall-clock limit was reached before all links' $board --elf $elf --can "file:$tmp/pipe" --wall-limit 0.5
}
blocked_write() { # one that is open at the other end and never read: write() blocks for good
    rm -f "$tmp/pipe" && mkfifo "$tmp/pipe"
    sleep 30 <"$tmp/pipe" &
    timeout 10 dd if=/dev/zero of="$tmp/pipe" bs=64K count=1 || return 1 # it is full
    fails_with 3 'the run continues several seconds .* blocks' $board --elf $elf --for 30 --serial "file:$tmp/pipe" --can "file:$tmp/x" \
        --rig tests/runs/landing5.run --wall-limit 0.5
}
host_does_not_read() { # one that connects and then reads nothing; the board talks without a break
    $board --elf $images/talk.elf --serial "unix:$tmp/serial.socket" --stall 0.3 --for 3000 2>"$tmp/err" &
    local board_pid=$! host_pid status
    await test -S "$tmp/serial.socket"
    timeout 600 perl -MSocket -e '
        socket(my $s, AF_UNIX, SOCK_STREAM, 0); connect($s, pack_sockaddr_un($ARGV[0])) or die "$!"; sleep 50' "$tmp/serial.socket" &
    host_pid=$!
    wait $board_pid
    status=$?
    kill $host_pid
    cat "$tmp/err"
    [ $status -eq 3 ] && grep -q 'not read from .* for 0.3 s; .*--stall' "$tmp/err"
}
paced() { # never ahead of the wall clock; how late is told, and not judged here
    local from to
    from=$(date +%s%N)
    $board --elf $elf --for 3 --speed real 2>"$tmp/err" || return 1
    to=$(date +%s%N)
    cat "$tmp/err"
    [ $((to - from)) -ge 3000000000 ] && grep -Eq 'at most [0-9.]+ ms late' "$tmp/err"
}
any_speed_same_bytes() {
    $board --elf $elf --can "file:$tmp/max.can" --serial "file:$tmp/max.serial" --for 1 &&
        $board --elf $elf --can "file:$tmp/real.can" --serial "file:$tmp/real.serial" --for 1 --speed real &&
        [ -s "$tmp/max.serial" ] && cmp "$tmp/max.can" "$tmp/real.can" && cmp "$tmp/max.serial" "$tmp/real.serial"
}
mistakes() { # one line, and the right exit code
    bad() { fails_with "$1" "$2" $board "${@:3}"; }
    bad 2 'nothing to do' && bad 3 'no-such.elf' --elf no-such.elf && bad 2 'unknown option --nonsense' --elf $elf --nonsense 1 &&
        bad 2 '--elf needs a value' --elf && bad 2 'unexpected argument .elf.' elf && bad 4 'not an ELF' --elf README.md && bad 4 'not for a 32-bit' --elf $board &&
        bad 2 '--speed cannot be .fast.' --elf $elf --speed fast && bad 2 '--for cannot be' --elf $elf --for -1 && bad 2 '--seed cannot be' --elf $elf --seed x &&
        bad 2 '--lsi cannot be' --elf $elf --lsi 5 && bad 2 'not a link' --elf $elf --can vcan0 && bad 3 'cannot write' --elf $elf --serial "file:$tmp/no/file" &&
        bad 3 'no-such.run' --elf $elf --rig no-such.run && bad 4 'does not begin with' --elf $elf --rig $elf
}
wrong_folder() { # where it was looked for, and where the file of that name is
    fails_with 3 "No such file or directory in the folder $(realpath "$tmp"); the file that was installed with matrig is $PWD/tests/runs/landing1.run" \
        env -C "$tmp" "$PWD/$board" --elf "$PWD/$elf" --rig tests/runs/landing1.run &&
        fails_with 3 "No such file or directory in the folder $PWD; give a file that matrig wrote" $board --elf $elf --rig no-such.run
}
given_twice() {
    fails_with 2 '--for is given twice; give it once' $board --elf $elf --for 1 --for 1 &&
        fails_with 2 '--trace is given twice' $board --trace --elf $elf --trace
}
same_path() {
    fails_with 2 '--can and --serial have the same file .*/x; give two different files' \
        $board --elf $elf --can "file:$tmp/x" --serial "unix:$tmp/x" --for 1 &&
        cp tests/runs/landing1.run "$tmp/some.run" &&
        fails_with 2 '--rig and --serial have the same file .*some.run' $board --elf $elf --rig "$tmp/some.run" --serial "file:$tmp/some.run" &&
        cmp tests/runs/landing1.run "$tmp/some.run" &&
        $board --elf $elf --can file:/dev/null --serial file:/dev/null --for 0.1
}
same_file() { # an input under two names, and records over what cannot be made again
    cp tests/runs/landing1.run "$tmp/one.run" && ln -f "$tmp/one.run" "$tmp/other.run" &&
        printf 'SQLite format 3\0 and so on' >"$tmp/campaign.db" && cp "$tmp/campaign.db" "$tmp/campaign.copy" &&
        fails_with 2 '--rig and --vcd have the same file' $board --elf $elf --rig "$tmp/one.run" --vcd "$tmp/other.run" &&
        fails_with 2 '--replay and --vcd have the same file' $board --elf $elf --replay "$tmp/one.run" --vcd "$tmp/one.run" &&
        fails_with 2 '--can and --gdb have the same file' $board --elf $elf --can "unix:$tmp/s" --gdb "unix:$tmp/s" &&
        fails_with 2 '--profile would overwrite a database' $board --elf $elf --profile "$tmp/campaign.db" &&
        fails_with 2 '--vcd would overwrite a database' $board --elf $elf --vcd "$tmp/campaign.db" &&
        ln -sf campaign.db "$tmp/linked" && fails_with 2 '--profile would overwrite a database' $board --elf $elf --profile "$tmp/linked" &&
        fails_with 2 'would overwrite a database' $board --elf $elf --can "file:$tmp/campaign.db" --for 0.1 &&
        fails_with 4 'is a database or a program and would be overwritten' $board --elf $elf --flash "$tmp/campaign.db" --for 0.1 &&
        cmp tests/runs/landing1.run "$tmp/one.run" && cmp "$tmp/campaign.db" "$tmp/campaign.copy"
}
memory_files() { # a symbolic link stays one
    ln -sf kept "$tmp/kept.link" && printf '\xff' >"$tmp/kept" &&
        $board --elf $elf --flash "$tmp/kept.link" --for 0.1 && [ -L "$tmp/kept.link" ] && [ "$(stat -c %s "$tmp/kept")" = 1048576 ]
}
listened_on() { # a second board does not take the first one's socket from it
    local first status=0
    $board --elf $elf --can "unix:$tmp/taken" --for 0.1 2>"$tmp/first" &
    first=$!
    await test -S "$tmp/taken"
    fails_with 3 '--can: another program listens on .*taken; end that program' $board --elf $elf --can "unix:$tmp/taken" --for 0.1 &&
        fails_with 3 '--gdb: another program listens on' $board --elf $elf --gdb "unix:$tmp/taken" --for 0.1 || status=1
    kill -9 $first && ! wait $first && [ $status -eq 0 ] && [ -S "$tmp/taken" ] || return 1
    $board --elf $elf --can "unix:$tmp/taken" --for 0.1 --wall-limit 0.5 2>"$tmp/err" # what a dead one left is taken
    cat "$tmp/err"
    grep -q 'check that a host is running' "$tmp/err"
}
foreign_link() { # a symbolic link is replaced only when an earlier pty: left it
    ln -sf one.run "$tmp/tty"
    fails_with 3 'tty exists and is not a link to a pseudo-terminal' $board --elf $elf --serial "pty:$tmp/tty" --for 0.1 &&
        [ "$(readlink "$tmp/tty")" = one.run ]
}
closed_stderr() { # what would be said there must not land in an output file
    $board --elf $elf --can "file:$tmp/a.can" --serial "file:$tmp/a.serial" --for 0.2 &&
        $board --elf $elf --can "file:$tmp/b.can" --serial "file:$tmp/b.serial" --for 0.2 <&- >&- 2>&- &&
        [ -s "$tmp/a.serial" ] && cmp "$tmp/a.can" "$tmp/b.can" && cmp "$tmp/a.serial" "$tmp/b.serial"
}

rules() { # what is held at the pins: names, files, what a broken rule does to the exit code
    local old=build/tests/old/339b9da.elf
    fails_with 2 "--rules cannot be .count:SELECT_LOW." $board --elf $elf --rules count:SELECT_LOW --for 0.1 &&
        fails_with 2 "--rules cannot be .count:." $board --elf $elf --rules count: --for 0.1 &&
        fails_with 2 '--margins would overwrite a database' $board --elf $elf --margins "$tmp/campaign.db" --for 0.1 &&
        fails_with 3 '--margins: cannot write .*nowhere/margins' $board --elf $elf --margins "$tmp/nowhere/margins" --for 0.1 || return 1
    $board --elf $old --for 0.1 --margins "$tmp/margins" 2>"$tmp/err"
    [ $? -eq 3 ] && grep -q 'stopped at 0.00[0-9]* s: rule WAIT_STATES: .*; clock_start, PC 0x' "$tmp/err" &&
        awk '$1 == "WAIT_STATES" { found = $2 == 1 && $3 == 1 } END { exit !found }' "$tmp/margins" &&
        $board --elf $old --for 0.1 --rules count:WAIT_STATES,SELECT_TO_CLOCK,SELECT_HIGH,RELEASE && $board --elf $old --for 0.1 --rules off
}

check "a wall-clock limit ends a run without end" wall_limit
check "a pipe that nobody opens ends with a message" blocked_file
check "a pipe that nobody reads ends with a message" blocked_write
check "a host that does not read ends with a message" host_does_not_read
check "paced by the wall clock, never ahead of it" paced
check "any speed, same bytes" any_speed_same_bytes
check "mistakes are told in a line" mistakes
check "a file that is not there: which folder was searched, and where the one of matrig is" wrong_folder
check "an option given twice is refused" given_twice
check "one path for two things is refused" same_path
check "one file under two names, or a campaign, is not overwritten" same_file
check "a memory's file is written through a symbolic link" memory_files
check "rules of time and electricity: stop, count, off, a file of margins" rules
check "a socket that a live program listens at is left to it" listened_on
check "a symbolic link to something else is left alone" foreign_link
check "a closed stderr does not write into an output" closed_stderr
finish
