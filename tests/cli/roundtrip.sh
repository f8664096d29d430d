#!/usr/bin/env bash
# matrig export --format csv, matrig import into another campaign, and so on: the same landing of the same board, and its columns byte
# for byte, from serial, from CAN alone, in SI units, damaged, and without a baseline or an edge.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
m() { build/matrig --quiet "$@"; }

record() { # NAME LANDING LINKS [FAULT]
    printf 'matrig-faults 1\n%s\n' "${4:-at 0.05 none}" >"$tmp/faults"
    played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig "tests/runs/landing$2.run" \
        ${4:+--faults "$tmp/faults"} --seed "$2" >/dev/null 2>"$tmp/board.err" || { cat "$tmp/board.err"; return 1; }
    case $3 in both) m log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$tmp/$1.db" >/dev/null ;;
    can) m log --can "file:$tmp/can" --db "$tmp/$1.db" >/dev/null ;; esac
}
# All columns but the last two: where a reading came from is another thing the second time, and why one is missing is not imported.
columns() { grep -v '^#' "$1" | awk -F, -v OFS=, '{NF -= 2; print}'; }
identity() { sqlite3 "$1" "select board_landing, board_uid, firmware, image_crc, image_commit, config_crc, clock_source, armed_block, armed_us, state,
    touchdown_ft, switch_error_ft from landings where id = 1; select count, position, tick, step_codes, printf('%.17g', board_us) from edges where landing = 1;
    select position, step_codes, station_ft from switches where landing = 1; select idx, kind, number, band, station_ft from channels where landing = 1 and kind in (1, 2)"; }
goes_round() { # NAME [--si]: three generations
    local before=$tmp/$1.0 db=$tmp/$1.db n
    m $2 export "$db" 1 --format csv -o "$before.csv" || return 1
    for n in 1 2 3; do
        rm -f "$tmp/$1.$n.db"
        m import "$tmp/$1.$n.db" "$before.csv" >"$tmp/out" && grep -q "$(awk -F'[ ,]' 'NR == 1 {print "RUN 1  *landing " $8 ", .*, board " $11}' "$before.csv")" "$tmp/out" || { cat "$tmp/out"; return 1; }
        m $2 export "$tmp/$1.$n.db" 1 --format csv -o "$tmp/$1.$n.csv" || return 1
        cmp <(columns "$tmp/$1.0.csv") <(columns "$tmp/$1.$n.csv") && cmp <(sed -n 1p "$tmp/$1.0.csv") <(sed -n 1p "$tmp/$1.$n.csv") &&
            cmp <(identity "$db") <(identity "$tmp/$1.$n.db") || return 1
        before=$tmp/$1.$n
    done
    [ "$(columns "$tmp/$1.0.csv" | wc -l)" -gt 5000 ] && cmp "$tmp/$1.2.csv" "$tmp/$1.3.csv" # and then every byte
}
check "landings are recorded" eval 'record both 5 both && record can 5 can && record damaged 5 both "at 0.05 switch 12 bounce 3 700" && record open 4 both "at 0.05 transducer 3 open"'
check "serial and CAN: three times round, the same" goes_round both
check "CAN alone" goes_round can
check "in SI units" eval 'cp "$tmp/both.db" "$tmp/si.db" && goes_round si --si'
check "a switch that bounced" goes_round damaged
check "a transducer that is missing" goes_round open

known() { # the campaign that it came from, and a table of it that is another file
    m --si export "$tmp/both.db" 1 --format csv -o "$tmp/si.csv" && sed 's/,0.00000,/,0.00001,/' "$tmp/both.0.csv" >"$tmp/other.csv" &&
        fails_with 2 "there already: landing 5 of board [0-9A-F]{24} is RUN 1 of .*both.db: .*--like 1 puts the table beside it" build/matrig import "$tmp/both.db" "$tmp/both.0.csv" &&
        fails_with 2 'there already: landing 5 ' build/matrig import "$tmp/both.1.db" "$tmp/si.csv" &&
        fails_with 2 'there already: landing 5 ' build/matrig import "$tmp/both.1.db" "$tmp/other.csv" &&
        [ "$(sqlite3 "$tmp/both.1.db" 'select count(*) from landings')" = 1 ]
}
again() { # it is another landing then: the board's own records would not know to which of two they belong
    m import "$tmp/both.1.db" "$tmp/si.csv" --again >"$tmp/out" && grep -q 'RUN 2  *landing 5, done, board unknown' "$tmp/out" &&
        m import "$tmp/both.db" "$tmp/si.csv" --like 1 >"$tmp/out" && grep -q 'RUN 2  *landing 5, done, board unknown' "$tmp/out"
}
another_counter_is_another() {
    sed '2s/"landing":5/"landing":6/' "$tmp/both.0.csv" >"$tmp/six.csv" && m import "$tmp/both.2.db" "$tmp/six.csv" | grep -q 'RUN 2  *landing 6, done, board [0-9A-F]\{24\}'
}
damaged_origin() { # a byte of that line, any: told, and the readings are kept
    local change
    for change in '2s/"landing":5/"landing":-5/' '2s/"edges":\[/"edges":[[1,2,3],/' '2s/.$//' '2s/"board":"0/"board":"0000/' '2s/"kind/"k/;2s/"state":4/"state":9/'; do
        sed "$change" "$tmp/both.0.csv" >"$tmp/damaged.csv"
        rm -f "$tmp/damaged1.db"
        fails_with 4 'malformed at line 2, column 1: the landing that the table is of is not told' build/matrig --quiet import "$tmp/damaged1.db" "$tmp/damaged.csv" || return 1
        m export "$tmp/damaged1.db" 1 --format csv -o "$tmp/damaged1.csv" && [ "$(columns "$tmp/damaged1.csv" | wc -l)" -gt 5000 ] || return 1
    done
}
without_origin() { # a table of before
    sed 2d "$tmp/both.0.csv" >"$tmp/old.csv" && m import "$tmp/old.db" "$tmp/old.csv" | grep '^taken  *[0-9]* rows$'
}
reads_as_such() { m report "$tmp/both.1.db" -o "$tmp/r.html" && grep -q 'imported from' "$tmp/r.html" && build/matrig --json compare "$tmp/both.1.db" 1 >/dev/null &&
    grep -q '"relative"\|^# landing: {"run":1,"landing":5,' "$tmp/both.1.csv"; }
check "the same landing is known again, whatever the bytes" known
check "--again and --like make another, without the board's name" again
check "another counter is another landing" another_counter_is_another
check "a damaged line of origin is told" damaged_origin
check "a table without one" without_origin
check "report and compare take it" reads_as_such
finish
