#!/usr/bin/env bash
# matrig-board --gdb: a session of the ordinary gdb through a landing, which changes nothing of it; and the protocol's corners.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
elf=build/firmware/matrig.elf
run=tests/runs/landing5.run
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'kill $(jobs -p) 2>/dev/null; rm -rf "$sockets"' EXIT

start_board() { # ARGUMENTS...: a board that waits for gdb at $sockets/gdb
    timeout 600 build/matrig-board --elf $elf --gdb "unix:$sockets/gdb" "$@" 2>"$tmp/board.err" &
    board=$!
    await test -S "$sockets/gdb"
}
gdb_session() { timeout 600 gdb-multiarch -nx -q -batch -ex 'set remotetimeout 60' -ex 'set pagination off' -ex 'set width 0' -ex "target remote $sockets/gdb" -x "$1" $elf; }
says() { grep -Eq -- "$1" "$tmp/session" || { echo "missing: $1"; return 1; }; }
# value NAME: what the session printed as "NAME = number"
value() { sed -n "s/^$1 = //p" "$tmp/session" | head -n 1; }

cat >"$tmp/session.gdb" <<'EOF'
tbreak board_edges_get
continue
backtrace
tbreak landinglink_send_motion
continue
backtrace 3
printf "edges = %u\n", app.landing.edge_count
printf "speed = %.3f\n", app.landing.motion.speed_ft_s.value
info registers s0 d0 fpscr xpsr msp
tbreak dma2_stream4_irq
continue
backtrace
printf "before = %#x\n", $pc
stepi
printf "after = %#x\n", $pc
next
monitor time
tbreak landinglink_send_summary
continue
printf "touchdown = %.3f\n", app.landing.summary.touchdown_speed_ft_s.value
continue
EOF

session() {
    start_board --rig $run --can "file:$tmp/gdb.can" --serial "file:$tmp/gdb.serial" || return 1
    gdb_session "$tmp/session.gdb" >"$tmp/session" 2>&1
    wait $board
    local status=$?
    cat "$tmp/session" "$tmp/board.err"
    [ $status -eq 0 ] && says 'exited normally'
}
shows_where() { says '#0 +board_edges_get \(until_tick=[0-9]+' && says '#[0-9] .* app_poll \(' && says '#[0-9] .* main \(\) at firmware/main.c'; }
shows_through_exception() {
    grep -A3 '^#0  dma2_stream4_irq' "$tmp/session" >"$tmp/bt"
    cat "$tmp/bt"
    sed -n 2p "$tmp/bt" | grep -q '#1  <signal handler called>' && sed -n 3,4p "$tmp/bt" | grep -q ' at firmware/'
}
shows_estimate() { # against the landing's truth, 35.5 ft/s, within the 0.2 % that is promised
    echo "speed $(value speed), touchdown $(value touchdown), edges $(value edges)"
    [ "$(value edges)" -ge 2 ] &&
        awk -v v="$(value speed)" -v t="$(value touchdown)" 'BEGIN { exit !(v > 30 && v < 37 && t > 35.429 && t < 35.571) }'
}
shows_registers() { says '^s0 +[-0-9.e+]+ +\(raw 0x[0-9a-f]{8}\)' && says '^d0 ' && says '^msp +0x20' && says '^xpsr +0x'; }
steps() { [ -n "$(value before)" ] && [ $(($(value after) - $(value before))) -ge 2 ] && [ $(($(value after) - $(value before))) -le 4 ]; }
changes_nothing() {
    played --elf $elf --rig $run --can "file:$tmp/alone.can" --serial "file:$tmp/alone.serial" 2>"$tmp/alone.err" || return 1
    tail -n 1 "$tmp/alone.err" "$tmp/board.err"
    [ -s "$tmp/alone.serial" ] && cmp "$tmp/alone.can" "$tmp/gdb.can" && cmp "$tmp/alone.serial" "$tmp/gdb.serial" &&
        [ "$(grep -o '[0-9]* instructions' "$tmp/alone.err")" = "$(grep -o '[0-9]* instructions' "$tmp/board.err")" ]
}

# The protocol, spoken by hand: raw SCRIPT..., each `send TEXT`, `byte N`, `expect REGEX`, `quiet MS`.
raw() {
    perl -MSocket -MIO::Select -e '
        my ($path, @script) = @ARGV;
        socket(my $s, AF_UNIX, SOCK_STREAM, 0); connect($s, pack_sockaddr_un($path)) or die "connect: $!";
        my $got = "";
        sub more { my $r = IO::Select->new($s); return 0 unless $r->can_read($_[0]); sysread($s, my $b, 9999) or return 0; $got .= $b; 1 }
        for (@script) {
            my ($do, $text) = /^(\w+) ?(.*)$/;
            print "$do $text\n";
            if ($do eq "send") { my $sum = 0; $sum += ord for split //, $text; syswrite($s, sprintf "\$%s#%02x", $text, $sum % 256) }
            elsif ($do eq "bytes") { syswrite($s, $text) }
            elsif ($do eq "byte") { syswrite($s, chr $text) }
            elsif ($do eq "quiet") { $got = ""; more($text / 1000); die "came: $got\n" if $got ne "" }
            else { my $n = 0; until ($got =~ s/^.*?$text//s) { more(20) or die "expected $text, got: $got\n" } print "   $&\n" } }
    ' "$sockets/gdb" "$@"
}
interrupts_and_kill() { # Ctrl-C while it runs; a bad checksum; kill
    start_board || return 1
    raw 'send ?' 'expect \+\$T02thread' 'byte 43' 'bytes $?#00' 'expect -' 'send QStartNoAckMode' 'expect OK#9a' 'send vCont;c' 'quiet 200' \
        'byte 3' 'expect \$T02thread' 'send qRcmd,74696d65' 'expect \$[0-9a-f]{40,}#' 'send k' || return 1
    wait $board || return 1
    tail -n 1 "$tmp/board.err" | grep -q 'virtual in'
}
registers_and_memory() {
    start_board --for 0.05 || return 1
    # r5 and s3 (upper half of d1) written and read; RAM, flash and a register of TIM2 read and written; nothing where there is nothing
    raw 'send QStartNoAckMode' 'expect OK' 'send P5=78563412' 'expect OK' 'send p5' 'expect \$78563412#' \
        'send P18=0000000000002840' 'expect OK' 'send p18' 'expect \$0000000000002840#' 'send p99' 'expect \$E01' \
        'send M20010000,4:01020304' 'expect OK' 'send m20010001,2' 'expect \$0203#' 'send m08000000,4' 'expect \$[0-9a-f]{8}#' \
        'send m40000000,4' 'expect \$E0e' 'send m40023800,4' 'expect \$83..0000#' 'send M40023840,4:01000000' 'expect OK' \
        'send m4000002c,4' 'expect \$ffffffff#' 'send m30000000,4' 'expect \$E0e' 'send me000ef34,4' 'expect \$000000c0#' \
        'send Z0,8000000,9' 'expect OK' 'send Zx,1,1' 'expect \$#00' 'send vUnheard' 'expect \$#00' 'send D' 'expect OK' || return 1
    wait $board && grep -q 'resets 0, faults 0' "$tmp/board.err"
}
detaches_and_returns() {
    start_board --for 2 --speed real || return 1
    raw 'send ?' 'expect T02' 'send D' 'expect OK' && raw 'send ?' 'expect T02' 'send D' 'expect OK' || return 1
    wait $board && cat "$tmp/board.err" && grep -q '^matrig-board: 2.000 s virtual' "$tmp/board.err"
}
lost_connection() { # a debugger that vanishes leaves the board running
    start_board --for 0.2 || return 1
    raw 'send ?' 'expect T02' || return 1
    wait $board && grep -q '^matrig-board: 0.200 s virtual' "$tmp/board.err"
}
# Debuggers that reset their connection at random points of random conversations, with packets on the way: PATH or PORT, how many.
resets() {
    perl -MSocket -MIO::Select -e '
        my ($place, $times) = @ARGV;
        my @packets = ("?", "g", "p5", "m20000000,100", "Z0,8012345,2", "z0,8012345,2", "Z2,20000000,4",
            "z2,20000000,4", "Z4,20000010,4", "qSupported", "qXfer:features:read:target.xml:0,ff", "qRcmd,74696d65", "vCont?", "vCont;s", "vCont;c", "c", "s", "D");
        srand(7);
        for my $n (1 .. $times) {
            my $tcp = $place =~ /^\d+$/;
            socket(my $s, $tcp ? AF_INET : AF_UNIX, SOCK_STREAM, 0);
            connect($s, $tcp ? pack_sockaddr_in($place, inet_aton("127.0.0.1")) : pack_sockaddr_un($place)) or die "connection $n: $!\n";
            if (rand() < 0.5) { # it is served
                syswrite($s, "\$?#3f");
                IO::Select->new($s)->can_read(20) && sysread($s, my $b, 99) or die "connection $n: no answer\n";
            }
            my $bytes = "";
            for (1 .. 1 + rand 40) { my $p = $packets[rand @packets]; my $sum = 0; $sum += ord for split //, $p; $bytes .= sprintf "\$%s#%02x", $p, $sum % 256 }
            $bytes = substr($bytes, 0, 1 + rand length $bytes) if rand() < 0.7;
            $SIG{PIPE} = "IGNORE";
            syswrite($s, $bytes);
            setsockopt($s, SOL_SOCKET, SO_LINGER, pack("ii", 1, 0));
            close $s;
        }
        print "$times connections reset\n"' "$1" "$2"
}
reset_connections() { # the board goes on, and the next debugger finds it as it should be
    start_board || return 1
    resets "$sockets/gdb" 100 && raw 'send ?' 'expect T02' 'send qRcmd,74696d65' 'expect \$[0-9a-f]{40,}#' 'send k' || return 1
    wait $board || return 1
    cat "$tmp/board.err"
    tail -n 1 "$tmp/board.err" | grep -q 'resets 0, faults 0'
}
kills_and_goes() { # without waiting for an answer
    local i
    for ((i = 0; i < 20; i++)); do
        start_board || return 1
        perl -MSocket -e 'socket(my $s, AF_UNIX, SOCK_STREAM, 0); connect($s, pack_sockaddr_un($ARGV[0])) or die "$!"; syswrite($s, "\$k#6b")' "$sockets/gdb"
        ended() { ! kill -0 $board 2>/dev/null; }
        await ended || return 1
        wait $board || return 1
    done
}
reset_connections_of_a_port() {
    rm -f "$tmp/port.err"
    timeout 600 build/matrig-board --elf $elf --speed real --gdb 0 2>"$tmp/port.err" &
    board=$!
    await grep -q 'target remote' "$tmp/port.err"
    local port=$(sed -n 's/.*target remote .*://p' "$tmp/port.err")
    resets "$port" 100 && kill -0 $board || return 1
    timeout 600 gdb-multiarch -nx -q -batch -ex "set remotetimeout 60" -ex "target remote 127.0.0.1:$port" -ex 'monitor time' -ex kill $elf >"$tmp/session" 2>&1
    wait $board || return 1
    cat "$tmp/session"
    says '^[0-9.]+ s virtual'
}
watches() { # the hang image counts its SysTicks in the first word of RAM, and sleeps ten times
    elf=build/tests/hil/images/hang_loop.elf
    start_board --for 0.5 || return 1
    printf '%s\n' 'watch *(unsigned *)0x20000000' continue continue 'delete' 'monitor reset' \
        'maintenance flush register-cache' 'info registers pc' 'tbreak wait_for_flag' continue 'printf "count = %u\n", *(unsigned *)0x20000000' kill >"$tmp/watch.gdb"
    gdb_session "$tmp/watch.gdb" >"$tmp/session" 2>&1
    wait $board
    local status=$?
    elf=build/firmware/matrig.elf
    cat "$tmp/session" "$tmp/board.err"
    # held behind the instruction, which is named
    local by=$(sed -n 's/^access to 0x20000000 by the instruction at //p' "$tmp/session" | tail -n 1)
    echo "by $by"
    [ $status -eq 0 ] && says 'New value = 2' &&
        arm-none-eabi-addr2line -f -e build/tests/hil/images/hang_loop.elf "$by" | grep -qx systick &&
        says '^pc +0x[0-9a-f]+ .*<reset>' && [ "$(value count)" -eq 12 ]
}
port_is_told() {
    rm -f "$tmp/port.err" # the test before has one, and this one's is emptied in the background
    timeout 600 build/matrig-board --elf $elf --gdb 0 --for 1 2>"$tmp/port.err" &
    board=$!
    await grep -q '127.0.0.1:[0-9]' "$tmp/port.err"
    timeout 600 gdb-multiarch -nx -q -batch -ex 'set remotetimeout 60' -ex "$(sed -n 's/.*gdb: //p' "$tmp/port.err")" -ex 'monitor time' -ex continue $elf >"$tmp/session" 2>&1
    wait $board
    local status=$?
    cat "$tmp/port.err" "$tmp/session"
    [ $status -eq 0 ] && says '0.000000000 s virtual' && says 'exited normally'
}
refusals() {
    fails_with 2 'cannot be .here.; give a port' build/matrig-board --elf $elf --gdb here &&
        fails_with 2 'cannot be .70000.' build/matrig-board --elf $elf --gdb 70000 &&
        fails_with 3 'exists and is not a socket' build/matrig-board --elf $elf --gdb unix:Makefile
}

check "a session to the end of the landing" session
check "it shows where the edges are taken, up to main" shows_where
check "and through an exception" shows_through_exception
check "it prints the estimate that the landing has" shows_estimate
check "and registers, floating point too" shows_registers
check "it steps one instruction" steps
check "the board's bytes and instructions are those without it" changes_nothing
check "Ctrl-C, a bad checksum, kill" interrupts_and_kill
check "registers, memory, peripherals" registers_and_memory
check "a debugger detaches and comes again" detaches_and_returns
check "a debugger that vanishes leaves the board running" lost_connection
check "100 debuggers that reset their connection leave the board running" reset_connections
check "also on a port" reset_connections_of_a_port
check "a debugger that kills and goes at once ends the board" kills_and_goes
check "a watchpoint, a reset" watches
check "a port that is free is told" port_is_told
check "what --gdb does not take" refusals
finish
