#!/usr/bin/env bash
# matrig certificate: entered, listed, corrected, taken back. What matrig ready says of them: ready.sh.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
export USER=tester
begun_landing "$tmp/c.db"
paper=(--number 2026-4711 --laboratory 'Metrology Lab' --calibrated 2026-03-02 --due 2027-03-01 --uncertainty 0.05mm --coverage 2 --sensor ET-17)
of() { $matrig --json certificate "$tmp/c.db" "${@:2}" | python3 -c 'import json, sys; rows = json.load(sys.stdin)["certificates"]; print('"$1"')'; }

nothing_yet() { fails_with 0 'no certificate yet' $matrig certificate "$tmp/c.db"; }
is_kept() { # 0.05 mm are 0.0019685 in
    $matrig certificate "$tmp/c.db" d3 "${paper[@]}" --by 'A. Smith' --model 'Fredericks 0703' >"$tmp/out" || return 1
    cat "$tmp/out"
    grep -q 'd3 *2026-4711 *Metrology Lab *ET-17 *Fredericks 0703 *2026-03-02 *A. Smith *0.0020 in$' "$tmp/out" &&
        [ "$(of '["%s %.7f %s %s %s %s" % (r["due"], r["expanded_in"], r["coverage_factor"], r["model"], r["who"], r["holds"]) for r in rows]')" = \
            "['2027-03-01 0.0019685 2.0 Fredericks 0703 tester True']" ]
}
other_units() { # 4.448 N are a pound; 95 % of a normal distribution lie within 1.95996
    $matrig certificate "$tmp/c.db" t2 --number N-1 --calibrated 2026-01-31 --due never --uncertainty '4.4482216 N' --coverage '95 %' &&
        $matrig certificate "$tmp/c.db" t3 --number N-2 --calibrated 2026-01-31 --due 2026-02-28 --uncertainty 0.4% --coverage k=2 &&
        [ "$(of '["%s %s" % (round(r["expanded_lb"], 4) if r["expanded_lb"] else r["expanded_rel"], round(r["coverage_factor"], 4)) for r in rows if r["channel"] > "t"]')" = "['1.0 1.96', '0.004 2.0']" ] &&
        [ "$(of '[r["state"] for r in rows if r["channel"] > "t"]')" = "['valid, no due date', 'overdue since 2026-03-01']" ]
}
corrected() { # the earlier row stays, and is told with --all
    $matrig certificate "$tmp/c.db" d3 "${paper[@]/0.05mm/0.06mm}" >/dev/null && [ "$(of '[round(r["expanded_in"] * 25.4, 4) for r in rows if r["channel"] == "d3"]')" = '[0.06]' ] &&
        [ "$(of '[round(r["expanded_in"] * 25.4, 4) for r in rows if r["channel"] == "d3"]' --all)" = '[0.05, 0.06]' ]
}
taken_back() {
    local id
    id=$(of '[r["id"] for r in rows if r["channel"] == "d3"][0]')
    $matrig certificate "$tmp/c.db" --withdraw "$id" --reason 'typed wrongly' >/dev/null && [ "$(of '[round(r["expanded_in"] * 25.4, 4) for r in rows if r["channel"] == "d3"]')" = '[0.05]' ] &&
        [ "$(of '[(r["withdraws"], r["note"]) for r in rows if r["withdraws"]]' --all)" = "[($id, 'typed wrongly')]" ] &&
        fails_with 2 "no certificate $id to withdraw" $matrig certificate "$tmp/c.db" --withdraw "$id" --reason again
}
required() {
    $matrig certificate "$tmp/c.db" --required yes | grep -q 'requires a certificate of each channel' && $matrig --json certificate "$tmp/c.db" | grep -q '"required":true' &&
        $matrig certificate "$tmp/c.db" --required no >/dev/null && $matrig --json certificate "$tmp/c.db" | grep -q '"required":false'
}
bundle_has_them() {
    $matrig bundle "$tmp/c.db" 1 --without firmware,page -o "$tmp/one.mrb" 2>&1 && [ "$(sqlite3 "$tmp/one.mrb" 'select count(*) from certificates')" = "$(sqlite3 "$tmp/c.db" 'select count(*) from certificates')" ]
}
refused() { # PATTERN REPLACED BY
    fails_with 2 "$1" $matrig certificate "$tmp/c.db" d3 "${paper[@]/$2/$3}"
}
wrong_words() {
    refused "no date: '2026-13-02' for --calibrated; write YYYY-MM-DD" 2026-03-02 2026-13-02 && refused "no date: '2027-02-29' for --due" 2027-03-01 2027-02-29 &&
        refused 'due before it was calibrated' 2027-03-01 2026-03-01 && refused 'calibrated on a day to come' 2026-03-02 2226-03-02 &&
        refused "a force instead of a length: '5 lb' for --uncertainty; " 0.05mm '5 lb' && refused "no uncertainty: '0' " 0.05mm 0 && refused "'0.4%%' for --uncertainty" 0.05mm '0.4%%' && refused "'0.4mm%' for --uncertainty" 0.05mm '0.4mm%' &&
        fails_with 2 "no coverage: 'two'" $matrig certificate "$tmp/c.db" d3 --number 1 --calibrated 2026-03-02 --due never --uncertainty 0.1 --coverage two &&
        fails_with 2 "not a channel: 'd9'" $matrig certificate "$tmp/c.db" d9 "${paper[@]}" && fails_with 2 'all of them' $matrig certificate "$tmp/c.db" d3 --number 1 &&
        fails_with 2 'all of them' $matrig certificate "$tmp/c.db" d3 && fails_with 2 'why\?' $matrig certificate "$tmp/c.db" --withdraw 1 && fails_with 2 'without a channel' $matrig certificate "$tmp/c.db" d3 --required yes &&
        fails_with 4 'too long: --sensor' $matrig certificate "$tmp/c.db" d3 "${paper[@]/ET-17/1234567890123}"
}

check "none: said, and no failure" nothing_yet
check "a certificate is kept whole" is_kept
check "newtons, percent of the reading, a probability in the factor's place" other_units
check "a row with the same number stands in the earlier one's place, which stays" corrected
check "one that is taken back gives the place back" taken_back
check "a campaign may require them" required
check "a bundle of a landing has those of its board" bundle_has_them
check "wrong words" wrong_words
finish
