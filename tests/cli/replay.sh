#!/usr/bin/env bash
# matrig replay: ten recorded landings say the same again; an image with one other constant is found out; what cannot be
# replayed is refused, with its reason; what the board says after a reset is no part of the record that the reset ended.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/campaign.db
trap 'kill $(jobs -p) 2>/dev/null' EXIT

# vary NAME SED: landing 5 with changes, as a run file of its own with a checksum of its own.
vary() {
    grep -av '^end ' tests/runs/landing5.run | sed -E "$2" >"$tmp/$1.run"
    printf 'end %s\n' "$(gzip -c "$tmp/$1.run" | tail -c 8 | head -c 4 | od -An -tx4 | tr -d ' ')" >>"$tmp/$1.run"
}
# record RUNFILE BOARD-OPTION...: play it and log it: the next RUN of the campaign.
record() {
    local run=$1
    shift
    played --elf build/firmware/matrig.elf --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --rig "$run" "$@" \
        2>"$tmp/board.err" || return 1
    # a run may end in the middle of a frame
    $matrig --quiet log --can "file:$tmp/can.log" --serial "file:$tmp/serial.bin" --db "$db" >"$tmp/log.txt" 2>"$tmp/log.err" ||
        grep -q 'the link ended inside a frame' "$tmp/log.err"
}
stored() { sqlite3 "$db" "$1"; }
in_json() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.$2')"; }

# Ten landings, each with something of its own.
vary marks 's/^command 7\.175 .*/command 1.9 can mark 1\ncommand 2.0 serial mark 2\ncommand 2.0 serial state\ncommand 2.0 can mark 3\ncommand 2.0 can state/'
vary refused 's/^command 7\.175 .*/command 1.2 can arm 6\ncommand 1.3 serial survey 3 0.1\ncommand 1.5 serial mark -3\ncommand 2.5 can disarm/;/^command 8\.875/d'
vary twice 's/^command 7\.175 .*/command 1.0 can disarm\ncommand 1.1 serial arm 9/'
vary bare '/survey/d;s/^command 0\.800 .*/command 0.06 serial arm 0/'
vary late '/survey/d;/^command/d;s/^samples/command 21.3 can arm 77\nsamples/'
vary close 's/^switch 5 .*/switch 5 17.5 17.5 1.7478/' # 0.6 ms after switch 3: neither can be named
vary saturated '/^[-0-9]+ [-0-9]+ .*/s/^[-0-9]+ ([-0-9]+) ([-0-9]+) /500000 \1000 -\2000 /'
vary unplugged '/^[-0-9]+ [-0-9]+ .*/s/^(([-0-9]+ ){8})[-0-9]+ [-0-9]+ /\1-20000 70000 /'
vary serial 's/^(command 0\.800) can/\1 serial/'
vary zeroed 's/^command 0\.300 .*survey 0 .*/command 0.04 can zero 1\n&/'
record_ten() { # those that make test does not replay end once they are armed
    record tests/runs/landing1.run --seed 11 --for "$(take 1.2 4)" && record tests/runs/landing4.run --seed 12 --for "$(take 1.2 4)" &&
        record tests/runs/landing5.run --seed 13 &&
        record "$tmp/marks.run" --seed 14 --for 4 && record "$tmp/refused.run" --seed 15 --for 3 &&
        record "$tmp/twice.run" --seed 16 --for 3 && record "$tmp/bare.run" --seed 17 --for 3 &&
        record "$tmp/late.run" --seed 18 --for 22 && record "$tmp/close.run" --seed 19 --for 3.5 &&
        record "$tmp/saturated.run" --seed 20 --for 3 && record "$tmp/unplugged.run" --seed 21 --for 3 &&
        record "$tmp/serial.run" --seed 22 --for 3 --hse 0 --hsi-ppm 4000
    [ "$(stored 'select count(*) from landings')" = 13 ] # `twice` has two
}
saturation_was_recorded() { # a record with counts is longer than 78 bytes
    [ "$(stored "select count(*) > 1000 from blocks join landings on landings.id = landing where length(record) > 79")" = 1 ]
}
# Zeros that were measured before arming are part of what was recorded, though nothing of their measuring is.
record_zeroed() {
    record "$tmp/zeroed.run" --seed 23 --for 3 && [ "$(stored 'select max(id) from landings')" = 14 ] &&
        [ "$(stored "select count(distinct hex(substr(data, 1, 1))) from frames where landing = 14 and link = 1 and can_id = 502 and hex(substr(data, 4, 1)) = '01'")" = 8 ]
}
zeros_are_given_again() { [ "$(in_json "$tmp/replay14.json" zeros)" = 8 ]; }
says_the_same() { # RUN
    $matrig --json --quiet replay "$db" "$1" >"$tmp/replay$1.json"
    local status=$?
    in_json "$tmp/replay$1.json" first
    [ $status = 0 ] && [ "$(in_json "$tmp/replay$1.json" differ)" = 0 ] && [ "$(in_json "$tmp/replay$1.json" compared)" = exactly ] &&
        [ "$(in_json "$tmp/replay$1.json" before_record)" = 0 ] && [ "$(in_json "$tmp/replay$1.json" not_recorded)" = 0 ] &&
        # every message that was logged has been compared, but for the last block's: blocks and frames of the landing
        [ "$(in_json "$tmp/replay$1.json" after_record)" -le 6 ] &&
        [ $(($(in_json "$tmp/replay$1.json" messages) + $(in_json "$tmp/replay$1.json" after_record) + $(in_json "$tmp/replay$1.json" circumstances))) -ge "$(stored "select (select count(*) from blocks where landing = $1) + (select count(*) from frames where landing = $1 and direction = 0) - 5")" ]
}
same_twice() {
    $matrig --json --quiet replay "$db" 6 >"$tmp/again.json" && cmp "$tmp/replay6.json" "$tmp/again.json"
}
# Whole seconds, so many that it is armed as early as a board can be that has just begun.
moved_back() {
    local moved armed
    moved=$(in_json "$tmp/replay9.json" shift_blocks) armed=$(stored 'select armed_block from landings where id = 9')
    echo "armed in block $armed, moved by $moved"
    [ "$moved" -gt 0 ] && [ $((moved % 1000)) -eq 0 ] && [ $((armed - moved)) -ge 450 ] && [ $((armed - moved)) -lt 1450 ]
}

# Another image. The constant that says when the gear rests is 1 ms more: the state changes a block later, and nothing before.
first_is() { # FILE MESSAGE FIELD
    in_json "$1" first
    [ "$(in_json "$1" first.message)" = "$2" ] && [ "$(in_json "$1" first.field)" = "$3" ]
}
names_the_first_difference() {
    local settling
    $matrig --json --quiet replay "$db" 3 --elf build/tests/variant/rest.elf --exact >"$tmp/rest.json"
    [ $? = 1 ] || return 1
    settling=$(stored "select board_us / 1000 from events where landing = 3 and kind = 'state' and code = 3")
    first_is "$tmp/rest.json" landing block && [ "$(in_json "$tmp/rest.json" first.recorded)" = "$settling.0" ] &&
        [ "$(in_json "$tmp/rest.json" first.replayed)" = $((settling + 1)).0 ]
}
small_change_is_tolerated() { # and the output states what is
    $matrig --quiet --si replay "$db" 3 --elf build/tests/variant/rest.elf >"$tmp/si.txt" && grep -q 'recorded by' "$tmp/si.txt" &&
        grep 'compared  *0.051 mm, 0.89 N, 0.015 m, 0.0061 m/s, 0.03 m/s2, 0.05 s, 1 codes, 5 ms, 5 %; counts' "$tmp/si.txt"
}
large_change_is_not() {
    $matrig --json --quiet replay "$db" 4 --elf build/tests/variant/scale.elf >"$tmp/scale.json"
    [ $? = 1 ] && first_is "$tmp/scale.json" board_config config_crc && # and the readings are 2 % less
        sqlite3 :memory: "select json_extract(value, '\$.first.t_s') from json_each(json_extract(cast(readfile('$tmp/scale.json') as text), '\$.by_message')) where json_extract(value, '\$.message') = 'displacement_1_3'" | grep -q '^[0-9]'
}

# What cannot be replayed.
broken() { # NAME SQL: a copy of the campaign with the change
    rm -f "$tmp/$1.db"
    sqlite3 "$db" ".backup $tmp/$1.db" && sqlite3 "$tmp/$1.db" "$2"
}
without_serial() {
    $matrig --quiet log --can "file:$tmp/can.log" --db "$tmp/can.db" >/dev/null
    broken noblocks 'delete from blocks where landing = 5' && fails_with 4 'no block records: RUN 5 of .*; replay a landing that was logged over serial' $matrig replay "$tmp/noblocks.db" 5
}
with_a_hole() {
    broken hole 'delete from blocks where landing = 5 and idx between 1200 and 1209' &&
        fails_with 4 'the record lacks 10 blocks: RUN 5 of .*, first blocks 1200 to 1209 \(1\.200 s to 1\.210 s\)' $matrig replay "$tmp/hole.db" 5
}
changed_record() { # one sum of one block is another: the board says so, and so does what it makes of it
    broken changed "update blocks set record = cast(substr(record, 1, 11) || x'0102' || substr(record, 14) as blob) where landing = 5 and idx = 1302" &&
        $matrig --json --quiet replay "$tmp/changed.db" 5 >"$tmp/changed.json"
    [ $? = 1 ] && first_is "$tmp/changed.json" displacement_1_3 d1_in && [ "$(in_json "$tmp/changed.json" first.t_s)" = 1.302 ]
}
changed_edge() { # one tick in the frame that told of it
    broken tick "update frames set data = cast(x'00' || substr(data, 2) as blob) where id = (select min(id) from frames where landing = 5 and can_id = 144 and link = 0)" &&
        $matrig --json --quiet replay "$tmp/tick.db" 5 >"$tmp/tick.json"
    [ $? = 1 ] && first_is "$tmp/tick.json" edge tick && [ "$(in_json "$tmp/tick.json" differ)" = 1 ]
}
without_zeros() { # the messages say that the zeros were the configured ones
    broken unzeroed "update frames set data = cast(substr(data, 1, 3) || x'00' || substr(data, 5) as blob) where landing = 14 and can_id = 502" &&
        $matrig --json --quiet replay "$tmp/unzeroed.db" 14 >"$tmp/unzeroed.json"
    [ $? = 1 ] && sqlite3 :memory: "select json_extract(value, '\$.differ') from json_each(json_extract(cast(readfile('$tmp/unzeroed.json') as text), '\$.by_message')) where json_extract(value, '\$.message') = 'displacement_1_3'" | grep -q '^[1-9]'
}
without_a_runway() { # the replay starts with an unmeasured one, and says so
    broken nowhere 'delete from runways where landing = 6'
    $matrig --quiet replay "$tmp/nowhere.db" 6 | grep 'runway  *the recorded runway is incomplete: the replay starts with an unmeasured runway'
}
record_begins_at_arming() {
    broken older 'delete from blocks where landing = 6 and idx < (select armed_block from landings where id = 6)' &&
        $matrig --json --quiet replay "$tmp/older.db" 6 >"$tmp/older.json" || return 1
    # by the block of arming: three displacement messages in even blocks are means of 2, five tension messages in blocks
    # 4 n + 1 are means of 4
    local armed before
    armed=$(sqlite3 "$tmp/older.db" 'select armed_block from landings where id = 6')
    before=$(((armed % 2 == 0 ? 3 : 0) + (armed % 4 != 2 ? 5 : 0)))
    [ "$(in_json "$tmp/older.json" before_record)" = $before ] && [ "$(in_json "$tmp/older.json" differ)" = 0 ]
}
record_breaks_off() { # as when the host is killed: CAN has more than serial, and the landing is not over
    broken short 'delete from blocks where landing = 5 and idx > 2000' &&
        $matrig --json --quiet replay "$tmp/short.db" 5 >"$tmp/short.json" || return 1
    [ "$(in_json "$tmp/short.json" after_record)" -gt 100 ] && [ "$(in_json "$tmp/short.json" differ)" = 0 ] &&
        [ "$(in_json "$tmp/short.json" fields)" -gt 50000 ]
}
serial_alone() {
    broken serial 'delete from frames where link = 0' && $matrig --json --quiet replay "$tmp/serial.db" 6 >"$tmp/serial.json" || return 1
    [ "$(in_json "$tmp/serial.json" differ)" = 0 ] && [ "$(in_json "$tmp/serial.json" messages)" -gt 200 ]
}
at_real_speed() { # RUN 6 is 1 s long
    $matrig --json --quiet replay "$db" 6 --speed real >"$tmp/real.json" && cmp "$tmp/real.json" "$tmp/replay6.json"
}
lost_frames_are_no_difference() {
    # not of the answer to arming itself: what tells its block must be there
    broken lossy "delete from frames where landing = 5 and link = 0 and id % 7 = 0 and id > (select min(id) + 100 from frames where landing = 5 and link = 0);
        insert into gaps(session, landing, link, message, channels, cause, count, from_block, to_block) values(5, 5, 0, 'frame', 'all', 'link', 9, 800, 9000)" &&
        $matrig --json --quiet replay "$tmp/lossy.db" 5 >"$tmp/lossy.json" || return 1
    [ "$(in_json "$tmp/lossy.json" not_recorded)" -gt 300 ] && [ "$(in_json "$tmp/lossy.json" differ)" = 0 ]
}

# The board begins again in the landing: its record ends there, on both links, with the cause of the reset.
instead() { # HALFWORD: instead of the first instruction of what only a landing calls: e7fe hangs there, de00 is none
    local was bit
    was=$(arm-none-eabi-objdump -d --disassemble=landinglink_send_motion build/firmware/matrig.elf | awk -F '\t' '/^ *[0-9a-f]+:/ { print substr($2, 1, 4); exit }')
    for bit in {0..15}; do (((0x$was ^ 0x$1) >> bit & 1)) && echo "at 2.2 flip landinglink_send_motion $bit"; done
    return 0
}
begins_again() { # CAUSE SECONDS FAULT...
    local cause=$1 for_s=$2 db=$tmp/again.db
    shift 2
    rm -f "$db"
    printf '%s\n' 'matrig-faults 1' "$@" >"$tmp/again.faults"
    record tests/runs/landing5.run --for "$for_s" --faults "$tmp/again.faults" && grep 'resets 1,' "$tmp/board.err" || return 1
    grep "^  restart  *the board restarted ($cause), so the record ends after " "$tmp/log.txt" || return 1
    $matrig --json --quiet replay "$db" 1 >"$tmp/again.json"
    echo "exit $?"
    in_json "$tmp/again.json" first
    # nobody else is on the bus: what both starts sent is what was received
    [ "$(in_json "$tmp/again.json" differ)" = 0 ] && [ "$(in_json "$tmp/again.json" fields)" -gt 100000 ] && [ "$(in_json "$tmp/again.json" compared)" = exactly ] &&
        [ "$(sqlite3 "$db" "select count(*), min(boot), min(links) from events where kind = 'restart' and landing = 1")" = '1|1|3' ] &&
        [ "$(sqlite3 "$db" 'select sum(lost) + sum(dropped) + sum(outside) from links')" = 0 ] && [ "$(sqlite3 "$db" 'select count(*) from missing')" = 0 ] &&
        [ "$(sqlite3 "$db" "select max(board_us) / 1000 - (select max(idx) from blocks where landing = 1) from frames where landing = 1")" -le 1 ]
}

check "ten landings and more are recorded" record_ten
check "one of them with saturated channels" saturation_was_recorded
for run in $(take "5 6 7 9 10 12 13" "$(seq 13)"); do # RUN 3: a whole landing, as those of bands.sh and chart.sh
    check "RUN $run says the same again, every field" says_the_same "$run"
done
check "a landing with measured zeros is recorded" record_zeroed
check "it says the same again, every field" says_the_same 14
check "because its zeros are given again" zeros_are_given_again
check "with other zeros it does not" without_zeros
check "a record that begins late is moved back by whole seconds" moved_back
check "two replays are the same" same_twice
check "one constant of the firmware changed: the first difference is named" names_the_first_difference
check "another image is compared within tolerances, which are stated" small_change_is_tolerated
check "and what is beyond them is named" large_change_is_not
check "a changed sum in a record shows in what the board makes of it" changed_record
check "a changed tick in a message shows as that field alone" changed_edge
check "an older record without the blocks before arming: what rests on them is not compared" record_begins_at_arming
check "a record that breaks off is compared as far as its blocks go" record_breaks_off
check "a record that ends by a power cut says the same until then" begins_again 'power, pin, brown-out' 2.5 'at 2.2 power-cut 20'
if [ -n "${MATRIG_LONG:-}" ]; then
    mapfile -t hang < <(instead e7fe) && check "one that ends by the watchdog, too" begins_again 'pin, watchdog' 3.3 "${hang[@]}"
    mapfile -t none < <(instead de00) && check "one that ends by a fault of the processor, too" begins_again 'pin, software' 2.6 "${none[@]}"
fi
check "a landing logged over serial alone says the same" serial_alone
check "a rig and a replay together are refused" fails_with 2 '--rig and --replay cannot be given together' build/matrig-board --elf build/firmware/matrig.elf --rig "$tmp/bare.run" --replay "$tmp/none"
check "at real speed too, paced by the clock" at_real_speed
check "frames that the log lost are no difference" lost_frames_are_no_difference
check "without the runway's state it starts with an unmeasured one, and that is told" without_a_runway
check "without block records it is refused" without_serial
check "with lost blocks it is refused, naming which" with_a_hole
check "without an image it is refused" fails_with 3 'no firmware image .*: build/none.elf; build the image with make all' $matrig replay "$db" 3 --elf build/none.elf
check "with something that is no image it is refused" fails_with 3 'failed with exit code 4: README.md; message of the board: .*README.md' $matrig --quiet replay "$db" 3 --elf README.md
check "an unknown speed is refused" fails_with 2 "unknown speed: 'fast' for --speed; give max or real" $matrig replay "$db" 3 --speed fast
check "a RUN that is not there is refused" fails_with 2 'no such landing: RUN 99' $matrig replay "$db" 99
finish
