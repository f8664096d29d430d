#!/usr/bin/env bash
# The conformance images (tests/conformance) on the emulated board and on QEMU's netduinoplus2: every value must be the manual's
# where it gives one and equal on both machines, but for what tests/conformance/README.md lists, with its reason.
. "$(dirname "$0")/tap.sh"
trap 'kill $(jobs -p) 2>/dev/null' EXIT
images=$(basename -s .c -a tests/conformance/images/*.c)
list=tests/conformance/README.md

# The README's table of what differs: image, check (a pattern with *), whose ("board" or "QEMU").
sed -n 's/^| `\([a-z]*\)` | `\([^`]*\)` | \([A-Za-z]*\) |.*/\1 \2 \3/p' "$list" >"$tmp/listed"

run_on_qemu() { # IMAGE: until it has said "end"
    qemu-system-arm -M netduinoplus2 -semihosting-config enable=off -kernel "build/tests/conformance/images/$1.elf" -display none \
        -monitor none -serial "file:$tmp/$1.qemu" >/dev/null 2>&1 &
    local pid=$!
    await grep -qs '^end$' "$tmp/$1.qemu"
    kill $pid
    wait $pid 2>/dev/null
}
run_on_board() { # IMAGE: what it gives up with is kept
    timeout 600 build/matrig-board --elf "build/tests/conformance/images/$1.elf" --serial "file:$tmp/$1.board" --for 1 2>"$tmp/$1.err"
}

# A row per check: name, manual's value or -, the board's, QEMU's; "none" where the machine did not come to it.
join_up() {
    awk -v image="$1" '
        FILENAME ~ /qemu$/ && NF == 3 { manual[$1] = $3; qemu[$1] = $2; if (!($1 in at)) { at[$1] = ++n; name[n] = $1 } }
        FILENAME ~ /board$/ && NF == 3 && length($3) == length($3 ~ /^0x/ ? "0x00000000" : "-") {
            manual[$1] = $3; board[$1] = $2; if (!($1 in at)) { at[$1] = ++n; name[n] = $1 } }
        END { for (i = 1; i <= n; i++) { c = name[i]; print image, c, manual[c], c in board ? board[c] : "none", c in qemu ? qemu[c] : "none" } }' \
        "$tmp/$1.qemu" "$tmp/$1.board"
}
# ... and what it comes to: equal, QEMU (known gap), board (known deviation), both, or wrong (not listed).
judge() {
    awk '
        function listed(image, check, whose, i) {
            for (i = 1; i <= rules; i++)
                if (rule_image[i] == image && rule_whose[i] == whose && check ~ rule_check[i]) { used[i] = 1; return 1 }
            return 0
        }
        NR == FNR { rules++; rule_image[rules] = $1; rule_whose[rules] = $3; c = $2; gsub(/\*/, ".*", c); rule_check[rules] = "^" c "$"; next }
        {
            want = $3 == "-" ? "" : $3
            board_differs = want != "" ? $4 != want : 0
            qemu_differs = want != "" ? $5 != want : $5 != $4
            if (!board_differs && !qemu_differs) verdict = "equal"
            else if (board_differs && !listed($1, $2, "board")) verdict = "wrong"
            else if (qemu_differs && !listed($1, $2, "QEMU")) verdict = "wrong"
            else verdict = board_differs && qemu_differs ? "both" : board_differs ? "board" : "QEMU"
            print $0, verdict
        }
        END { for (i = 1; i <= rules; i++) if (!used[i]) print "stale", rule_image[i], rule_check[i], rule_whose[i], "-", rule_whose[i] == "board" ? "stale" : "unused" }' \
        "$tmp/listed" -
}

for image in $images; do
    run_on_qemu "$image" & # one at a time on each machine
    qemu=$!
    run_on_board "$image"
    wait $qemu
    join_up "$image"
done >"$tmp/joined"
judge <"$tmp/joined" >"$tmp/judged"

table() {
    awk '$1 == "stale" { next }
        { n[$1]++; m[$1] += $3 != "-"; v[$1, $6]++; t[$6]++; all++; manual += $3 != "-"; if (!($1 in o)) { o[$1] = ++k; name[k] = $1 } }
        END {
            printf "# %-12s %6s %12s %6s %10s %10s %5s %6s\n", "image", "checks", "manual gives", "equal", "QEMU gaps", "board off", "both", "wrong"
            for (i = 1; i <= k; i++) { c = name[i]; printf "# %-12s %6d %12d %6d %10d %10d %5d %6d\n", c, n[c], m[c], v[c, "equal"], v[c, "QEMU"], v[c, "board"], v[c, "both"], v[c, "wrong"] }
            printf "# %-12s %6d %12d %6d %10d %10d %5d %6d\n", "all", all, manual, t["equal"], t["QEMU"], t["board"], t["both"], t["wrong"] }' "$tmp/judged"
}
nothing_wrong() { # IMAGE
    awk -v image="$1" '$1 == image && $6 == "wrong"' "$tmp/judged"
    [ "$(awk -v image="$1" '$1 == image && $6 == "wrong"' "$tmp/judged" | wc -l)" = 0 ] &&
        [ "$(awk -v image="$1" '$1 == image' "$tmp/judged" | wc -l)" -ge 2 ] && grep -q '^end$' "$tmp/$1.qemu" && ! grep -q stray_ "$tmp/$1.board"
}
ended_or_refused() { # IMAGE: an image that the board gives up on is in the README with what it says
    cat "$tmp/$1.err"
    grep -q '^end$' "$tmp/$1.board" && return 0
    local said
    said=$(sed -n "s/^| \`$1\` | \(.*\) |\$/\1/p" "$list" | sed -n 's/^stops: `\([^`]*\)`.*/\1/p')
    [ -n "$said" ] && grep -qF "$said" "$tmp/$1.err"
}
nothing_stale() { ! grep -E 'stale$' "$tmp/judged"; }
enough() { [ "$(grep -vc "^stale" "$tmp/judged")" -ge 1050 ]; }
deviation_is_found() { # the judge itself: one value changed is wrong
    sed '0,/^core adds_overflow /s/0x80000000/0x80000001/2' "$tmp/joined" | judge | grep -q '^core adds_overflow .* wrong$'
}

table
for image in $images; do
    check "$image: the manual's values, and QEMU's, but for what is listed" nothing_wrong "$image"
    check "$image: comes to its end, or stops as listed" ended_or_refused "$image"
done
check "no deviation of the board is listed that is none any more" nothing_stale
check "at least 1050 checks" enough
check "a changed value is found" deviation_is_found
finish
