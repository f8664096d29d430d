# A full bus, in the guest's own time: it runs by counted instructions, so a slow host makes it longer and
# changes nothing else.
. /guest.sh
load_s=$(sed -n 's/.*matrig.load_s=\([0-9]*\).*/\1/p' /proc/cmdline)
cards_up

links="--can can:can0"
start_log load
read -r begun _ </proc/uptime
canbusload -e can0@1000000 >busload.txt 2>&1 &
meter=$!
bridge load can0 101 202 $load_s 50 >load0.txt 2>&1 &
near=$!
bridge load can1 202 101 $load_s 50 >load1.txt 2>&1
far_status=$?
wait $near
near_status=$?
kill $meter
stop_log
sent() { sed -n 's/.*: sent \([0-9]*\) frames.*/\1/p' $1; }
both_ways() { cat load0.txt load1.txt; [ $near_status -eq 0 ] && [ $far_status -eq 0 ] && [ "$(sent load0.txt)" -gt 0 ]; }
check "a full bus between the cards: nothing is lost either way" both_ways
logged_all() { # frames of others are kept: their numbers are all there
    cat load.txt load.err
    for id in 0x101 0x202; do
        db load "select can_id, count(*), count(distinct substr(data, 1, 4)) from frames where can_id = $((id))"
    done
    ! says "link in this session" load.txt &&
        [ "$(db load "select count(distinct substr(data, 1, 4)) from frames where can_id = $((0x101))")" = "$(sent load0.txt)" ] &&
        [ "$(db load "select count(distinct substr(data, 1, 4)) from frames where can_id = $((0x202))")" = "$(sent load1.txt)" ] &&
        [ "$(db load "select count(*) from frames")" = $(($(sent load0.txt) + $(sent load1.txt))) ]
}
check "matrig log on the same bus keeps every frame of both" logged_all
say "$(cat load0.txt)"
say "$(cat load1.txt)"
say "matrig log on can0 kept $(db load 'select count(*) from frames') of $(($(sent load0.txt) + $(sent load1.txt))) frames;" \
    "canbusload says $(tr -s '\r' '\n' <busload.txt | grep -o '[0-9]*%' | sort -n | tail -n 1) at most"

echo "1..$tests"
