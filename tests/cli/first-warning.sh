#!/usr/bin/env bash
# One landing, one first warning, one clock: seconds after touchdown by the board's clock, of the block in which the board decided. Log,
# JSON, report and make series say the same; what is another moment (received here) is named as such. Touchdown
# and block are taken from the campaign's own tables and the exported zero, not from what is held against each other.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
db=$tmp/campaign.db
m() { build/matrig "$@"; }

played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run >/dev/null 2>&1
m --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >"$tmp/log.txt"
block=$(sqlite3 "$db" 'select min(block) from zones where landing = 1 and warning = 1')
zero_us=$(m export "$db" 1 --format csv | sed -n 's/.*board time of t_s = 0: \([0-9]*\)\.\([0-9]*\) s.*/\1\2/p')
want=$(awk -v b="$block" -v z="$zero_us" 'BEGIN {printf "%.3f", (1000 * b - z) / 1e6}')
json() { sqlite3 :memory: "select json_extract(cast(readfile('$1') as text), '\$.$2')"; }
same() { echo "$1; wanted $2"; [ "$1" = "$2" ]; }

it_warned() { echo "block $block, zero $zero_us us, $want s"; [ -n "$block" ] && awk -v t="$want" 'BEGIN {exit !(t > 1 && t < 4)}'; }
in_the_log() { grep "^  zone  *warned $want s after touchdown, decided in block $block$" "$tmp/log.txt"; }
short() { # the lines that matter; --all has what show has
    [ "$(wc -l <"$tmp/log.txt")" -le 13 ] && grep -E '^  outcome  *(hit|warned, but too late), lead time about [-0-9.]+ s \(75 % interval: [-0-9.]+ (to [-0-9.]+ s|s or more)\): the board warned [0-9.]+ s after touchdown; the wheel reached 50 closed mats about [0-9.]+ s after touchdown' "$tmp/log.txt" &&
        grep -x "  more  *matrig show $db 1" "$tmp/log.txt" && ! grep -q '^ *transducer' "$tmp/log.txt" &&
        m --quiet log --all --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/all.db" >"$tmp/all.txt" && m show "$tmp/all.db" 1 | diff - "$tmp/all.txt"
}
in_its_json() {
    m --json --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/json.db" >"$tmp/log.json" || return 1
    same "$(json "$tmp/log.json" 'landings[0].zone.decided_block')" "$block" && same "$(printf '%.3f' "$(json "$tmp/log.json" 'landings[0].zone.t_s')")" "$want"
}
# One outcome with one lead time and its range: in the text and the JSON of log and show, and in the report.
one_outcome() {
    m show "$db" 1 >"$tmp/show.txt" && m --json show "$db" 1 >"$tmp/show.json" && m --quiet report "$db" -o "$tmp/outcome.html" || return 1
    python3 - "$tmp" <<'P'
import html, json, re, sys
tmp = sys.argv[1]
read = lambda name: open(tmp + "/" + name, encoding="utf-8").read()
logged, shown = json.loads(read("log.json"))["landings"][0], json.loads(read("show.json"))
outcome, lines = shown["outcome"], [re.search("^  outcome +(.*)$", read(name), re.M).group(1) for name in ("log.txt", "show.txt")]
page = re.search('<p class="outcome"><strong>Outcome: (.*?)[.]</strong>', read("outcome.html")).group(1)
print(outcome, lines, page, sep="\n")
assert logged["outcome"] == outcome and lines[0] == lines[1] and lines[0] == html.unescape(page) + ": " + outcome["evidence"]
low, high = outcome["lead_low_s"], outcome["lead_high_s"]
words = outcome["result"] + ", lead time about %.1f s" % outcome["lead_s"]
words += " (75 %% interval: %.1f s or more)" % low if high is None else " (75 %% interval: %.1f to %.1f s)" % (low, high)
assert lines[0].startswith(words), words
assert not [key for key in shown["zone"] if "lead" in key or key == "reached"], shown["zone"]
P
}
again() { build/tests/again/again "$db" 1 >"$tmp/again.json" && same "$(json "$tmp/again.json" first_warning_block)" "$block"; }
at_the_zone() { # the error of the time is that of the zone's start, at the speed of the wheel
    grep -E '^ +predicted time to zone +none: the wheel was at the zone, reported at [0-9.]+ s; actual [0-9]\.[0-9]{2} s$' "$tmp/show.txt" &&
        python3 -c 'import json, sys; z = json.load(open(sys.argv[1]))["zone"]; print(z); assert z["time_to_zone_s"] <= z["time_to_zone_error_s"] < 0.1' "$tmp/show.json"
}
in_the_report() {
    m --quiet report "$db" -o "$tmp/report.html" && grep -o "<dt>zone</dt><dd class=\"warn\">warned $want s after touchdown, decided in block $block</dd>" "$tmp/report.html" &&
        grep -q "<td[^>]*>$want</td>" "$tmp/report.html"
}
in_the_series() { # this landing alone, its own record
    local from_s
    tests/series.sh "$tmp/series" tests/runs 5 >"$tmp/series.txt" 2>&1 || { cat "$tmp/series.txt"; return 1; }
    from_s=$(sed -n 's/^    zone .* warning from \([0-9.]*\) s$/\1/p' "$tmp/series.txt" | head -n 1)
    cat "$tmp/series.txt"
    grep -q "^    zone  *warned $from_s s after touchdown, decided in block $(sqlite3 "$tmp/series/campaign.db" 'select min(block) from zones where warning = 1')$" "$tmp/series.txt" &&
        grep -q 'seconds after touchdown, by the board' "$tmp/series.txt" && same "$from_s" "$want"
}
check "landing 5 is warned of" it_warned
check "the summary says when, and in which block" in_the_log
check "so does its JSON" in_its_json
check "one outcome and lead time: log, show, their JSON, the report" one_outcome
check "computed again from the record it is the same" again
check "so has the report" in_the_report
check "the log is short, and whole with --all" short
check "make series has the same moment" in_the_series
finish
