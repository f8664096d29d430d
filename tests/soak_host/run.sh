#!/usr/bin/env bash
# The host under full load: 100 % of a 1 Mbit/s bus and 2 Mbaud of serial into one campaign; see README.md here.
#     run.sh SECONDS DIRECTORY [HOLD_S]
# HOLD_S: the logger is held for so long in the middle, its links have queues of 64 KiB, and what they lose must be reported, exactly.
# Prints figures, then one line for each thing that is wrong. Exit 0, or 1 when anything is.
set -u
cd "$(dirname "$0")/../.." || exit 99
seconds=$1 dir=$2 hold_s=${3:-0}
grown_mib=4  # the logger's memory in the last half of the run beyond that of the first quarter, at most
[ "$seconds" -ge 240 ] || grown_mib=$((grown_mib + 16)) # until the queues keep all that they may of what was written: half of 32 MB, after 48 s
wal_mib=64   # the journal beside the campaign, at most
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
mkdir -p "$dir"
rm -f "$dir"/campaign.db*
children=()
trap 'kill "${children[@]}" 2>/dev/null; rm -rf "$sockets"' EXIT

queue=0
[ "$hold_s" = 0 ] || queue=65536
build/tests/soak_host/sender "$sockets/can" "$sockets/serial" "$seconds" "$queue" >"$dir/sent.json" 2>"$dir/sender.err" &
sender=$!
build/matrig --quiet log --listen --can "unix:$sockets/can" --serial "unix:$sockets/serial" --db "$dir/campaign.db" \
    >"$dir/log.txt" 2>"$dir/log.err" &
logger=$!
children=($sender $logger)

rss_kib() { local key value _; while read -r key value _; do [ "$key" = VmRSS: ] && echo "$value"; done 2>/dev/null <"/proc/$logger/status"; }
ticks() { local s; read -r s 2>/dev/null <"/proc/$logger/stat" && s=${s##*) } && set -- $s && echo $((${12} + ${13})); }
# Once a second, in a long run each 10 s: seconds, memory, journal, time of the processor.
every_s=$((seconds >= 600 ? 10 : 1))
: >"$dir/samples.txt"
for ((at = 0; at < seconds + 120; at += every_s)); do
    kill -0 $logger 2>/dev/null || break
    used=$(ticks) rss=$(rss_kib)
    [ -n "$rss" ] && echo "$at $rss $(stat -c %s "$dir/campaign.db-wal" 2>/dev/null || echo 0) $used" >>"$dir/samples.txt"
    if [ "$hold_s" != 0 ] && [ $at = $((seconds / 3)) ]; then
        kill -STOP $logger
        sleep "$hold_s"
        kill -CONT $logger
    fi
    sleep $every_s
done
wait $sender || { echo "WRONG: the sender: $(cat "$dir/sender.err")"; exit 1; }
wait $logger || { echo "WRONG: matrig log: $(cat "$dir/log.err")"; exit 1; }

sent() { sqlite3 :memory: "select json_extract(cast(readfile('$dir/sent.json') as text), '\$.$1')"; }
db() { sqlite3 "$dir/campaign.db" "$1"; }
wrong=0
equal() { # WHAT ONE OTHER
    [ "$2" = "$3" ] && return
    echo "WRONG: $1: $2, not $3"
    wrong=1
}
kept_fills=$(db "select count(*) from frames where link = 0 and can_id = 1365")
kept_numbers=$(db "select count(distinct substr(data, 1, 4)) from frames where link = 0 and can_id = 1365")
kept_can=$(db "select received from links where link = 0")
kept_serial=$(db "select received from links where link = 1")
lost_can=$(db "select lost from links where link = 0")
lost_serial=$(db "select lost from links where link = 1")
rows_serial=$(db "select (select count(*) from frames where link = 1) + (select count(*) from blocks)")
equal "CAN frames of the board received" "$kept_can" $(($(sent can_sent) - $(sent can_lost)))
equal "CAN frames of others kept" "$kept_fills" $(($(sent fills) - $(sent fills_lost)))
equal "and their numbers" "$kept_numbers" "$kept_fills"
equal "serial frames received" "$kept_serial" $(($(sent serial_sent) - $(sent serial_lost)))
equal "and kept" "$rows_serial" "$kept_serial"
equal "CAN frames of the board reported lost" "$lost_can" "$(sent can_lost)"
equal "serial frames reported lost" "$lost_serial" "$(sent serial_lost)"
equal "bytes that are no frame" "$(db "select sum(bad) from links")" 0
equal "landings" "$(db "select count(*) from landings where state = 4")" "$(sent landings)"
if [ "$hold_s" != 0 ]; then
    [ "$(sent can_lost)" -gt 0 ] && [ "$(sent serial_lost)" -gt 0 ] || equal "frames lost while the logger was held" 0 "some"
fi
read -r early late most wal cpu < <(awk -v half=$((seconds / 2)) -v quarter=$((seconds / 4)) '
    $1 <= quarter && $2 > early { early = $2 } $1 >= half && $2 > late { late = $2 } $2 > most { most = $2 } $3 > wal { wal = $3 }
    NR == 1 { t = $1; used = $4 } { to = $1; last = $4 } END { print early + 0, late + 0, most + 0, wal + 0, (to > t ? last - used : 0) }' "$dir/samples.txt")
[ $((late - early)) -le $((grown_mib * 1024)) ] || equal "memory grew by at most $grown_mib MiB" "$((late - early)) KiB" less
[ "$wal" -le $((wal_mib * 1048576)) ] || equal "the journal is at most $wal_mib MiB" "$wal bytes" less

cat <<END
$(sent seconds) s: CAN $(sent can_per_s) frames/s, $(sent bus_percent) % of 1 Mbit/s; serial $(sent serial_bytes_per_s) bytes/s; $(sent landings) landings
CAN: board sent $(sent can_sent), received $kept_can, reported lost $lost_can; others sent $(sent fills), kept $kept_fills
serial: sent $(sent serial_sent), received $kept_serial, reported lost $lost_serial
memory: $early KiB in the first quarter, $late KiB in the last half, $most KiB at most; journal $wal bytes at most
processor: $(awk -v c="$cpu" -v s="$(sent seconds)" -v hz="$(getconf CLK_TCK)" 'BEGIN { printf "%.1f %% of one core", 100 * c / hz / s }'); the sender was late by $(sent latest_ms) ms at most
campaign: $(stat -c %s "$dir/campaign.db") bytes
END
exit $wrong
