#!/usr/bin/env bash
# What people say of a landing: notes, corrections, voiding, waves and breaks; its history; series; what the report makes of it.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/campaign.db
export USER=tester
begun_landing "$db"
landing() { $matrig --quiet landing "$db" "$@"; }
zero_s() { $matrig export "$db" 1 --format csv | sed -n 's/.*board time of t_s = 0: \([0-9.]*\) s.*/\1/p'; }

notes() {
    landing 1 --note "brakes pulled left" --who kl && landing 1 --note "second note" >"$tmp/notes" || return 1
    cat "$tmp/notes"
    grep -q ' kl  *note  *brakes pulled left$' "$tmp/notes" && grep -q ' tester  *note  *second note$' "$tmp/notes"
}
# The gear goes 35.5 ft/s there: a touchdown 1 ft further on is 28.2 ms later.
corrected_touchdown_is_used() {
    local before after station
    before=$(zero_s)
    station=$(sqlite3 "$db" "select printf('%g', touchdown_ft) from landings")
    landing 1 --correct "touchdown_ft=$(awk "BEGIN {print $station + 1}")" --reason "tape read again" >"$tmp/out" || return 1
    after=$(zero_s)
    echo "touchdown at $before s, corrected $after s"
    awk "BEGIN {d = $after - $before; exit !(d > 0.0278 && d < 0.0286)}" || return 1
    grep -q "touchdown_ft  *$station  *[0-9.]*  *tape read again$" "$tmp/out" && [ "$(sqlite3 "$db" "select printf('%g', touchdown_ft) from landings")" = "$station" ] || return 1
    landing 1 --correct "touchdown_ft=$station" --reason "no, the first was right" >/dev/null && [ "$(zero_s)" = "$before" ]
}
corrections_keep_their_history() {
    landing 1 --correct weight_lb=2050 --reason "weighed" >/dev/null && landing 1 --correct weight_lb=2075 --reason "with fuel" >/dev/null &&
        landing 1 --correct pattern=diagonal --reason "typed wrong" >/dev/null || return 1
    $matrig --json landing "$db" 1 >"$tmp/landing.json" && python3 - "$tmp/landing.json" <<'EOF'
import json, sys
l = json.load(open(sys.argv[1]))["landings"][0]
weights = [c for c in l["changes"] if c["field"] == "weight_lb"]
assert [(c["was"], c["value"], c["reason"]) for c in weights] == [(None, "2050", "weighed"), ("2050", "2075", "with fuel")], weights
assert l["pattern"] == "diagonal" and l["void"] is False and weights[0]["who"] == "tester"
EOF
    [ $? = 0 ] && $matrig --si landing "$db" 1 >"$tmp/si" && grep 'weight_N  *9118\.85  *9230\.06  *with fuel$' "$tmp/si" # of 4.44822 N a pound
}
history_cannot_be_changed() {
    sqlite3 "$db" "update landing_changes set value='1'" 2>&1 | grep -q 'history stays' || return 1
    sqlite3 "$db" "delete from landing_changes" 2>&1 | grep -q 'history stays' || return 1
    sqlite3 "$db" "delete from observations" 2>&1
    [ "$(sqlite3 "$db" 'select count(*) from landing_changes')" = 7 ]
}
nothing_yet_is_said() { # of a campaign without any landing, survey or series
    begun_landing "$tmp/none.db" && sqlite3 "$tmp/none.db" "delete from landings" 2>/dev/null
    $matrig landing "$tmp/none.db" 2>"$tmp/err" && grep 'no landing yet: .*; record landings with matrig log --db ' "$tmp/err"
}
observations() {
    landing 1 --observe wave --station 88 --panels 2 --height 0.6 --side left --form two-panel --at 1.5 --note 'grew <i>slowly' >/dev/null &&
        landing 1 --observe break --station 85 --side centre --form "end connector" >/dev/null &&
        $matrig --si --quiet landing "$db" 1 --observe wave --station 27.737 --height 12.7 >/dev/null && landing 1 >"$tmp/seen" || return 1
    grep '^    [wb]' "$tmp/seen"
    grep -q '^    wave  *1  *88\.0  *2  *0\.60  *left  *two-panel  *1\.50  *tester' "$tmp/seen" && grep -q '^    wave   *grew <i>slowly$' "$tmp/seen" &&
        grep -q '^    wave  *3  *91\.0  *-  *0\.50 ' "$tmp/seen" || return 1
    fails_with 4 'the reason is too long' $matrig landing "$db" 1 --withdraw 3 --reason "$(printf '%400s' x)" || return 1
    landing 1 --withdraw 3 --reason "a shadow" | grep -q '^    wave  *3  *yes ' || return 1
    fails_with 2 'no observation 3 to withdraw' $matrig landing "$db" 1 --withdraw 3 --reason again &&
        sqlite3 "$db" "delete from observations" 2>&1 | grep -q 'history stays'
}
void_is_left_out_and_said() {
    $matrig --json report "$db" -o "$tmp/with.html" | grep -q '"landings":1[,}]' || return 1
    landing 1 --void --reason "a dog <b>ran" | grep -q 'RUN 1: .*, VOID' || return 1
    $matrig --json report "$db" -o "$tmp/without.html" | grep -q '"landings":0[,}]' && grep -q 'void: a dog &lt;b&gt;ran' "$tmp/without.html" &&
        ! grep -q 'id="run1"' "$tmp/without.html" || return 1
    fails_with 2 'RUN 1 is void \(a dog <b>ran\)' $matrig compare "$db" 1 || return 1
    $matrig --json report "$db" --void -o "$tmp/with.html" | grep -q '"landings":1[,}]' || return 1
    fails_with 2 'is already void' $matrig landing "$db" 1 --void --reason twice && landing 1 --unvoid --reason "it was a cat" >/dev/null &&
        $matrig --json report "$db" -o "$tmp/with.html" | grep -q '"landings":1[,}]'
}
report_shows_them() {
    grep -q '<section id="journal">' "$tmp/with.html" && grep -q 'grew &lt;i&gt;slowly' "$tmp/with.html" && ! grep -q 'grew <i>' "$tmp/with.html" &&
        grep -q 'end connector' "$tmp/with.html" && ! grep -q '91.0' <(sed -n '/Waves and breaks/,/<\/table>/p' "$tmp/with.html")
}
# The recorded landing was armed before any series; it is put in one by correction. A series takes in what is armed after it.
series() {
    $matrig landing "$db" --series standard-1 --pattern standard --runway "first laying" --note "bands off" >/dev/null || return 1
    $matrig --json landing "$db" | grep -q '"name":"standard-1".*"landings":0' || return 1
    landing 1 --correct series=standard-1 --reason "belongs there" | grep -q 'series standard-1, runway first laying, pattern diagonal' || return 1
    $matrig --json landing "$db" | grep -q '"landings":1' || return 1
    sqlite3 "$db" "insert into landings(session, boot, board_landing, armed_us, state) values(1, 0, 9, (select made_us + 1 from series), 1)"
    $matrig landing "$db" --series second >/dev/null
    landing 2 | grep -q 'RUN 2: landing 9, .* series standard-1,' && fails_with 2 "series 'second' exists already" $matrig landing "$db" --series second &&
        fails_with 2 "no series 'third'" $matrig landing "$db" 1 --correct series=third --reason x
}
a_series_begun_by_mistake() { # is withdrawn and stays: the landings belong to the one before it, and a bundle has that one
    sqlite3 "$db" ".backup $tmp/frist.db"
    local before
    before=$($matrig landing "$tmp/frist.db" 2 | head -n 1)
    sqlite3 "$tmp/frist.db" "insert into series(made_us, name) select armed_us, 'frist' from landings where id = 2" && $matrig landing "$tmp/frist.db" 2 | grep 'series frist,' || return 1
    fails_with 2 'no reason' $matrig landing "$tmp/frist.db" --withdraw-series frist && fails_with 2 "no series 'x'" $matrig landing "$tmp/frist.db" --withdraw-series x --reason y &&
        $matrig landing "$tmp/frist.db" --withdraw-series frist --reason 'first, mistyped' | grep 'series  *frist .* tester  *first, mistyped$' && [ "$($matrig landing "$tmp/frist.db" 2 | head -n 1)" = "$before" ] &&
        fails_with 2 "no series 'frist'" $matrig landing "$tmp/frist.db" --withdraw-series frist --reason again && $matrig landing "$tmp/frist.db" --series frist >/dev/null &&
        [ "$(sqlite3 "$tmp/frist.db" "select count(*) from series where name = 'frist'")" = 2 ] && sqlite3 "$tmp/frist.db" 'delete from withdrawals' 2>&1 | grep 'history stays'
}
slips_are_out_of_range() {
    fails_with 2 'out of range: 29 for weight_lb' $matrig landing "$db" 1 --correct weight_lb=29 --reason x && fails_with 2 'out of range: .*300.* for --at' $matrig landing "$db" 1 --observe wave --station 8 --at 300 &&
        fails_with 2 'out of range' $matrig landing "$db" 1 --observe wave --station 8 --height 16
}
a_new_campaign_is_asked_for() { # of a person at a terminal; another one is told
    $matrig landing "$tmp/told.db" --series x 2>&1 >/dev/null | grep "a new campaign: $tmp/told.db" && python3 - "$matrig" "$tmp/frisst.db" <<'EOF'
import os, pty, subprocess, sys
matrig, db = sys.argv[1:]
for reply, code in ((b"y\n", 2), (b"yes\n", 0)):
    ours, theirs = pty.openpty()
    p = subprocess.Popen([matrig, "landing", db, "--series", "x"], stdin=theirs, stderr=theirs, stdout=subprocess.DEVNULL)
    said = b""
    while not said.endswith(b"yes: "):
        said += os.read(ours, 100)
    os.write(ours, reply)
    assert p.wait(60) == code and os.path.exists(db) == (code == 0), (reply, p.returncode)
EOF
}
passed_on_with_a_bundle() {
    $matrig --quiet bundle "$db" 1 -o "$tmp/one.db" && $matrig landing "$tmp/one.db" 1 >"$tmp/one.txt" && grep -q 'brakes pulled left' "$tmp/one.txt" &&
        grep -q 'wave  *1  .*88\.0' "$tmp/one.txt"
}
silly() {
    fails_with 2 'no landing: give' $matrig landing "$db" --note x && fails_with 2 'more than one action' $matrig landing "$db" 1 --note x --void &&
        fails_with 2 'no reason' $matrig landing "$db" 1 --void && fails_with 2 'cannot correct' $matrig landing "$db" 1 --correct speed=3 --reason x &&
        fails_with 2 'out of range' $matrig landing "$db" 1 --correct touchdown_ft=500 --reason x &&
        fails_with 2 'unknown side' $matrig landing "$db" 1 --observe wave --station 3 --side up &&
        fails_with 2 'no position' $matrig landing "$db" 1 --observe wave && fails_with 2 'RUN 7' $matrig landing "$db" 7 --note x &&
        fails_with 2 'need --observe' $matrig landing "$db" 1 --station 3
}

check "notes" notes
check "a corrected touchdown is used, and what the board said stays" corrected_touchdown_is_used
check "corrections keep their history" corrections_keep_their_history
check "history cannot be changed" history_cannot_be_changed
check "waves and breaks" observations
check "a voided landing is left out, and said" void_is_left_out_and_said
check "the report shows them, escaped" report_shows_them
check "series" series
check "a series begun by mistake is withdrawn, and stays" a_series_begun_by_mistake
check "weights, times and heights that no landing has are refused" slips_are_out_of_range
check "before a campaign is made a person is asked" a_new_campaign_is_asked_for
check "passed on with a bundle" passed_on_with_a_bundle
check "silly words" silly
check "nothing yet is said, with what to do" nothing_yet_is_said
finish
