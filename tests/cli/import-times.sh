#!/usr/bin/env bash
# matrig import: times that cannot be, and header lines that are rows. What is set aside is counted and told with its line; no time
# makes the memory or the length of a landing; no row goes lost under the verdict "complete". Memory is bounded here by ulimit, in kB.
. "$(dirname "$0")/tap.sh"
m() { (ulimit -v 300000 && exec build/matrig --quiet "$@"); }
echo '{"time": {"column": "t"}, "channels": [{"column": "d", "channel": "d1", "unit": "in"}]}' >"$tmp/named.json"
numbered() { echo "{\"header_lines\": $1, \"time\": {\"column\": 1}, \"channels\": [{\"column\": 2, \"channel\": \"d1\", \"unit\": \"in\"}]}" >"$tmp/numbered.json"; }
table() { # FIRST-ROW... : then 200 rows at 1 kHz from 10 s on, then what stands on the standard input
    printf 't,d\n%s' "$1"
    awk 'BEGIN {for (i = 0; i < 200; i++) printf "%.3f,%.3f\n", 10 + i / 1000, i / 100}'
    printf '%s' "$2"
}
blocks() { sqlite3 "$1" "select length(readings) / 4 from imported"; }
taken() { # CODE PATTERN BLOCKS FIRST LAST: exit and message, and how long the landing is
    table "$4" "$5" >"$tmp/t.csv"
    rm -f "$tmp/t.db"
    m import "$tmp/t.db" "$tmp/t.csv" --map "$tmp/named.json" >"$tmp/out" 2>"$tmp/err"
    local code=$?
    cat "$tmp/out" "$tmp/err"
    [ $code = "$1" ] && grep -Eq "$2" "$tmp/err" && [ "$(blocks "$tmp/t.db")" = "$3" ]
}
far='malformed at line 202, column 1: the time is more than a minute later than in the row before; 1 line was skipped'
last() { taken 4 "$far" 200 '' $'3000,1\n' && taken 4 "$far" 200 '' $'1e6,1\n'; }
no_clock() { taken 4 'malformed at line 202, column 1: impossible time; 1 line' 200 '' $'1e308,1\n' && taken 4 'malformed at line 2, column 1: impossible time' 200 $'-1e308,1\n' ''; }
value() { taken 4 'malformed at line 202, column 8: impossible value; 1 line' 200 '' $'10.200,1e300\n'; }
alone() { # a row and no other: the one that was written beyond its buffer
    local time
    for time in 1e308 -1e308 1e300 1e13; do
        printf 't,d\n%s,2\n' $time >"$tmp/one.csv"
        fails_with 4 '0 rows are valid and 1 are invalid: .*impossible time' build/matrig import "$tmp/one.db" "$tmp/one.csv" --map "$tmp/named.json" || return 1
    done
    printf 't,d\n1e11,2\n' >"$tmp/one.csv" && m import "$tmp/one.db" "$tmp/one.csv" --map "$tmp/named.json" && [ "$(blocks "$tmp/one.db")" = 1 ]
}
goes_back() { # a table that does not go on is refused, with the line where
    { printf 't,d\n'; awk 'BEGIN {for (i = 0; i < 400; i++) printf "%.3f,1\n", i / 1000 - (i > 199) * 120}'; } >"$tmp/back.csv"
    fails_with 4 '200 rows are valid and 200 are invalid: .*line 202, column 1: the time is not later than in the row before' build/matrig import "$tmp/back.db" "$tmp/back.csv" --map "$tmp/named.json"
}
beside_a_landing() { # whose time the file's is put into: beyond what a board counts
    sqlite3 "$tmp/t.db" "update imported set readings = readings" && table '' '' | sed 's/^10\./9999999910./' >"$tmp/late.csv"
    fails_with 2 'record ends at board time .*board time is at most 4294967 s' build/matrig import "$tmp/t.db" "$tmp/late.csv" --map "$tmp/named.json" --like 1
}
frames() { # STAMP: 200 frames of 1 kHz, and one of this stamp in the middle
    awk -v odd="$1" 'BEGIN {for (i = 0; i < 200; i++) {printf "(1700000000.%06d) can1 321#%02X00000000000000\n", i * 1000, i; if (i == 99) printf "(%s) can1 321#FF00000000000000\n", odd}}'
}
a_stamp_of_a_frame() {
    echo '{"channels": [{"id": "0x321", "bits": 8, "channel": "d1", "unit": "in", "scale": 0.01}]}' >"$tmp/frames.json"
    local odd
    for odd in 1700003000.000000 9999999999.000000 1600000000.000000; do
        frames $odd >"$tmp/f.log"
        rm -f "$tmp/f.db"
        m import "$tmp/f.db" "$tmp/f.log" --map "$tmp/frames.json" >"$tmp/out" 2>"$tmp/err"
        local code=$?
        cat "$tmp/err"
        [ $code = 4 ] && grep -Eq 'malformed at line 101.*1 line was skipped' "$tmp/err" && [ "$(blocks "$tmp/f.db")" = 200 ] || return 1
    done
}
# ---- header lines ----
eleven_taken() { tee "$tmp/taken" && grep -q "verdict  *complete$" "$tmp/taken" && grep -q "^imported  *11 rows$" "$tmp/taken"; }
by_lines() { # HEADER-LINES TEXT: imported with columns counted
    numbered "$1"
    printf "$2" >"$tmp/h.csv"
    rm -f "$tmp/h.db"
    m import "$tmp/h.db" "$tmp/h.csv" --map "$tmp/numbered.json" >"$tmp/out" 2>"$tmp/err"
    local code=$?
    cat "$tmp/out" "$tmp/err"
    return $code
}
rows=$'0.000,1\n0.001,2\n0.002,3\n0.003,4\n0.004,5\n0.005,6\n0.006,7\n0.007,8\n0.008,9\n0.009,10\n0.010,11\n'
blank_lines_count() { # title, blank line, names
    by_lines 3 $'a title\n\nt,d\n'"$rows" && eleven_taken <"$tmp/out" && [ "$(blocks "$tmp/h.db")" = 11 ] &&
        printf 'a title\n\n\nt,d\n%s' "$rows" >"$tmp/b.csv" && sed 's/{"time/{"header_lines": 4, "time/' "$tmp/named.json" >"$tmp/four.json" &&
        m import "$tmp/h.db" "$tmp/b.csv" --map "$tmp/four.json" | eleven_taken
}
comments_do_not() { by_lines 1 $'# a comment\n\n'"$rows" && eleven_taken <"$tmp/out"; }
a_row_is_no_header() {
    by_lines 2 $'t,d\n'"$rows"
    [ $? = 4 ] && grep -q 'malformed at line 2, column 1: a data row is within the header lines; correct header_lines; 1 line was skipped' "$tmp/err"
}
numbers_may_be_names() { by_lines 1 $'0,1\n'"$rows" && eleven_taken <"$tmp/out"; }
names_are_looked_for_there() {
    sed 's/{"time/{"header_lines": 2, "time/' "$tmp/named.json" >"$tmp/two.json"
    printf 'a title\n\nt,d\n%s' "$rows" >"$tmp/n.csv"
    fails_with 4 "no column 't': .*line 2; .*header_lines includes blank lines, but not comments" build/matrig import "$tmp/n.db" "$tmp/n.csv" --map "$tmp/two.json"
}

check "a row far beyond all others is set aside and told" last
check "a time that no clock shows costs its row" no_clock
check "a value that no float holds costs its row" value
check "a row alone with such a time" alone
check "a table that goes back is refused" goes_back
check "beside a landing, beyond what a board counts" beside_a_landing
check "a wrong stamp in a log of frames costs its frame" a_stamp_of_a_frame
check "blank lines are header lines" blank_lines_count
check "comments are none" comments_do_not
check "a row among the header lines is told" a_row_is_no_header
check "numbers may be names" numbers_may_be_names
check "names are looked for in the line that the mapping says" names_are_looked_for_there
finish
