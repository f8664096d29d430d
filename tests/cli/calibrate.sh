#!/usr/bin/env bash
# matrig calibrate: from a file of points, guided on the emulated board, and for recorded landings.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT
export USER=tester
board() { # BOARD-OPTION...
    timeout 600 build/matrig-board --elf build/firmware/matrig.elf --serial "unix:$sockets/serial" --speed max --for 2000 "$@" >/dev/null 2>&1 &
    board=$!
}
value() { awk -v name="$2 = " 'index($0, name) == 1 {sub(/^[^=]*= /, ""); sub(/  # .*/, ""); print}' "$1"; }

gets_a_configuration() {
    board
    $matrig board --serial "unix:$sockets/serial" config get -o "$tmp/rig.cfg"
    local status=$?
    kill $board
    wait $board
    return $status
}
from_points() {
    printf 'lb,codes\n0,100\n50,1350.5\n100,2600\n100,2600.5\n0,100.5\n' >"$tmp/points.csv"
    $matrig calibrate t2 --points "$tmp/points.csv" --config "$tmp/rig.cfg" -o "$tmp/new.cfg" --sensor SG-0042 --days 30 --known 0.05 >"$tmp/out" || return 1
    cat "$tmp/out"
    # 100 lb over 2500 codes, zero at 100.25 or so
    value "$tmp/new.cfg" 'channel[10].unit_per_code' | awk '{exit !($1 > 0.03999 && $1 < 0.04001)}' || return 1
    [ "$(value "$tmp/new.cfg" 'channel[10].serial')" = '"SG-0042"' ] && [ "$(value "$tmp/new.cfg" 'channel[10].calibrated_day')" = "$(date -u +%F)" ] &&
        [ "$(value "$tmp/new.cfg" 'channel[10].expires_day')" = "$(date -u -d '+30 days' +%F)" ] || return 1
    diff "$tmp/rig.cfg" "$tmp/new.cfg" | grep '^>' | grep -v '^> channel\[10\]' && return 1
    $matrig board config check "$tmp/new.cfg" && grep -q '  worst$' "$tmp/out"
}
# The mat beside transducer 3 stands at 0, 0.5 and 1 in, 20 s each, over and over. Somebody types what it is; when the reading says that
# it was another one meanwhile, takes it back. What a transducer is worth comes from its excitation and amplifier: 0.5 V/in, 3.3 V of 4096 codes.
guided() {
    python3 - "$tmp/steps.run" <<'EOF'
import sys, zlib
lines = []
for line in open("tests/runs/landing5.run"):
    if line.startswith("samples"):
        break
    if not line.startswith(("command", "switch", "duration")):
        lines.append(line.rstrip("\n"))
lines.append("duration_s 2000")
lines += ["switch %d %g %g -" % (p, -2.5 + 5 * (p - 1), -2.5 + 5 * (p - 1)) for p in range(1, 25)]
rows = []
for i in range(2000):
    row = [0] * 8 + [10000] * 14
    row[2] = 50000 * (i // 20 % 3)
    rows.append(" ".join(map(str, row)))
lines.append("samples 2000 1")
lines += rows
text = "\n".join(lines) + "\n"
open(sys.argv[1], "w").write(text + "end %08x\n" % zlib.crc32(text.encode()))
EOF
    board --rig "$tmp/steps.run"
    python3 - "$matrig" "$sockets/serial" "$tmp" <<'EOF'
import os, re, subprocess, sys, time
matrig, path, tmp = sys.argv[1:]
p = subprocess.Popen([matrig, "calibrate", "d3", "--serial", "unix:" + path, "-o", tmp + "/guided.cfg", "--sensor", "ET-17"],
                     stdin=subprocess.PIPE, stdout=open(tmp + "/guided.txt", "w"), stderr=subprocess.PIPE, bufsize=0)
os.set_blocking(p.stderr.fileno(), False)
seen = ""
def answer(pattern):
    global seen
    end = time.time() + 30
    while time.time() < end:
        seen += (p.stderr.read() or b"").decode()
        m = re.search(pattern, seen)
        if m:
            seen = seen[m.end():]
            return m
        time.sleep(0.01)
    sys.exit("waited for %r, saw %r" % (pattern, seen))
answer(r"point 1, in: ")
per_in = 0.5 * 4096 / 3.3
kept = {0.0: 0, 0.5: 0, 1.0: 0}
def type_in(value):
    p.stdin.write(b"%g\n" % value)
    m = answer(r"([-0-9.]+) codes, noise ([0-9.]+)(: point refused[^\n]*)?\n")
    answer(r"point \d+, in: ")
    return float(m.group(1)), bool(m.group(3))
zero = 0.05 / 0.5 * per_in  # the bridge's offset of 50 mV
guess = 0.0
for _ in range(200):
    code, moved = type_in(guess)
    if moved:
        continue
    level = min(kept, key=lambda v: abs(code - zero - v * per_in))
    if level != guess or kept[level] == 2:
        p.stdin.write(b"u\n")
        answer(r"point \d+, in: ")
        guess = level
        continue
    kept[level] += 1
    if min(kept.values()) == 2:
        break
else:
    sys.exit("never all three: %r" % kept)
p.stdin.write(b"\n")
sys.exit(p.wait(20))
EOF
    local status=$?
    kill $board
    wait $board
    cat "$tmp/guided.txt"
    [ $status = 0 ] && value "$tmp/guided.cfg" 'channel[3].unit_per_code' | awk '{r = $1 / (3.3 / 4096 / 0.5); print "unit per code, of what it should be:", r; exit !(r > 0.999 && r < 1.001)}' &&
        [ "$(value "$tmp/guided.cfg" 'channel[3].serial')" = '"ET-17"' ] && grep -q '^from  *6 points between 0 and 1 in' "$tmp/guided.txt"
}

# Gage 1 is worth 2 % more and transducer 1 3 % more; everything else stays.
recomputes() {
    begun_landing "$tmp/c.db" && $matrig export "$tmp/c.db" 1 --format csv >"$tmp/before.csv" || return 1
    awk '/^channel\[9\].unit_per_code = / {$3 *= 1.02} /^channel\[1\].unit_per_code = / {$3 *= 1.03} {print}' "$tmp/rig.cfg" >"$tmp/corrected.cfg"
    $matrig --json calibrate "$tmp/c.db" --recompute "$tmp/corrected.cfg" --reason "gage block was wrong" >"$tmp/out" || return 1
    cat "$tmp/out"
    grep -q '"run":1,"values":2' "$tmp/out" && $matrig export "$tmp/c.db" 1 --format csv >"$tmp/after.csv" || return 1
    paste -d, <(grep '^[-0-9]' "$tmp/before.csv") <(grep '^[-0-9]' "$tmp/after.csv") | awk -F, '{
        n = NF / 2; d = $(n + 13) - 1.02 * $13; e = $(n + 5) - 1.03 * $5; f = $(n + 14) - $14; g = $(n + 6) - $6
        if (d > 0.0021 || d < -0.0021 || e > 2.1e-5 || e < -2.1e-5 || f || g) bad++ } END {print NR " rows, " bad + 0 " wrong"; exit bad || NR < 1400}' || return 1
    [ "$(sqlite3 "$tmp/c.db" "select group_concat(idx||'/'||item||'/'||printf('%.3f', value/was)||'/'||who||'/'||reason, ' ') from (select * from recalibrations order by idx)")" = \
        "0/-1/1.030/tester/gage block was wrong 8/-1/1.020/tester/gage block was wrong" ] || return 1
    $matrig report "$tmp/c.db" -o "$tmp/c.html" && grep -q 'uses a corrected calibration' "$tmp/c.html" || return 1
    # and back: the readings are what they were
    $matrig calibrate "$tmp/c.db" --recompute "$tmp/rig.cfg" --run 1 --reason "no, it was right" >/dev/null && $matrig export "$tmp/c.db" 1 --format csv | cmp - "$tmp/before.csv" &&
        [ "$(sqlite3 "$tmp/c.db" 'select count(*) from recalibrations')" = 4 ] && sqlite3 "$tmp/c.db" 'delete from recalibrations' 2>&1 | grep -q 'history stays'
}
a_series_only() {
    fails_with 2 'no such landings' $matrig calibrate "$tmp/c.db" --recompute "$tmp/corrected.cfg" --series second --reason x || return 1
    sed 's/^channel\[1\].number = 1/channel[1].number = 2/; s/^channel\[2\].number = 2/channel[2].number = 1/' "$tmp/corrected.cfg" >"$tmp/swapped.cfg"
    fails_with 1 'has a different channel in' $matrig calibrate "$tmp/c.db" --recompute "$tmp/swapped.cfg" --reason x &&
        [ "$(sqlite3 "$tmp/c.db" 'select count(*) from recalibrations')" = 4 ]
}
certificate_without_points() { # of the sensor that is fitted, or the one named; half a certificate is none, and changes nothing
    local whole='number=2026-4711, laboratory=Metrology Lab, calibrated=2026-03-02, due=2027-03-01, uncertainty=0.05mm, coverage=2'
    $matrig calibrate d3 --db "$tmp/c.db" --sensor ET-17 --certificate "$whole" && fails_with 2 'incomplete' $matrig calibrate d3 --db "$tmp/c.db" --certificate "${whole#*, }" &&
        fails_with 2 "cannot have the value 'due=2026-01-01'" $matrig calibrate d3 --db "$tmp/c.db" --certificate "${whole/2027-03-01/2026-01-01}" && fails_with 2 'and --db DB only work together' $matrig calibrate d3 --certificate "$whole" &&
        fails_with 2 'cannot have the value' $matrig calibrate d1 --points "$tmp/points.csv" --config "$tmp/rig.cfg" -o "$tmp/not.cfg" --db "$tmp/c.db" --certificate "number=1, x=2" && [ ! -e "$tmp/not.cfg" ] &&
        [ "$(sqlite3 "$tmp/c.db" "select group_concat(idx||' '||number||' '||sensor||' '||round(expanded*25.4, 4)) from certificates")" = '2 2026-4711 ET-17 0.05' ]
}
silly() {
    printf 'in,codes\n3,x\n' >"$tmp/bad.csv"
    fails_with 4 'the line does not have one value and one code: .*line 2' $matrig calibrate d1 --points "$tmp/bad.csv" --config "$tmp/rig.cfg" &&
        fails_with 2 'not a channel' $matrig calibrate d9 --points "$tmp/points.csv" --config "$tmp/rig.cfg" &&
        fails_with 2 'needs either --serial' $matrig calibrate d1 && fails_with 2 'no reason' $matrig calibrate "$tmp/c.db" --recompute "$tmp/rig.cfg" &&
        fails_with 2 'too long' $matrig calibrate d1 --points "$tmp/points.csv" --config "$tmp/rig.cfg" --sensor 0123456789abc
}
one_error_when_nothing_can_be_shown() {
    local output=/dev/full words
    printf 'lb,codes\n0,100\n50,1400\n100,2600\n' >"$tmp/off.csv"
    for words in "t2 --points $tmp/points.csv" "t2 --points $tmp/off.csv" "t2 --points $tmp/points.csv --table"; do
        $matrig calibrate $words --config "$tmp/rig.cfg" >$output 2>"$tmp/err"
        [ $? = 3 ] && [ "$(wc -l <"$tmp/err")" = 1 ] && grep -q 'cannot write the result' "$tmp/err" || { cat "$tmp/err"; return 1; }
    done
    $matrig --json calibrate "$tmp/c.db" --recompute "$tmp/rig.cfg" --reason x >$output 2>"$tmp/err"
    [ $? = 3 ] && [ "$(wc -l <"$tmp/err")" = 1 ]
}
# As spreadsheets save a file as "CSV UTF-8", and others as "Unicode text".
begins_with_a_mark() {
    local file
    for file in points.csv rig.cfg; do printf '\357\273\277' | cat - "$tmp/$file" >"$tmp/marked-$file"; done
    $matrig calibrate t2 --points "$tmp/marked-points.csv" --config "$tmp/marked-rig.cfg" -o "$tmp/marked.cfg" --sensor SG-0042 --days 30 --known 0.05 >/dev/null && cmp "$tmp/marked.cfg" "$tmp/new.cfg" || return 1
    printf 'mm,codes\r\n0,-2000\r\n5,-1000\r10,0\r\n20,2000\r\n' >"$tmp/lone.csv" # a carriage return alone hides no point
    fails_with 4 'more than two columns: .*lone.csv, line 3' $matrig calibrate d1 --points "$tmp/lone.csv" --config "$tmp/rig.cfg" -o "$tmp/lone.cfg" || return 1
    iconv -t UTF-16 "$tmp/points.csv" >"$tmp/wide.csv"
    fails_with 4 'a text in UTF-16, not a file of points: .*wide.csv; save the text as' $matrig calibrate t2 --points "$tmp/wide.csv" --config "$tmp/rig.cfg"
}
check "a configuration to begin with" gets_a_configuration
check "from a file of points" from_points
check "guided, on the emulated board" guided
check "recorded landings get a corrected calibration; the old one is kept" recomputes
check "a series that is not there, a channel that is another" a_series_only
check "a certificate is entered without points; half of one is refused" certificate_without_points
check "an output that takes nothing is one error" one_error_when_nothing_can_be_shown
check "a mark of UTF-8 is no part of a file, UTF-16 is named" begins_with_a_mark
check "silly words" silly
finish
