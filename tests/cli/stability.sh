#!/usr/bin/env bash
# A sample of the stability study: every 40th of its 2,000 scenes, every 125th of its 5,000 landings.
. "$(dirname "$0")/tap.sh"
study() { build/tests/stability/stability --every 40 "$tmp" >"$tmp/summary.txt" || { cat "$tmp/summary.txt"; false; }; }
check "no answer is contradicted, nothing crashes" study
most_answered() {
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i }
        NR > 1 { ok += $column["auto"] == "ok"
                 seen += $column["auto"] == "ok" && ($column["event"] $column["implicit"] $column["cvode"] ~ /ok/) }
        END { print NR - 1 " scenes, " ok " answered, " seen " of them by another solver too"
              exit !(NR == 51 && ok >= 40 && seen >= 0.9 * ok) }' "$tmp/table.csv"
}
check "most scenes are answered, most answers are confirmed" most_answered
landings() { build/tests/stability/stability --fixed --every 125 "$tmp" >"$tmp/landings.txt" || { cat "$tmp/landings.txt"; false; }; }
check "the landing engine's stated errors hold its true ones" landings
all_sorts() {
    cat "$tmp/landings.txt"
    awk '/^all / { seen = $2 == 40 && $3 >= 34 } /^(low|full), (free|fixed) (free|fixed) / { kinds += $4 > 0 } END { exit !(seen && kinds == 8) }' "$tmp/landings.txt"
}
check "of all ends and both profiles, most of them compared" all_sorts
no_holes() { ! grep -Eqi 'nan|inf' "$tmp/table.csv" "$tmp/landings.csv"; }
check "a table without holes" no_holes
finish
