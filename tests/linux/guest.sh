# What the checks of both guests share: TAP by busybox sh. Lines "# host: ..." ask run.sh to do something outside, lines
# "# figure: ..." are repeated at its end. Every wait is bounded.
ip() { /usr/bin/ip "$@"; } # the real one, not busybox's own
tests=0
landing=/data/landing5
links= # of start_log

check() { # NAME COMMAND...
    local name=$1
    shift
    tests=$((tests + 1))
    if "$@" >check.out 2>&1; then
        echo "ok $tests - $name"
    else
        echo "not ok $tests - $name"
        tail -n 25 check.out | sed 's/^/# /'
    fi
}
say() { echo "# figure: $*"; }
uptime_s() { cut -d. -f1 /proc/uptime; }
patience=5 # times longer than a free computer needs: a wait that succeeds costs nothing, and the computer may be busy
wait_for() { # SECONDS COMMAND...: until the command succeeds; a command may take longer than the pause between two
    local until_s=$(($(uptime_s) + $1 * patience))
    shift
    until "$@" >/dev/null 2>&1; do
        [ $(uptime_s) -lt $until_s ] || return 1
        usleep 100000
    done
}
says() { grep -Eq -- "$1" "$2" 2>/dev/null; }
fails_with() { # CODE PATTERN COMMAND...: that exit code, and one line on stderr that matches
    local code=$1 pattern=$2 status
    shift 2
    timeout 30 "$@" >out 2>err
    status=$?
    echo "exit $status; stderr:"
    cat err
    [ $status -eq "$code" ] && [ "$(wc -l <err)" -eq 1 ] && grep -Eq -- "$pattern" err
}
db() { sqlite3 "$1.db" "$2"; }
# matrig log in the background, as NAME: NAME.db, NAME.txt, NAME.err. It asks the board nothing, so that what it keeps is what others see.
start_log() {
    local name=$1
    shift
    "$@" matrig log $links --listen --all --db $name.db >$name.txt 2>$name.err &
    logger=$!
    wait_for 20 test -s $name.db && usleep 300000
}
# Whether so many programs listen on the interface.
listeners() { [ "$(grep -c "^ *$1 " /proc/net/can/rcvlist_all)" -ge $2 ]; }
stop_log() {
    kill -INT $logger
    wait_for 60 sh -c "! kill -0 $logger" || kill -KILL $logger
    wait $logger
}
rows_of() { # DB LINK: what came on it, in order
    db $1 "select printf('%03X#', can_id) || hex(data) from frames where link = $2 and direction = 0 order by id"
    [ $2 = 0 ] || db $1 "select hex(record) from blocks order by idx"
}
lost_in() { db $1 "select coalesce(sum(lost + dropped + bad), 0) from links"; }
cards_up() {
    modprobe kvaser_pci && modprobe can-raw || return 1
    for i in 0 1; do ip link set can$i type can bitrate 1000000; ip link set can$i txqueuelen 100; ip link set can$i up; done
}
