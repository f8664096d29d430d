#!/usr/bin/env bash
# matrig ready against the emulated board: go; no-go for each thing that is not right, named; the walk test; what landings say of it.
. "$(dirname "$0")/tap.sh"
elf=build/firmware/matrig.elf
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

# rig NAME KEY=VALUE...: a run file of a rig at rest, all bands at lb= (100). switches=, push=, pull=: in that order, one each gap= s from
# 3 s on, by 0.2 in for half a second (the mats beside it by 0.08) or 20 lb.
rig() {
    python3 - "$tmp/$1.run" "${@:2}" <<'P'
import sys, zlib
given = dict(a.split("=") for a in sys.argv[2:])
of = lambda name: [int(x) for x in given[name].split(",")] if given.get(name) else []
gap, tension, rate, first = float(given.get("gap", 1.4)), float(given.get("lb", 100)), 10, 3.0
seconds = first + gap * max(len(of("push")) + len(of("pull")), 1) + 2 + 0.5 * len(of("switches"))
opens = {p: first + float(given.get("trip", 0.5)) * i for i, p in enumerate(of("switches"))}
lines = []
for line in open("tests/runs/landing5.run"):
    if line.startswith("samples"):
        break
    if not line.startswith(("command", "switch", "duration")):
        lines.append(line.rstrip("\n"))
lines.append("duration_s %g" % seconds)
for p in range(1, 25):
    ft = -2.5 + 5 * (p - 1)
    lines.append("switch %d %g %g %s" % (p, ft, ft, "%.3f" % opens[p] if p in opens else "-"))
rows = [[0] * 8 + [int(100 * tension)] * 14 for _ in range(int(seconds * rate))]
def during(i):
    return range(int((first + gap * i) * rate), int((first + gap * i + 0.5) * rate))
for i, k in enumerate(of("push")):
    for row in during(i):
        for beside in (k - 1, k + 1):
            if 1 <= beside <= 8:
                rows[row][beside - 1] = 8000
        rows[row][k - 1] = 20000
for i, k in enumerate(of("pull"), len(of("push"))):
    for row in during(i):
        rows[row][8 + k - 1] += 2000
lines.append("samples %d %d" % (len(rows), rate))
lines += [" ".join(map(str, row)) for row in rows]
text = "\n".join(lines) + "\n"
open(sys.argv[1], "w").write(text + "end %08x\n" % zlib.crc32(text.encode()))
P
}
# with_board BOARD-OPTION... -- ARGUMENTS...: matrig ready against a board; its exit code. Each check's lines are one in ready.txt.
global=()
one_line_each() { sed -Ez 's/\n {29}([^- ])/ \1/g; s/\n {32}/ /g' "$tmp/printed.txt" >"$tmp/ready.txt"; }
with_board() {
    local board status options=()
    while [ "$1" != -- ]; do options+=("$1"); shift; done
    shift
    timeout 600 build/matrig-board --elf $elf --serial "unix:$sockets/serial" --can "unix:$sockets/can" "${options[@]}" 2>"$tmp/board.err" &
    board=$!
    timeout 600 build/matrig --quiet "${global[@]}" ready "$1" --serial "unix:$sockets/serial" --can "unix:$sockets/can" "${@:2}" >"$tmp/printed.txt" 2>&1
    status=$?
    kill $board 2>/dev/null
    wait $board 2>/dev/null
    one_line_each
    cat "$tmp/ready.txt"
    return $status
}
# no_go FAULTS LINE ARGUMENTS...: with these faults (lines, or none) the check is no-go, as LINE says, and so is the whole
no_go() {
    local line=$2
    printf 'matrig-faults 1\n%b\n' "$1" >"$tmp/faults"
    with_board --rig "$tmp/rest.run" --for 60 --faults "$tmp/faults" -- "$tmp/campaign.db" "${@:3}"
    [ $? = 1 ] && grep -Eq "^NO-GO +$line" "$tmp/ready.txt" && tail -n 1 "$tmp/ready.txt" | grep -Eq '^NO-GO after [0-9.]+ s: '
}
only_no_go() { no_go "$@" && [ "$(grep -c '^NO-GO ' "$tmp/ready.txt")" = 2 ]; } # that check and the verdict
walk() { # NAME ARGUMENTS...
    with_board --rig "$tmp/$1.run" --for 60 -- "$tmp/walks.db" --walk
}

rig rest
a_first_time_is_go() { # nothing to compare with yet: told, no reason for a no-go
    with_board --rig "$tmp/rest.run" --for 60 -- "$tmp/campaign.db" && tail -n 1 "$tmp/ready.txt" | grep -Eq '^GO, UNCALIBRATED after [0-9.]+ s: [0-9]+ of [0-9]+ checks passed, 7 not done$' &&
        grep -Eq '^not done +firmware ' "$tmp/ready.txt" && grep -Eq '^not done +brown-out reset +off, the factory setting \[on\]' "$tmp/ready.txt" && [ "$(grep -Ec '^GO +(transducer|gage) +[0-9]' "$tmp/ready.txt")" = 22 ] &&
        grep -Eq '^not done +gage zeros +the zeros of 14 of 14 gages were not measured since reset; the configured zeros are used, \+- 1\.[0-9] lb' "$tmp/ready.txt" && grep -Eq '^GO +band 2 +pretension (99|100)\.[0-9] lb' "$tmp/ready.txt" && grep -Eq '^GO +shunt calibration +14 gages good; no earlier calibration' "$tmp/ready.txt"
}
a_landing_names_it() { # logged at once after, it says so; and the next time has something to compare with
    timeout 600 build/matrig-board --elf $elf --serial "unix:$sockets/serial" --can "unix:$sockets/can" --rig tests/runs/landing5.run 2>"$tmp/board.err" &
    build/matrig --quiet log --all --serial "unix:$sockets/serial" --can "unix:$sockets/can" --db "$tmp/campaign.db" >"$tmp/log.txt" 2>&1
    wait
    cat "$tmp/log.txt"
    grep -Eq '^  ready +go, [0-9]+ min before$' "$tmp/log.txt" && grep -q '^RUN 1: .*, done, UNCALIBRATED (emulated board, synthetic data)$' "$tmp/log.txt" && build/matrig show "$tmp/campaign.db" | grep 'done, UNCALIBRATED' && build/matrig compare "$tmp/campaign.db" 1 | grep '^RUN  *1, UNCALIBRATED$' && build/matrig export "$tmp/campaign.db" 1 --format csv | grep '^# UNCALIBRATED' &&
        build/matrig --quiet report "$tmp/campaign.db" -o "$tmp/report.html" >/dev/null && [ "$(grep -o 'done, UNCALIBRATED (emulated board, synthetic data)<' "$tmp/report.html" | wc -l)" = 1 ] && grep -q '<p>UNCALIBRATED: a sensor has no calibration date' "$tmp/report.html" && ! grep '>never<' "$tmp/report.html" &&
        grep -Eq '<dt>ready</dt><dd>go, [0-9]+ min before' "$tmp/report.html" && build/matrig --quiet bundle "$tmp/campaign.db" 1 -o "$tmp/bundle.db" >/dev/null &&
        [ "$(sqlite3 "$tmp/bundle.db" 'select kind, verdict from readiness')" = 'ready|go' ]
}
the_second_time_compares() {
    with_board --rig "$tmp/rest.run" --for 60 -- "$tmp/campaign.db" --image $elf && grep -Eq '^GO +configuration .*as in RUN 1' "$tmp/ready.txt" &&
        grep -Eq '^GO +firmware .*of build/firmware/matrig.elf' "$tmp/ready.txt" && grep -Eq '^GO +shunt calibration +14 gages good; change since the last calibration [+-]0\.[0-9]+ lb at most' "$tmp/ready.txt" &&
        with_board --rig "$tmp/rest.run" --for 60 -- "$tmp/campaign.db" && grep -Eq '^GO +firmware .*as in RUN 1' "$tmp/ready.txt"
}
a_dated_sensor_is_calibrated() { # by its configuration, or anew: all 22 (bits 0 to 21) are known then
    sqlite3 "$tmp/campaign.db" ".backup $tmp/dated.db" ".backup $tmp/anew.db"
    sqlite3 "$tmp/dated.db" "update configurations set text = replace(text, 'calibrated_day = never', 'calibrated_day = 2026-03-14')"
    sqlite3 "$tmp/anew.db" "with recursive c(i) as (select 0 union all select i + 1 from c where i < 20) insert into recalibrations(landing, idx, item, was, value, made_us) select 1, i, -1, 1, 1, 0 from c"
    ! build/matrig show "$tmp/dated.db" 1 | grep UNCALIBRATED && build/matrig show "$tmp/anew.db" 1 | grep UNCALIBRATED && sqlite3 "$tmp/anew.db" "insert into recalibrations(landing, idx, item, was, value, made_us) values(1, 21, -1, 1, 1, 0)" &&
        ! build/matrig show "$tmp/anew.db" 1 | grep UNCALIBRATED
}
an_overdue_certificate_is_no_go() { # in a copy; one that holds beside it, the others as a note
    sqlite3 "$tmp/campaign.db" ".backup $tmp/cert.db"
    build/matrig --quiet calibrate d3 --db "$tmp/cert.db" --certificate 'number=A-1, laboratory=Lab, calibrated=2021-03-02, due=2022-03-01, uncertainty=0.4%, coverage=2' &&
        build/matrig --quiet calibrate t2 --db "$tmp/cert.db" --certificate 'number=A-2, calibrated=2021-03-02, due=2199-12-31, uncertainty=1, coverage=2' || return 1
    with_board --rig "$tmp/rest.run" --for 60 -- "$tmp/cert.db"
    [ $? = 1 ] && [ "$(grep -c '^NO-GO ' "$tmp/ready.txt")" = 2 ] && grep -Eq '^NO-GO +certificate d3 +overdue since 2022-03-02: No\. A-1, Lab$' "$tmp/ready.txt" && grep -Eq '^ +-> have the sensor calibrated' "$tmp/ready.txt" &&
        grep -Eq '^GO +certificate t2 +valid until 2199-12-31: No\. A-2$' "$tmp/ready.txt" && grep -Eq '^not done +certificates +no certificate for d1, d2, d4, ' "$tmp/ready.txt" && grep -Eq '^NO-GO after [0-9.]+ s: certificate d3; ' "$tmp/ready.txt"
}
lines_fit() { # no terminal: 100 columns; and nobody reads of -0.0
    awk 'length > 100' "$tmp/printed.txt" | grep . && return 1
    ! grep -E -- '(^|[^0-9.])-0(\.0+)?([^0-9.]|$)' "$tmp/printed.txt"
}
in_si_units() { # 100 lb are 445 N, a quarter of an inch 6.3 mm
    global=(--si)
    with_board --rig "$tmp/rest.run" --for 60 -- "$tmp/campaign.db"
    global=()
    grep -Eq '^GO +transducer 1 +[+-][0-9]\.[0-9]{3} mm from its zero, .*\[6\.3 mm, 3 codes\]' "$tmp/ready.txt" && grep -Eq '^GO +gage 5 +44[0-9]\.[0-9] N, .*\[445 \+- 111 N, 3 codes\]' "$tmp/ready.txt" &&
        grep -Eq '^GO +band 2 +pretension 44[0-9]\.[0-9] N, mean of 7 gages \[445 \+- 44 N\]' "$tmp/ready.txt" && grep -Eq 'since the last calibration [+-][0-9]\.[0-9]+ N at most' "$tmp/ready.txt" &&
        ! grep -E '[0-9] (lb|in|ft)\b' "$tmp/ready.txt"
}
json_says_the_same() {
    timeout 600 build/matrig-board --elf $elf --serial "unix:$sockets/serial" --rig "$tmp/rest.run" --for 60 2>"$tmp/board.err" &
    local board=$! status
    timeout 600 build/matrig --json ready "$tmp/campaign.db" --serial "unix:$sockets/serial" >"$tmp/ready.json"
    status=$?
    kill $board; wait $board
    [ $status = 0 ] && python3 - "$tmp/ready.json" <<'P'
import json, sys
d = json.load(open(sys.argv[1]))
checks = {c["name"]: c["verdict"] for c in d["checks"]}
assert d["verdict"] == "go" and d["kind"] == "ready" and d["took_s"] <= 20, d
assert checks["warning lamp"] == "GO" and checks["black box"] == "GO" and checks["CAN"] == "not done", checks
P
}
another_image() { # the landing ran the program of another build
    sqlite3 "$tmp/campaign.db" 'update landings set image_crc = image_crc + 1'
    only_no_go '' 'firmware .*as in RUN 1'
    local status=$?
    sqlite3 "$tmp/campaign.db" 'update landings set image_crc = image_crc - 1'
    return $status
}
somebody_writes() { # another program holds the campaign: told, and what was found is printed though not kept
    local kept writer status
    kept=$(sqlite3 "$tmp/campaign.db" 'select count(*) from readiness')
    mkfifo "$tmp/hold"
    timeout 600 python3 - "$tmp/campaign.db" "$tmp/hold" <<'P' &
import sqlite3, sys
db = sqlite3.connect(sys.argv[1], isolation_level=None)
db.execute("begin immediate")
open(sys.argv[2], "w").close()
open(sys.argv[2]).close()
P
    writer=$!
    timeout 600 cat "$tmp/hold"
    only_no_go '' 'database +.*locked'
    status=$?
    timeout 5 bash -c ": >'$tmp/hold'"
    wait $writer
    [ $status = 0 ] && [ "$(sqlite3 "$tmp/campaign.db" 'select count(*) from readiness')" = "$kept" ]
}
# from_state STATE: matrig ready once the board's CAN has told that state of landing 5, which nobody disarms
from_state() {
    local board relay status
    grep -Ev '^(end |command 8.875)' tests/runs/landing5.run >"$tmp/undisarmed.run"
    printf 'end %s\n' "$(gzip -c "$tmp/undisarmed.run" | tail -c 8 | head -c 4 | od -An -tx4 | tr -d ' ')" >>"$tmp/undisarmed.run"
    timeout 600 build/matrig-board --elf $elf --can "file:$tmp/state.log" --serial "unix:$sockets/serial" --rig "$tmp/undisarmed.run" --for 60 2>"$tmp/board.err" &
    board=$!
    timeout 600 python3 tests/board/relay.py "$sockets/serial" "$sockets/relay" "$tmp/state.log" " 0A0#0$1" &
    relay=$!
    await test -S "$sockets/relay"
    timeout 600 build/matrig --quiet ready "$tmp/campaign.db" --serial "unix:$sockets/relay" >"$tmp/ready.txt" 2>&1
    status=$?
    kill $board 2>/dev/null
    wait $board $relay 2>/dev/null
    cat "$tmp/ready.txt"
    return $status
}
after_a_landing() { # band 2 of landing 5 is slack and its switches are open; its record is in the black box
    from_state 4
    [ $? = 1 ] && grep -Eq '^GO +board .*idle' "$tmp/ready.txt" && grep -Eq '^NO-GO +band 2' "$tmp/ready.txt" && grep -Eq '^NO-GO +switches .*switches are open' "$tmp/ready.txt" &&
        grep -Eq '^GO +black box +ready, .* 1 records to free' "$tmp/ready.txt"
}
pretension() {
    rig slack lb=80
    with_board --rig "$tmp/slack.run" --for 60 -- "$tmp/campaign.db"
    [ $? = 1 ] && grep -Eq '^NO-GO +band 1 +pretension (79|80)\.[0-9] lb' "$tmp/ready.txt" && grep -q -- '-> tension the band' "$tmp/ready.txt" && ! grep -Eq '^NO-GO +gage' "$tmp/ready.txt"
}
a_latch_left_open() {
    rig latch switches=9 trip=0
    python3 - "$tmp/latch.run" <<'P'
import re, sys, zlib
text = re.sub(r"(?m)^end .*\n", "", open(sys.argv[1]).read()).replace("switch 9 37.5 37.5 3.000", "switch 9 37.5 37.5 0.050")
open(sys.argv[1], "w").write(text + "end %08x\n" % zlib.crc32(text.encode()))
P
    with_board --rig "$tmp/latch.run" --for 60 -- "$tmp/campaign.db"
    [ $? = 1 ] && grep -Eq '^NO-GO +switches +switch 9 is open' "$tmp/ready.txt"
}
all_answer() {
    rig good "switches=$(seq -s, 24)" push=1,2,3,4,5,6,7,8 "pull=$(seq -s, 14)" gap=1.2 trip=1
    walk good && grep -q '^GO  *switch walk  *all 24 responded, in order' "$tmp/ready.txt" && grep -q '^GO  *transducer walk  *all 8 responded' "$tmp/ready.txt" &&
        grep -q '^GO  *gage walk  *all 14 responded' "$tmp/ready.txt" && [ "$(sqlite3 "$tmp/walks.db" 'select kind, verdict from readiness')" = 'walk|go' ]
}
# 7 and 8 swapped; told while it goes on, with the step seen and the step configured
swapped_switches() {
    rig swap switches=1,2,3,4,5,6,8,7,9,10,11,12,13,14,15,16,17,18,19,20,21,22,23,24
    timeout 600 build/matrig-board --elf $elf --serial "unix:$sockets/serial" --can "file:$tmp/walk.log" --rig "$tmp/swap.run" --for 60 2>"$tmp/board.err" &
    timeout 600 build/matrig ready "$tmp/walks.db" --serial "unix:$sockets/serial" --walk >"$tmp/ready.txt" 2>&1
    local status=$?
    wait
    cat "$tmp/ready.txt"
    [ $status = 1 ] && grep -Eq '^NO-GO +switch 7 +responded in the place of number 8' "$tmp/ready.txt" && grep -Eq '^NO-GO +switch 8 +responded in the place of number 7' "$tmp/ready.txt" && [ "$(grep -c '^NO-GO ' "$tmp/ready.txt")" = 3 ] &&
        grep -Eq '^switch 8 \(32\.5 ft\): step of 7[12]\.[0-9] codes, configured step 72$' "$tmp/ready.txt"
}
a_walk_is_no_landing() { # what the board said on CAN meanwhile: edges, but no landing, no record in the black box
    build/matrig --quiet log --all --can "file:$tmp/walk.log" --db "$tmp/walklog.db" >"$tmp/log.txt" 2>&1
    cat "$tmp/log.txt"
    [ "$(sqlite3 "$tmp/walklog.db" 'select count(*) from landings')" = 0 ] && [ "$(grep -c ' 090#' "$tmp/walk.log")" = 24 ] && ! grep -Eq ' 0A0#0[1-4]' "$tmp/walk.log" &&
        grep -q ' 0C0#0200' "$tmp/walk.log" && ! grep -Eq ' 0C0#02(0[1-9]|[1-9A-F].)' "$tmp/walk.log"
}
dead_and_swapped() {
    rig dead "switches=$(seq -s, 11),$(seq -s, 13 24)" push=1,3,2,4,5,6,7,8
    walk dead
    [ $? = 1 ] && grep -Eq '^NO-GO +switch 12 +did not respond' "$tmp/ready.txt" && [ "$(grep -c '^NO-GO ' "$tmp/ready.txt")" = 4 ] && # and the verdict
        grep -Eq '^NO-GO +transducer 2 +responded in the place of number 3' "$tmp/ready.txt" && grep -Eq '^not done +gage walk +none of 14 responded' "$tmp/ready.txt"
}
check "the first time: go, and what could not be compared is told" a_first_time_is_go
check "a landing, its report and its bundle say that it was go" a_landing_names_it
check "a sensor with a date, or calibrated anew, takes the word away" a_dated_sensor_is_calibrated
check "the second time compares image, configuration and shunts with the landing's" the_second_time_compares
check "a certificate that is overdue is no-go, one that holds is go" an_overdue_certificate_is_no_go
check "lines fit a terminal of 100 columns" lines_fit
check "--si: millimetres and newtons" in_si_units
check "as JSON, without CAN" json_says_the_same
check "no-go: a transducer's lead is off" only_no_go 'at 0.01 transducer 3 open' 'transducer 3 +signal lead open, ([0-9]+) of \1 readings not valid'
check "no-go: a gage's gain has drifted" only_no_go 'at 0.01 gage 5 drift 1.03 0' 'shunt calibration +gage 5 wrong \(41\.'
check "no-go: the black box is dead" no_go 'at 0 nor dead' 'black box +no memory answers'
check "no-go: the warning lamp is broken" only_no_go 'at 0 lamp broken' 'warning lamp +does not light'
check "no-go: another configuration" only_no_go '' 'configuration .*CRC 12345678, as given' --expect-config 12345678
check "no-go: another image than the last landing's" another_image
check "no-go: CAN is unplugged" no_go 'at 0.3 bus unplug' 'CAN +no acknowledgement'
check "no-go: no thermometer answers" no_go 'at 0.01 thermometer dead' 'thermometer +no'
check "no-go: both bands are slack" pretension
check "no-go: a switch was left open, by name" a_latch_left_open
check "no-go: another program holds the database" somebody_writes
check "after a landing: what it left behind" after_a_landing
check "walk: all answer" all_answer
check "walk: switches 7 and 8 are swapped" swapped_switches
check "walk: no landing, nothing recorded" a_walk_is_no_landing
check "walk: switch 12 is dead, transducers 2 and 3 are swapped" dead_and_swapped
check "no board" fails_with 3 'the board closed the link: file:/dev/null' build/matrig --quiet ready "$tmp/none.db" --serial file:/dev/null
check "no link" fails_with 2 'no link: matrig ready needs --serial LINK' build/matrig ready "$tmp/x.db"
check "the walk compares nothing" fails_with 2 '--walk excludes --image' build/matrig ready "$tmp/x.db" --serial unix:x --walk --image $elf
check "not a database" fails_with 4 'not a campaign' build/matrig ready README.md --serial unix:x
finish
