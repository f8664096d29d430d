#!/usr/bin/env bash
# matrig-board and matrig log as two processes: nothing lost, and the same bytes as the board alone gives.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
elf=build/firmware/matrig.elf
run=tests/runs/landing5.run
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

# over_sockets SPEED DB SECONDS: exit code of log, or of the board when that failed
over_sockets() {
    local board status
    timeout 600 build/matrig-board --elf $elf --can "unix:$sockets/can" --serial "unix:$sockets/serial" --rig $run \
        --speed "$1" --for "$3" 2>"$2.board" &
    board=$!
    timeout 600 build/matrig --json --quiet log --listen --can "unix:$sockets/can" --serial "unix:$sockets/serial" --db "$2" >"$2.json" 2>"$2.err"
    status=$?
    wait $board || status=$?
    cat "$2.board" "$2.err"
    return $status
}
into_files() { build/matrig-board --elf $elf --can "file:$1.can" --serial "file:$1.serial" --rig $run --for "$2"; }
frames_of() { # DB LINK: everything logged from that link, in order
    sqlite3 "$1" "select printf('%03X#', can_id) || hex(data) from frames where link = $2 and direction = 0 order by id"
    sqlite3 "$1" "select hex(record) from blocks order by idx"
}
lost_in() { sqlite3 "$1" "select coalesce(sum(lost), 0) + coalesce(sum(dropped), 0) + coalesce(sum(bad), 0) from links"; }

real_time_loses_nothing() {
    over_sockets real "$tmp/real.db" 9.175 || return 1
    echo "lost $(lost_in "$tmp/real.db")"
    [ "$(lost_in "$tmp/real.db")" = 0 ] && [ "$(frames_of "$tmp/real.db" 0 | wc -l)" -gt 20000 ]
}
two_file_runs_are_equal() { # the one that other tests have, and another
    played --elf $elf --can "file:$tmp/a.can" --serial "file:$tmp/a.serial" --rig $run && into_files "$tmp/b" 3 || return 1
    for link in can serial; do # the other one ends sooner: with the warning
        [ "$(stat -c %s "$tmp/b.$link")" -gt 200000 ] && cmp -n "$(stat -c %s "$tmp/b.$link")" "$tmp/a.$link" "$tmp/b.$link" || return 1
    done
}
sockets_equal_files() { # the log of the sockets against the log of the board's own files
    over_sockets max "$tmp/max.db" 9.175 || return 1
    build/matrig --quiet log --can "file:$tmp/a.can" --serial "file:$tmp/a.serial" --db "$tmp/file.db" >/dev/null || return 1
    for link in 0 1; do
        [ "$(frames_of "$tmp/max.db" $link | wc -l)" -gt 1000 ] || return 1
        cmp <(frames_of "$tmp/max.db" $link) <(frames_of "$tmp/file.db" $link) || return 1
    done
    # and the CAN frames logged are those of the board's own record, in its order
    cmp <(sqlite3 "$tmp/max.db" "select printf('%03X#', can_id) || hex(data) from frames where link = 0 order by id") \
        <(awk '{print $3}' "$tmp/a.can")
}
real_equals_max() {
    for link in 0 1; do
        cmp <(frames_of "$tmp/real.db" $link) <(frames_of "$tmp/max.db" $link) || return 1
    done
}
seed_matters() { # or the comparisons above could not fail
    build/matrig-board --elf $elf --can "file:$tmp/c.can" --serial "file:$tmp/c.serial" --rig $run --for 2 --seed 2 &&
        ! cmp -s -n 100000 "$tmp/a.serial" "$tmp/c.serial"
}

check "in real time, over sockets, no frame is lost" real_time_loses_nothing
check "two runs of the board give the same bytes" two_file_runs_are_equal
check "two processes log the same as the board alone" sockets_equal_files
check "real time and full speed log the same" real_equals_max
check "another noise seed gives other bytes" seed_matters
finish
