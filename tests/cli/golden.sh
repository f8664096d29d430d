#!/usr/bin/env bash
# Golden landings (tests/golden): today's image, given what the board was given, says what it said, in every field. A new version says why.
. "$(dirname "$0")/tap.sh"
scratch=$tmp
. tests/golden/landing.sh

says_the_same() { # LANDING
    play "$1" build/firmware/matrig.elf "$tmp/landing$1.said.gz" &&
        $golden compare "$golden_dir/landing$1.v$(newest "$1").said.gz" "$tmp/landing$1.said.gz"
}
# An image in which the gear rests for 501 ms, not for 500: the landing ends a millisecond later, what the final fit finds comes later, and
# nothing is different before.
finds_one_constant() {
    play 5 build/tests/variant/rest.elf "$tmp/rest.said.gz" || return 1
    $golden compare "$tmp/landing5.said.gz" "$tmp/rest.said.gz" >"$tmp/found"
    local status=$?
    head -n 3 "$tmp/found"
    [ $status = 1 ] && head -n 1 "$tmp/found" | grep -Eq '^landing\.block on CAN, block [0-9]+ \([0-9.]+ s\): was ([0-9]+), is [0-9]+ ms' &&
        ! grep -Eq '^(motion|zone|displacement.*_in)|^(touchdown|stop)\.[a-z]' "$tmp/found"
}
# rewritten AWK: landing 5's text through awk, as another golden file
rewritten() { zcat "$tmp/landing5.said.gz" | awk "$1" | gzip >"$tmp/rewritten.said.gz"; }
# Another layout: fields of a message in another order, one of them with a tenth of the resolution, messages in another order.
another_layout_is_the_same_truth() {
    zcat "$tmp/landing5.said.gz" | awk '
        /^message CAN motion / { inside = 1; message = $0; n = 0; next }
        /^(message|end)/ { if (inside) kept = message ORS fields[3] ORS fields[2] ORS fields[1]; inside = 0 }
        inside && /^field/ { fields[++n] = $0; if ($2 == "speed_ft_s") { step = $3 * 10; speed = n; fields[n] = $1 " " $2 " " step " " $4 } next }
        inside { $(speed + 1) = sprintf("%.0f", $(speed + 1) / step) * step; rows = rows ORS $1 " " $4 " " $3 " " $2; next }
        /^end/ { print kept rows }
        { print }' | gzip >"$tmp/rewritten.said.gz"
    zcat "$tmp/rewritten.said.gz" | tail -n 4
    zcat "$tmp/rewritten.said.gz" | grep -q '^field speed_ft_s 0.0*1 ft/s$' && ! zcat "$tmp/landing5.said.gz" | diff -q - <(zcat "$tmp/rewritten.said.gz") >/dev/null && $golden compare "$tmp/landing5.said.gz" "$tmp/rewritten.said.gz"
}
# found LINE: comparing the rewritten file tells this first
found() {
    $golden compare "$tmp/landing5.said.gz" "$tmp/rewritten.said.gz" >"$tmp/found"
    local status=$?
    cat "$tmp/found"
    [ $status = 1 ] && head -n 1 "$tmp/found" | grep -Eq "$1"
}
names_what_differs() {
    rewritten '/^message serial touchdown /{t = 1} t && /^[0-9]/ {$2 += 0.001; t = 0} {print}' && found '^touchdown\.speed_ft_s on serial, block [0-9]+ .*: was 35\.[0-9]+, is 35\.[0-9]+ ft/s$' &&
        rewritten '/^message/{e = $3 == "edge" && $2 == "CAN" ; seen = 0; if (e) $4--} e && /^[0-9]/ && ++seen == 19 {next} {print}' && found '^edge\.\* on CAN, block [0-9]+ .*: was told, is not$' &&
        rewritten '/^message serial stop /{t = 1} t && /^field station_ft/ {$4 = "in"; t = 0} {print}' && found '^stop\.station_ft on serial.*: has another unit$' &&
        rewritten '/^message serial verdict /{t = 1} t && /^field level/ {$2 = "grade"; t = 0} {print}' && found '^verdict\.(grade|level) on serial.*: (is told, was not|was told, is not)$'
}
refuses_the_same() { # and keeps nothing
    local golden_dir=$tmp/kept
    mkdir -p "$golden_dir" && cp tests/golden/landing5.* tests/golden/CHANGES "$golden_dir" || return 1
    local before=$(newest 5)
    new_version 5 "$tmp/landing5.said.gz" 2>"$tmp/refused"
    local status=$?
    cat "$tmp/refused"
    [ $status = 1 ] && grep -q 'nothing differs' "$tmp/refused" && [ "$(newest 5)" = "$before" ]
}
demands_reasons() { # the old file stays beside the new one, and each field that changed has its reason
    local golden_dir=$tmp/kept before
    before=$(newest 5)
    new_version 5 "$tmp/rest.said.gz" && [ "$(newest 5)" = $((before + 1)) ] && [ -f "$golden_dir/landing5.v$before.said.gz" ] || return 1
    reasons_given >"$tmp/reasons" && return 1
    cat "$tmp/reasons"
    grep -q 'changed landing.block: say why' "$tmp/reasons" || return 1
    sed -i "s/^\(landing5\.v$((before + 1)) [^:]*: \)\$/\1rest is a millisecond longer/" "$golden_dir/CHANGES"
    reasons_given || return 1
    echo "landing5.v$((before + 1)) motion.speed_ft_s: somebody says so" >>"$golden_dir/CHANGES"
    reasons_given >"$tmp/reasons" && return 1
    grep -q 'did not change motion.speed_ft_s' "$tmp/reasons"
}
refuses_what_is_torn() {
    head -c 5000 tests/golden/landing5.v1.said.gz >"$tmp/torn.gz"
    fails_with 4 'ends' $golden compare "$tmp/torn.gz" "$tmp/landing5.said.gz" &&
        fails_with 4 'not a file of what' $golden compare tests/golden/landing5.v1.given.gz "$tmp/landing5.said.gz" &&
        fails_with 3 'not a file of what' $golden compare "$tmp/none.gz" "$tmp/landing5.said.gz"
}
tells_what_is_left_out() { # each with a reason; none of what is measured
    $golden excluded >"$tmp/excluded"
    cat "$tmp/excluded"
    ! grep -Evq '^[a-z_*]+\.[a-z_*]+: .{8,}' "$tmp/excluded" && ! grep -Eq '^(displacement|tension|motion|zone|verdict|touchdown|stop|edge)' "$tmp/excluded"
}

for landing in 1 4 5; do
    check "landing $landing is said as it was" says_the_same $landing
done
check "one constant of the firmware is found out, by field and instant" finds_one_constant
check "another layout is the same truth" another_layout_is_the_same_truth
check "what differs is named: a value, a message, a unit, a field" names_what_differs
check "a new version with nothing new is refused" refuses_the_same
check "a new version needs its reasons" demands_reasons
check "each version has its reasons" reasons_given
check "a torn file is refused" refuses_what_is_torn
check "what is not compared is listed with its reason" tells_what_is_left_out
finish
