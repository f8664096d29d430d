#!/usr/bin/env bash
# matrig-board --vcd and --profile: read by programs that are not ours, and counted against what the board itself counts.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
run=tests/runs/landing5.run

traced() { # NAME ARGUMENTS...
    local name=$1
    shift
    build/matrig-board --elf $elf --rig $run --for 2 --can "file:$tmp/$name.can" --serial "file:$tmp/$name.serial" "$@" 2>"$tmp/$name.err"
}
trace() {
    traced a --vcd "$tmp/a.vcd" --profile "$tmp/a.profile" || { cat "$tmp/a.err"; return 1; }
    cat "$tmp/a.err"
    # GTKWave's own converter reads it into its format; what it has read is what the checks below look at
    vcd2fst "$tmp/a.vcd" "$tmp/a.fst" && fst2vcd "$tmp/a.fst" >"$tmp/read.vcd" && [ "$(wc -l <"$tmp/read.vcd")" -gt 10000 ]
}
# lane NAME: rises, time high in ns, shortest time from rise to rise in ns, last value
lane() {
    awk -v name="$1" '
        /^\$var/ && $5 == name { code = $4; found = 1 }
        /^#/ { t = substr($0, 2) + 0 }
        /^[01]/ && substr($0, 2) == code { v = substr($0, 1, 1)
            if (v == 1 && was == 0) { rises++; if (last != "" && (gap == "" || t - last < gap)) gap = t - last; last = t; from = t }
            if (v == 0 && was == 1) high += t - from
            was = v }
        END { if (!found) exit 1; if (was == 1) high += t - from; print rises + 0, high + 0, gap, was }' "$tmp/read.vcd"
}
counted() { sed -n "s/.* $1.*/\\1/p" "$tmp/a.err"; }
pins_are_right() {
    # A scan takes 125 us and reverses the excitation: 250 us from rise to rise, half of the time high. RM0090 18, scan.c.
    # A change that falls into the entry or return of an exception (12 and 10 cycles) and a block is seen after them: 0.3 us at most.
    read -r rises high gap _ < <(lane PD12_excitation_plus)
    echo "excitation: $rises rises, $high ns high, least period $gap ns"
    [ "$gap" -ge 249700 ] && [ "$gap" -le 250000 ] && [ $((high - 125000 * rises)) -ge -200000 ] && [ $((high - 125000 * rises)) -le 200000 ] || return 1
    # a one-shot of 20 us for each switch that opened by then, as the run file says
    read -r rises high _ < <(lane PA15_switch_edge)
    opened=$(awk '/^switch / && $5 != "-" && $5 < 2.0 { n++ } END { print n + 0 }' $run)
    echo "edges: $rises rises, $high ns high; switches opened $opened"
    [ "$opened" -ge 3 ] && [ "$rises" -eq "$opened" ] && [ $((high - 20000 * rises)) -ge -50 ] && [ $((high - 20000 * rises)) -le 50 ]
}
links_are_right() {
    read -r rises _ < <(lane can_frame)
    frames=$(sed -n 's/.*CAN \([0-9]*\) out \([0-9]*\) in.*/\1 + \2/p' "$tmp/a.err")
    read -r _ high _ < <(lane usart1_tx)
    bytes=$(sed -n 's/.*serial \([0-9]*\) bytes out.*/\1/p' "$tmp/a.err")
    echo "can_frame: $rises rises, frames $frames; usart1_tx high $high ns, $bytes bytes of 5000 ns"
    [ "$rises" -eq $((frames)) ] || [ "$rises" -eq $((frames + 1)) ] && [ $((high - 5000 * bytes)) -ge -200000 ] && [ $((high - 5000 * bytes)) -le 200000 ]
}
core_is_right() { # the block interrupt comes each millisecond; sleep as the profile counts it; lamp off after start
    read -r rises _ gap _ < <(lane irq60_dma2_stream4_irq)
    read -r _ asleep _ < <(lane sleeping)
    of_profile=$(sed -n '1s/.*asleep for \([0-9.]*\) %.*/\1/p' "$tmp/a.profile")
    entries=$(awk '$4 == "dma2_stream4_irq" { n += $3 } END { print n + 0 }' "$tmp/a.profile")
    echo "irq60: $rises rises, least gap $gap ns, entries by the profile $entries; asleep $asleep ns, profile $of_profile %"
    [ "$rises" -ge 1980 ] && [ "$rises" -eq "$entries" ] && [ "$gap" -gt 990000 ] && [ "$gap" -lt 1000100 ] || return 1
    # the profile counts cycles, of which the first milliseconds at 16 MHz have fewer: within 0.5 %
    awk -v ns="$asleep" -v p="$of_profile" 'BEGIN { d = ns / 2e7 - p; print "difference", d; exit !(d < 0.5 && d > -0.5) }'
}
# The lane of the exception that runs and the lanes of single exceptions are of one mind at each time; the clock and the resets end
# where the run does.
numbers_are_right() {
    awk '
        function look(n, any) {
            for (n in lane) any += value[lane[n]]
            if (running ? !(running in lane) || !value[lane[running]] : any) { print "at", t, "exception", running; wrong = 1 }
        }
        /^\$var/ { name[$4] = $5; n = $5; sub(/_.*/, "", n)
            if (sub(/^irq/, "", n)) lane[n + 16] = $4; else if (sub(/^exception/, "", n) && n != "") lane[n] = $4 }
        /^#/ { if (t != "") look(); t = substr($0, 2) }
        /^[01]/ { value[substr($0, 2)] = substr($0, 1, 1) }
        /^b/ { v = 0; for (i = 2; i <= length($1); i++) v = 2 * v + substr($1, i, 1)
            if (name[$2] == "exception") { running = v; seen[v] = 1 }
            if (name[$2] == "hclk_hz") hz = v
            if (name[$2] == "resets") resets = v }
        END { look(); print "irq60 seen", seen[76] + 0, "hclk_hz", hz, "resets", resets; exit wrong || !seen[76] || hz != 168000000 || resets != 0 }' "$tmp/a.vcd"
}
same_bytes() { # tracing changes nothing, and two traces are equal, at any speed
    traced plain && traced again --vcd "$tmp/again.vcd" --profile "$tmp/again.profile" --speed real || return 1
    for kind in can serial; do cmp "$tmp/plain.$kind" "$tmp/a.$kind" && cmp "$tmp/plain.$kind" "$tmp/again.$kind" || return 1; done
    cmp "$tmp/a.vcd" "$tmp/again.vcd" && cmp "$tmp/a.profile" "$tmp/again.profile" || return 1
    traced seed --seed 2 --vcd "$tmp/seed.vcd" && ! cmp -s "$tmp/seed.serial" "$tmp/a.serial"
}
profile_adds_up() {
    said=$(sed -n 's/.* \([0-9]*\) instructions.*/\1/p' "$tmp/a.err")
    awk -v said="$said" '
        NR == 1 { total = $3 }
        /^by function/ { on = 1 }
        on && $1 ~ /^[0-9]+$/ { sum += $1 }
        END { print total, said, sum; exit !(said > 1e6 && total == said && sum == said) }' "$tmp/a.profile"
}
profile_is_sorted() { awk '/^by function/ { on = 1; next } on && $1 ~ /^[0-9]+$/ { if (n++ && $1 > last) exit 1; last = $1 } END { exit !(n > 50) }' "$tmp/a.profile"; }
refusals() {
    fails_with 3 "--vcd: cannot write .*; give a different file" build/matrig-board --elf $elf --vcd /nowhere/x --for 1 &&
        fails_with 3 "--profile: cannot write .*; give a different file" build/matrig-board --elf $elf --profile /nowhere/x --for 1 &&
        fails_with 2 "--vcd and --profile have the same file" build/matrig-board --elf $elf --profile "$tmp/z" --vcd "$tmp/z" --for 1 || return 1
    build/matrig-board --elf $elf --vcd /dev/full --for 1 2>"$tmp/full.err"
    local status=$?
    cat "$tmp/full.err"
    [ $status -eq 3 ] && grep -q 'cannot write all of /dev/full.*free disk space' "$tmp/full.err"
}

check "GTKWave's converter reads the trace" trace
check "pins: excitation and switch edges" pins_are_right
check "links: CAN frames and serial bytes" links_are_right
check "core: interrupts and sleep" core_is_right
check "core: the exception that runs, clock, resets" numbers_are_right
check "tracing changes nothing, and is the same each time" same_bytes
check "a profile adds up to the instructions of the run" profile_adds_up
check "by instructions, the most first" profile_is_sorted
check "what cannot be written is refused" refusals
finish
