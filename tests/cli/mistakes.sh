#!/usr/bin/env bash
# Mistakes of people (mistakes.txt): each ends with the exit code of the contract and one line that has the words which help; with --json the
# kind of mistake is a word of one object.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
d=$tmp/d
mkdir -p "$d"
played --elf build/firmware/matrig.elf --can "file:$d/board.log" --serial "file:$d/board.bin" --rig tests/runs/landing5.run 2>/dev/null
build/matrig --quiet log --can "file:$d/board.log" --serial "file:$d/board.bin" --db "$d/campaign.db" >/dev/null
cp host/scenes/model_runway.json "$d/scene.json" && cp tests/runs/landing5.run "$d/run" && printf 'kind;line\n1;2\n' >"$d/sheet.csv" && echo '<!DOCTYPE html>' >"$d/report.html"
printf 'mm,codes\n0,62.1\n12.7,372.4\n25.4,682.6\n' >"$d/points.csv"
cp "$d/run" "$d/run.json" && printf 'PK\003\004sheet' >"$d/book.xlsx" && printf 'kind,line,place,reading_in\ngap,1,0,851.2\n' >"$d/mm.csv" && printf 'kind,line,place,reading_mm\ngap,1,0,33.51\n' >"$d/in.csv"
gzip -kc "$d/campaign.db" >"$d/campaign.db.gz" && gzip -kc "$d/board.log" >"$d/board.log.gz"
printf 'LOGG\220\0\0\0' >"$d/trace.blf" && printf ';$FILEVERSION=1.1\n' >"$d/trace.trc" && printf 'kind\tline\n1\t2\n' >"$d/tabs.csv"
printf 'kind,line,place,reading_in\ngap,1,0,33,8\n' >"$d/comma.csv" && printf 'in,codes\n"0,5","372,4"\n' >"$d/quoted.csv" && printf 'in,codes\n0,5,372,4\n' >"$d/four.csv"
before=$(cd "$d" && find . -type f -exec sha256sum {} + | sort)

python3 tests/cli/mistakes.py tests/cli/mistakes.txt "$d" >"$tmp/mistakes.tap"
cat "$tmp/mistakes.tap"
count=$(grep -c '^\(not \)\?ok ' "$tmp/mistakes.tap")
tests=$((tests + count))
check "at least 220 of them" test $count -ge 220
a_terminal() { # bytes that are no text stay away from it
    script -qec "build/matrig export $d/campaign.db 1 --format mdf4" /dev/null >"$tmp/out" </dev/null
    local status=$?
    cat -v "$tmp/out"
    [ $status = 2 ] && grep -q 'binary data on a terminal' "$tmp/out" && [ "$(wc -c <"$tmp/out")" -lt 300 ] && [ "$(build/matrig export "$d/campaign.db" 1 --format mdf4 | head -c 3)" = MDF ]
}
check "no binary data on a terminal" a_terminal
left_as_it_was() { rm -f "$d"/campaign.db-*; [ "$before" = "$(cd "$d" && find . -type f -exec sha256sum {} + | sort)" ]; }
check "none leaves anything behind" left_as_it_was
finish
