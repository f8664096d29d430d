#!/usr/bin/env bash
# matrig uncertainty: the budget of each channel adds up to the stated error of the summary; certificates.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
begun_landing "$tmp/c.db"

# The stated error of a peak as `show` has it, and the sums made here once more, of every channel.
adds_up() {
    $matrig --json uncertainty "$tmp/c.db" >"$tmp/u.json" && $matrig --json show "$tmp/c.db" 1 >"$tmp/show.json" && python3 - "$tmp" <<'P'
import json, math, sys
budgets = json.load(open(sys.argv[1] + "/u.json"))
budgets = budgets["displacements"] + budgets["tensions"]
shown = json.load(open(sys.argv[1] + "/show.json"))
stated = {"d%d" % d["number"]: d["error_in"] for d in shown["displacements"]}
for t in shown["tensions"]:
    most = abs(t["most_lb"]) >= abs(t["least_lb"])
    stated["t%d" % t["number"]] = t["most_error_lb" if most else "least_error_lb"]
assert len(budgets) == len(stated) == 22
for b in budgets:
    unit = "in" if b["channel"][0] == "d" else "lb"
    part = lambda s: math.sqrt(sum(r["contribution_" + unit] ** 2 for r in b["budget"] if r["stated"] or not s))
    near = lambda x, y: abs(x - y) < 2e-5 * abs(y)
    assert near(b["stated_" + unit], stated[b["channel"]]) and near(part(True), b["stated_" + unit]) and near(part(False), b["combined_" + unit]), b
    assert near(b["combined_" + unit] * b["coverage_factor"], b["expanded_" + unit])
    assert not b["certificate_number"]
P
}
a_certificate_joins() { # 2 % of 10 mm with k = 2: a tenth of a millimetre, 0.003937 in
    $matrig --quiet calibrate d3 --db "$tmp/c.db" --certificate 'number=C-7, calibrated=2021-03-02, due=2022-03-01, uncertainty=2%, coverage=2' && $matrig --json uncertainty "$tmp/c.db" d3 --at 10mm >"$tmp/u.json" && python3 - "$tmp/u.json" <<'P'
import json, sys
b = json.load(open(sys.argv[1]))
row = {r["source"]: r for r in b["budget"]}["certificate"]
assert abs(row["contribution_in"] - 0.1 / 25.4) < 1e-8 and row["divisor"] == 2, row
baseline = {r["source"]: r for r in b["budget"]}["baseline"] # of a straight line; nobody calibrated it, so the temperature is in its stated gain
assert abs(b["combined_in"] ** 2 - b["stated_in"] ** 2 - row["contribution_in"] ** 2 - baseline["contribution_in"] ** 2) < 1e-9, b
assert b["certificate_number"] == "C-7" and b["certificate"] == "overdue since 2022-03-02", b
P
}
units_stand_over_their_columns() { # inches over transducers, pounds over gages
    $matrig uncertainty "$tmp/c.db" >"$tmp/out" && cat "$tmp/out" && awk '/^  channel +sensor/ {unit = $3} /^  d[1-8] +- / {d += unit == "in"} /^  t[0-9]+ +- / {t += unit == "lb"}
        END {exit !(d == 8 && t == 14)}' "$tmp/out"
}
without_a_landing() { # of a configuration
    build/matrig-board --elf build/firmware/matrig.elf --serial "unix:$sockets/serial" --speed max --for 200 >/dev/null 2>&1 &
    $matrig board --serial "unix:$sockets/serial" config get -o "$tmp/rig.cfg"
    kill $!
    wait $!
    $matrig uncertainty "$tmp/c.db" t2 --config "$tmp/rig.cfg" --hours 2 --at 444.82N --kelvin 0 >"$tmp/out" && cat "$tmp/out" && grep -Eq '^reading +100\.00 lb$' "$tmp/out" && grep -Eq "^ +zero drift.* 0.5 +2 +1 " "$tmp/out"
}
does_not_hold() { build/tests/uncertainty/study 200 --without "$1"; [ $? = 1 ]; }
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

check "each budget adds up to the stated error, and to the combined one" adds_up
check "a certificate joins the sum, overdue or not, and it is said" a_certificate_joins
check "inches over transducers, pounds over gages" units_stand_over_their_columns
check "a configuration in a landing's place" without_a_landing
check "of 500 drawn calibrations and landings the interval holds 93.5 to 97 %" build/tests/uncertainty/study 500
check "without the certificate it does not" does_not_hold certificate
check "nor without the temperature" does_not_hold temperature
check "no channel" fails_with 2 "not a channel: 'd0'" $matrig uncertainty "$tmp/c.db" d0
check "a reading in another unit" fails_with 2 "not a reading: '3lb' for --at" $matrig uncertainty "$tmp/c.db" d3 --at 3lb
check "--at of all" fails_with 2 'needs a CHANNEL' $matrig uncertainty "$tmp/c.db" --at 1
check "two places" fails_with 2 'give only one' $matrig uncertainty "$tmp/c.db" --run 1 --config x
finish
