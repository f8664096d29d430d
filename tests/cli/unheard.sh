#!/usr/bin/env bash
# What a record did not hear it does not deny: a log that breaks off before the landing is over, or has a hole, says so beside "no warning" and
# above the peaks. Landing 5 is warned of in block 4440 of the board, and rests at 0.2706 in at transducer 8.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
json() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.$2')"; }
same() { echo "$1; wanted $2"; [ "$1" = "$2" ]; }
log() { # NAME LINK...
    $matrig --quiet log --all "${@:2}" --db "$tmp/$1.db" >"$tmp/$1.txt" 2>"$tmp/$1.err"
    $matrig --quiet report "$tmp/$1.db" -o "$tmp/$1.html"
}

played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run >/dev/null 2>&1
head -n 6500 "$tmp/can" >"$tmp/early.can"
lines=$(wc -l <"$tmp/can")
(head -n 9000 "$tmp/can" && tail -n $((lines - 16000)) "$tmp/can") >"$tmp/hole.can"
(head -n 9000 "$tmp/can" && tail -n $((lines - 18000)) "$tmp/can") >"$tmp/gone.can"
(head -c 500000 "$tmp/serial" && tail -c 200000 "$tmp/serial") >"$tmp/hole.serial"
(head -c 380000 "$tmp/serial" && tail -c 260000 "$tmp/serial") >"$tmp/edges.serial"
log edges --serial "file:$tmp/edges.serial"
log whole --can "file:$tmp/can" --serial "file:$tmp/serial"
log early --can "file:$tmp/early.can"
log hole --can "file:$tmp/hole.can"
log gone --can "file:$tmp/gone.can"
log late --serial "file:$tmp/hole.serial"

whole_is_whole() {
    ! grep -i 'not known\|not heard\|were lost\|may have' "$tmp/whole.txt" && ! grep -o 'A warning may have come[^<]*' "$tmp/whole.html"
}
breaks_off() { # in the log and the page
    grep '^  zone  *no warning was received, but one may have been sent: the record ends 0.[89][0-9]* s after touchdown, before the board reported the end of the landing$' "$tmp/early.txt" &&
        grep -o 'no warning was received, but one may have been sent: the record ends' "$tmp/early.html" | head -n 1 | grep -q .
}
# The board named 19; without the last two the gear seemed to stop at 99.27 +- 0.02 ft, and did at 90.8.
lacks_edges() {
    grep -h '^  switches\|^  stop' "$tmp/edges.txt"
    grep -q '^  switches  *17 of 24 seen; switches 18 to 24 not received$' "$tmp/edges.txt" &&
        grep -q '^  stop  *not known: 2 of the 19 switch edges that the board reported are missing in the record$' "$tmp/edges.txt" &&
        grep -q '2 of the 19 switch edges that the board reported are missing in the record' "$tmp/edges.html" && fails_with 4 '2 of the 19 switch edges that the board reported are missing in the record: RUN 1; complete the landing from the black box' $matrig compare "$tmp/edges.db" 1
}
# The board's own result was lost, too: the hole alone must do.
lacks_edges_and_result() {
    cp "$tmp/edges.db" "$tmp/alone.db" && sqlite3 "$tmp/alone.db" 'delete from results'
    $matrig --quiet report "$tmp/alone.db" -o "$tmp/alone.html" && grep -o '<dt>stop</dt><dd[^>]*>[^<]*' "$tmp/alone.html" | tee "$tmp/alone.stop"
    grep -q 'not known: data is missing at the time when the gear passed switch 18$' "$tmp/alone.stop" &&
        fails_with 4 'data is missing at the time when the gear passed switch 18: RUN 1; complete the landing from the black box' $matrig compare "$tmp/alone.db" 1
}
has_a_hole() { # into which the warning falls, or its beginning
    grep -h '^  zone' "$tmp/hole.txt" "$tmp/gone.txt"
    grep -Eq '^  *an earlier warning may have been missed: no zone message was received from 1\.7[0-9]* to 4\.1[0-9]* s after touchdown$' "$tmp/hole.txt" &&
        grep -q '^  zone  *warned 4\.1' "$tmp/hole.txt" &&
        grep -Eq '^  zone  *no warning was received, but one may have been sent: no zone message was received from 1\.7[0-9]* to 4\.[78][0-9]* s after touchdown$' "$tmp/gone.txt"
}
# The same in the pages: a first warning is the first that was received, and when the wheel reached it is not known without a stop.
first_that_was_heard() {
    grep -q '^  first warning received ' "$tmp/hole.txt" && ! grep -q 'warning received (+-' "$tmp/whole.txt" &&
        grep -q '^    predicted time to zone .*; actual: unknown, because the record does not show where the gear stopped$' "$tmp/hole.txt" &&
        grep -q 'first warning received (' "$tmp/hole.html"
}
ends_while_it_moves() { # once above each table
    same "$(tr -s ' \n' '  ' <"$tmp/early.txt" | grep -o 'The record ends 0\.9[0-9]* s after touchdown, while the gear moves: peaks and end values cover only the time until then' | wc -l)" 2 &&
        ! grep 'The record ends' "$tmp/whole.txt"
}
peaks_are_told() {
    tr -s ' \n' '  ' <"$tmp/late.txt" | grep -Eo 'Readings are missing from 4\.[0-9]* to 5\.[0-9]* s \(transducers 1, 2, 3, 4, 5, 6, 7, 8\): a peak in this interval is not measured, and the stated errors do not include this' &&
        grep -Eo 'Readings are missing from 4\.[0-9]* to 5\.[0-9]* s \(gages 1, 2, 3, .*, 13, 14\)' "$tmp/late.html"
}
# All switches break at 3.6 s, behind the thirteenth: by the others the gear seemed to stop at 99.27 +- 0.02 ft, and did at 90.7.
never_opened() {
    { echo "matrig-faults 1" && for n in $(seq 24); do echo "at 3.6 switch $n skip"; done; } >"$tmp/broken.faults" &&
        build/matrig-board --elf build/firmware/matrig.elf --faults "$tmp/broken.faults" --can "file:$tmp/broken.can" --serial "file:$tmp/broken.serial" \
            --rig tests/runs/landing5.run >/dev/null 2>&1
    log broken --can "file:$tmp/broken.can" --serial "file:$tmp/broken.serial"
    grep -h '^  switches\|^  stop' "$tmp/broken.txt"
    grep -q '^  stop  *not known: switch 14 and later ones did not open, though the gear passed them$' "$tmp/broken.txt" && ! grep '99\.2' "$tmp/broken.txt"
}
check "a whole record needs no doubt" whole_is_whole
check "one that breaks off does not know of a later warning" breaks_off
check "one with a hole does not know of a warning in it" has_a_hole
check "the last switches in a hole: no stop is made up" lacks_edges
check "nor without the result that tells how many there were" lacks_edges_and_result
check "a first warning is the first that was received, in the log and the page" first_that_was_heard
check "a record that ends while the gear moves says so above its peaks" ends_while_it_moves
check "a peak may have fallen into a hole" peaks_are_told
check "switches that never opened before where it seems to have stopped: no stop" never_opened
finish
