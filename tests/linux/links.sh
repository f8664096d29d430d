# Links of every kind, in real time, with boards outside.
. /guest.sh

# --- before there is any CAN ---
check "a kernel without CAN: the error says so, and what to do" \
    fails_with 3 "this kernel has no CAN: can:can0; run modprobe can-raw" matrig log --can can:can0 --db x.db

for module in can-raw vcan kvaser_pci virtio_pci virtio_console xhci-pci ftdi_sio; do modprobe $module; done
usb_port() { # SERIAL: the tty of the port with this serial number
    local port
    for port in /sys/bus/usb-serial/devices/*; do
        [ "$(cat "$(dirname "$(dirname "$(readlink -f $port)")")/serial" 2>/dev/null)" = $1 ] && echo /dev/$(basename $port)
    done
}
has_ports() { for i in "$@"; do [ -n "$(usb_port $i)" ] || return 1; done; }
wait_for 30 has_ports board adapter host
board=$(usb_port board) adapter_end=$(usb_port adapter) host_end=$(usb_port host)
for i in 0 1 2; do ip link add vcan$i type vcan; ip link set vcan$i up; done

echo 16777216 >/proc/sys/net/core/rmem_default # for candump and slcanpty, which ask for nothing; matrig asks

# --- what a person can get wrong ---
check "an interface that is not there: those that are, are named" \
    fails_with 3 "no such CAN interface: can:can7; there are can0, can1, vcan0" matrig log --can can:can7 --db x.db
check "an interface that is down" fails_with 3 "is down: can:can0; run: ip link set can0 up type can bitrate 1000000" \
    matrig log --can can:can0 --db x.db
check "a network interface that is no CAN" fails_with 3 "no such CAN interface: can:lo" matrig log --can can:lo --db x.db
cards_up
check "a port that is not there: those that are, are named" \
    fails_with 3 "serial:/dev/ttyUSB9; there are /dev/tty.*ttyUSB0" matrig log --serial serial:/dev/ttyUSB9 --db x.db
check "a rate that the port does not do" \
    fails_with 3 "does not support 2000000 baud and uses [0-9]+ baud instead: serial:/dev/ttyS1;" matrig log --serial serial:/dev/ttyS1 --db x.db

# --- a landing over two SJA1000 cards, and 2 Mbaud of USB ---
links="--can can:can0 --serial serial:$board"
start_log cards
check "a second matrig on the port is refused" \
    fails_with 3 "another program uses the serial port: serial:$board" matrig log --serial serial:$board --db x.db
candump -L can0 >cards.dump &
dumper=$!
wait_for 20 listeners can0 2
bridge board /dev/vport0p1 can1 100 >bridge.txt 2>&1 &
bridge=$!
echo "# host: start board 1"
frames_in() { [ "$(db $1 "select count(*) from $2" 2>/dev/null || echo 0)" -ge $3 ]; }
sent_can=$(wc -l <$landing.can)
landing_logged() { # NAME: its summary is there, and all that the board sends in the landing and after it
    wait_for 120 says "^  faults" $1.txt && wait_for 60 frames_in $1 "frames where link = 0" $sent_can
}
check "a landing of the board outside reaches matrig log" landing_logged cards
wait_for 30 frames_in cards blocks 5600
cansend can0 400#0300341207000000
answered() { # the record is serial's; raw, the answer is there from both links
    [ "$(db cards "select count(*) from events where kind = 'ack' and value = $((0x1234)) and links = 2")" = 1 ] &&
        [ "$(db cards "select count(distinct link) from frames where can_id = $((0x0b0)) and hex(data) like '____3412%'")" = 2 ]
}
check "a command put on the bus reaches the board, and its answer matrig on both links" wait_for 60 answered
stop_log
kill $dumper
echo "# host: stop board 1"
wait_for 20 sh -c "! kill -0 $bridge"
cards_complete() {
    cat cards.txt cards.err
    says "^RUN 1: landing 5, done" cards.txt && [ "$(lost_in cards)" = 0 ] && ! says "link in this session" cards.txt &&
        rows_of cards 0 | head -n $sent_can >cards.rows && awk '{print $3}' $landing.can >cards.sent && cmp cards.rows cards.sent
}
check "every CAN frame is there, in order, equal to what the board sent" cards_complete
serial_complete() { # the same as the board's bytes from a file: other messages in order, then block records
    matrig --quiet log --serial file:$landing.serial --db file.db >/dev/null || return 1
    for table in "frames where link = 1 and direction = 0 order by id" "blocks order by idx"; do
        what="hex(data)"
        [ "${table#blocks}" = "$table" ] || what="hex(record)"
        db file "select $what from $table" >file.rows
        db cards "select $what from $table" | head -n $(wc -l <file.rows) >cards.rows
        wc -l file.rows cards.rows
        [ -s file.rows ] && cmp file.rows cards.rows || return 1
    done
}
check "every serial frame is there, equal to what the board sent" serial_complete
dump_complete() { awk '{print $3}' cards.dump | head -n $sent_can >dump.rows && cmp dump.rows cards.sent; }
check "candump on the same interface saw the same" dump_complete
stamps_are_the_kernels() { # candump has the kernel's stamps too
    awk '{gsub(/[().]/, "", $1); print $1 + 0}' cards.dump | head -n $sent_can >dump.stamps &&
        db cards "select host_us from frames where link = 0 order by id limit $sent_can" >cards.stamps &&
        head -n 3 dump.stamps cards.stamps && cmp dump.stamps cards.stamps
}
check "frames have the kernel's time stamps" stamps_are_the_kernels
say "landing over two SJA1000 cards and USB serial at 2000000 baud: CAN $sent_can and more frames received, equal to those sent;" \
    "serial $(wc -c <$landing.serial) and more bytes, $(db cards 'select received from links where link = 1') frames; lost $(lost_in cards)"

# --- an SLCAN adapter by Linux's own driver: a null modem of two USB ports, with slcanpty of can-utils as the adapter ---
stty -F $adapter_end raw -echo 2000000
slcanpty $adapter_end vcan1 >slcanpty.txt 2>&1 &
adapter=$!
modprobe slcan
slcand -o -s8 -S 2000000 $host_end can2
wait_for 20 test -e /sys/class/net/can2
ip link set can2 up
links="--can can:can2"
start_log slcan
check "the adapter is opened" wait_for 20 listeners vcan1 1
head -n 3000 $landing.can >slcan.can
# At a pace that an emulated computer's USB keeps up with.
timeout 300 canplayer -t -g 2 -I slcan.can vcan1=can0
wait_for 60 frames_in slcan frames 3000
usleep 500000
stop_log
slcan_complete() {
    cat slcan.txt slcan.err
    rows_of slcan 0 >slcan.rows && awk '{print $3}' slcan.can >slcan.sent && cmp slcan.rows slcan.sent && [ "$(lost_in slcan)" = 0 ] &&
        ! says "link in this session" slcan.txt
}
check "what the adapter brings is complete" slcan_complete
say "SLCAN by slcand at 2000000 baud: $(wc -l <slcan.sent) frames sent, $(db slcan 'select received from links where link = 0') received, lost $(lost_in slcan)"
kill $adapter $(pidof slcand)

# --- a 16550 ---
links="--serial serial:/dev/ttyS1:115200"
start_log uart
echo "# host: start board 2"
uart_complete() { # the first second, equal to the board's bytes from a file
    head -c 65536 $landing.serial >head.serial
    matrig --quiet log --serial file:head.serial --db head.db >/dev/null
    wait_for 60 sh -c '[ "$(sqlite3 uart.db "select count(*) from blocks")" -ge 700 ]' || return 1
    rows_of head 1 | head -n 400 >head.rows
    rows_of uart 1 | head -n 400 >uart.rows
    cmp head.rows uart.rows
}
check "bytes of the board through a 16550" uart_complete
stop_log
echo "# host: stop board 2"
check "none of them is lost" test "$(lost_in uart)" = 0
say "serial over a 16550 at 115200 baud, the most it does: $(db uart 'select received from links') frames, lost $(lost_in uart)"

# --- the boot ROM over the same 16550, by stm32flash ---
usleep 2000000 # until the port has lost the board before
echo "# host: start board 4"
usleep 2000000
flashed() { # 8E1: the board outside hears nothing else
    matrig flash serial:/dev/ttyS1:115200 /data/small.bin --force >flash.txt 2>&1
    local status=$?
    cat flash.txt
    [ $status -eq 0 ] && says " [1-9][0-9]* bytes, identical to the file" flash.txt
}
check "matrig flash programs and verifies a board through the 16550, 8E1" flashed
echo "# host: stop board 4"
say "boot ROM over a 16550 at 115200 baud 8E1: $(sed -n 's/^read back *//p' flash.txt)"

# --- vcan and can-utils ---
links="--can can:vcan0"
start_log played
candump -L vcan0 >played.dump &
dumper=$!
wait_for 20 listeners vcan0 2
canplayer -I $landing.can vcan0=can0
wait_for 20 says "^  faults" played.txt
cangen vcan0 -g 0 -n 3000 -e -L 8 -D i
usleep 1000000
stop_log
kill $dumper
played_complete() {
    cat played.txt played.err
    awk '{print $3}' played.dump >dump.rows
    # cangen's extended identifiers have 8 digits in candump's log and bit 31 in the campaign
    db played "select case when can_id >= 0x80000000 then printf('%08X#', can_id - 0x80000000) else printf('%03X#', can_id) end || hex(data)
               from frames order by id" >played.rows
    says "^RUN 1: landing 5, done" played.txt && [ "$(lost_in played)" = 0 ] &&
        [ "$(wc -l <played.rows)" = $(($(wc -l <$landing.can) + 3000)) ] && cmp played.rows dump.rows
}
check "canplayer and cangen over vcan: matrig and candump keep the same" played_complete

# --- errors on the bus, told to the user ---
# While the gear rolls, after the third motion message: no acknowledgement; error passive, counters 136 and 0; bus off; restarted;
# arbitration lost in bit 11 and stuffing error in the data.
awk '{ print } $3 ~ /^091#/ && ++motions == 3 { split("20000020#0000000000000000 20000204#0030000000008800 20000040#0000000000000000 \
    20000100#0000000000000000 2000008A#0B00040A00000000", error); for (i = 1; i <= 5; i++) print $1, $2, error[i] }' $landing.can >errors.can
start_log errors
canplayer -I errors.can vcan0=can0
wait_for 20 says "^  faults" errors.txt
stop_log
errors_told() {
    cat errors.err
    says "can:vcan0: no acknowledgement: 1$" errors.err && says "can:vcan0: error passive: 1$" errors.err &&
        says "can:vcan0: bus off: 1$" errors.err && says "can:vcan0: restarted after bus off: 1$" errors.err &&
        says "can:vcan0: arbitration lost: 1$" errors.err
}
check "error frames and bus off are told at once" errors_told
errors_summed() {
    cat errors.txt
    says "^  CAN link .*bus off 1, restarted after bus off 1, error passive 1, no acknowledgement 1, arbitration lost 1" errors.txt &&
        [ "$(db errors "select count(*) from frames where can_id & 0x20000000")" = 5 ] && [ "$(db errors 'select outside from links')" = 0 ] &&
        [ "$(db errors "select sum(detail) from events where kind = 'can-link' and code = 0 and landing = 1")" = 1 ]
}
check "and are in the landing's summary and in the campaign" errors_summed
grep "can:vcan0" errors.err | sed 's/^/# figure: shown: /'

# --- a receive queue that overflows, as for a user without rights ---
chmod 666 /dev/null
mkdir nobody && chmod 777 nobody
links="--can can:vcan0"
cd nobody || exit 1
start_log queue su user -c 'exec "$0" "$@"' --
usleep 300000
held=$(pidof matrig)
kill -STOP $held
cangen vcan0 -g 0 -n 4000 -I 300 -L 8 -D i
kill -CONT $held
wait_for 60 frames_in queue frames 1 # what the queue held is read: there is room for the next one
usleep 300000
cansend vcan0 301#
queue_told() { [ "$(db queue "select count(*) from frames where can_id = $((0x301))")" = 1 ] && [ "$(db queue "select count(*) from events where code = 14")" -gt 0 ]; }
wait_for 60 queue_told
kill -INT $held
wait_for 20 sh -c "! kill -0 $held"
queue_counted() {
    local kept lost
    kept=$(db queue "select count(*) from frames where can_id = $((0x300))")
    lost=$(db queue "select coalesce(sum(detail), 0) from events where kind = 'can-link' and code = 14")
    cat queue.txt queue.err
    echo "kept $kept lost $lost"
    [ "$lost" -gt 0 ] && [ $((kept + lost)) -eq 4000 ] && says "frames lost in this computer's receive queue: $lost" queue.err
}
check "frames that the receive queue loses are counted and told" queue_counted
say "receive queue without privileges, logger held: 4000 sent, $(db queue "select count(*) from frames where can_id = $((0x300))") kept, $(db queue "select sum(detail) from events where code = 14") reported lost"
cd ..

# --- devices that go away ---
start_log down
ip link set vcan0 down
wait_for 10 says "went away" down.err
ip link set vcan0 up
wait_for 10 says "came back" down.err
cansend vcan0 123#11
usleep 700000
stop_log
came_back() { cat down.err; says "can:vcan0: went away: 1" down.err && says "came back: 1" down.err && [ "$(db down 'select count(*) from frames')" = 1 ]; }
check "an interface that goes down and up again goes on" came_back

echo "# host: start board 3"
wait_for 20 has_ports plugged
plugged=$(usb_port plugged)
links="--serial serial:$plugged --wait 10"
start_log usb
wait_for 20 sh -c '[ "$(sqlite3 usb.db "select count(*) from blocks")" -gt 50 ]'
echo "# host: stop board 3"
wait_for 20 says "went away" usb.err
echo "# host: start board 3"
wait_for 15 says "came back" usb.err
usb_back() {
    cat usb.err
    says "serial:$plugged: went away: 1" usb.err && says "came back: 1" usb.err
}
check "a USB port that is unplugged and plugged in again goes on" usb_back
seen=$(db usb "select count(*) from frames")
check "and the board's frames come again" wait_for 20 sh -c "[ \"\$(sqlite3 usb.db 'select count(*) from frames')\" -gt $((seen + 20)) ]"
echo "# host: stop board 3"
gone() {
    local status
    wait_for 30 sh -c "! kill -0 $logger" || kill -KILL $logger
    wait $logger
    status=$?
    cat usb.err
    [ $status -eq 3 ] && says "the device was disconnected: serial:$plugged; plug it in again \(waited 10 s for the device; now: .*\)" usb.err
}
check "one that stays away ends the log with one clear error" gone

echo "1..$tests"
