#!/usr/bin/env bash
# matrig report -o DIR/: a front and a page for each landing, which say what the one page says; made anew only where something changed; files of
# the user's stay; whole pages alone after an interruption; memory of one landing.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/c.db
d=$tmp/d

campaign() {
    played --elf build/firmware/matrig.elf --can "file:$tmp/can" --serial "file:$tmp/serial" --rig tests/runs/landing5.run &&
        $matrig --quiet log --can "file:$tmp/can" --serial "file:$tmp/serial" --db "$db" >/dev/null && python3 tests/report/grow.py "$db" 3
}
made() { # WHAT IT SAYS: then the report is made into the folder
    $matrig report "$db" -o "$d/" 2>"$tmp/said" && grep -q "$1" "$tmp/said" || { cat "$tmp/said"; false; }
}
files() { (cd "$d" && stat -c '%n %i %Y' -- *.html | sort); }
changed() { # NAMES...: since the last call of files >before these alone were written anew
    files >"$tmp/after"
    diff "$tmp/before" "$tmp/after" | sed -n 's/^> \([^ ]*\) .*/\1/p' | xargs >"$tmp/changed"
    cp "$tmp/after" "$tmp/before"
    [ "$(cat "$tmp/changed")" = "$*" ] || { cat "$tmp/changed"; false; }
}
first() {
    made '3 landings in .*d/index.html: 3 pages made, 0 as before' && [ "$(cd "$d" && ls | xargs)" = "index.html run1.html run2.html run3.html" ] && files >"$tmp/before"
}
# Sections are those of one page; where that leads to a landing, the front leads to its page.
same_words() {
    $matrig --quiet report "$db" -o "$tmp/one.html" && python3 - "$tmp/one.html" "$d" <<'EOP'
import re, sys
one, folder = open(sys.argv[1]).read(), sys.argv[2]
def sections(text):
    return dict(re.findall(r'<section id="(\w+)"[^>]*>(.*?)</section>', text, re.S))
front, whole = sections(open(folder + "/index.html").read()), sections(one)
assert set(whole) - set(front) == {"run1", "run2", "run3"} and len(front) > 5, (list(whole), list(front))
for name in set(front) - {"provenance"}:
    assert front[name] == re.sub(r'href="#(run\d+)"', r'href="\1.html"', whole[name]), name
for run in (1, 2, 3):
    page = sections(open("%s/run%d.html" % (folder, run)).read())
    assert page["run%d" % run] == whole["run%d" % run], run
    record = re.search(r"[0-9a-f]{64}</td></tr>", page["provenance"]).group(0)
    assert record in whole["provenance"] and record in front["provenance"] and "unit_per_code" not in page, run
EOP
}
alone() { # every link leads to a file of the folder or a place of the page, and nothing is loaded
    python3 - "$d" <<'EOP'
import os, re, sys
folder = sys.argv[1]
for name in sorted(n for n in os.listdir(folder) if n.endswith(".html")):
    text = open(folder + "/" + name).read().replace("http://www.w3.org/2000/svg", "")  # a name that nothing is fetched by
    assert len(re.findall("<script", text)) == 1 and not re.search(r"<(img|link|iframe|object|embed)\b|src=|url\((?!#)|@import|https?:", text), name
    links = re.findall(r'href="([^"]*)"', text)
    assert links and all(('id="%s"' % l[1:]) in text if l[0] == "#" else l in os.listdir(folder) for l in links), (name, links)
    if name == "run2.html":
        assert {"index.html", "run1.html", "run3.html"} <= set(links), links
    if name == "index.html":
        assert {"run1.html", "run2.html", "run3.html"} <= set(links), links
EOP
}
again() { made ' 0 pages made, 3 as before' && changed; }
one_more() { python3 tests/report/grow.py "$db" 4 && made '4 landings.* 2 pages made, 2 as before' && changed index.html run3.html run4.html; }
noted() {
    $matrig --quiet landing "$db" 2 --note 'brakes grabbed late' --who jk >/dev/null && made ' 1 page made, 3 as before' && changed index.html run2.html &&
        grep -q 'brakes grabbed late' "$d/run2.html" && grep -q 'brakes grabbed late' "$d/index.html"
}
# Whatever else a page rests on: a row that a link brought late, a survey between two landings, a series, another calibration.
rows_changed() {
    sqlite3 "$db" "update motion set speed_ft_s=speed_ft_s+1 where landing=1" && made ' 1 page made' && changed index.html run1.html || return 1
    sqlite3 "$db" "insert into blocks select session, boot, idx+100000, 3, host_us, record, 2 from blocks where landing=3 limit 1" &&
        made ' 1 page made' && changed index.html run3.html || return 1
    sqlite3 "$db" "delete from blocks where link=2; insert into recalibrations(landing, idx, item, was, value, made_us) values (4, 0, -1, 1, 1, 1)" &&
        made ' 2 pages made' && changed index.html run3.html run4.html || return 1
    sqlite3 "$db" "update landings set armed_us=armed_us+1000000*id" && made ' 4 pages made' && files >"$tmp/before" || return 1
    sqlite3 "$db" "update slack set slack_in=0.5 where survey=(select id from surveys where landing=4)" && made ' 2 pages made' && changed index.html run3.html run4.html
}
options() { # others say another thing
    $matrig --quiet --si report "$db" -o "$d" && changed index.html run1.html run2.html run3.html run4.html && grep -q 'm/s' "$d/run1.html" &&
        made ' 4 pages made' && files >"$tmp/before"
}
own_files() {
    echo mine >"$d/notes.txt" && echo mine >"$d/run9.html" && echo '<!-- mine -->' >>"$d/run2.html" && cp "$d/run2.html" "$tmp/mine" && files >"$tmp/before" || return 1
    $matrig landing "$db" 1 --note x >/dev/null && fails_with 2 'was changed since matrig wrote it: .*run2.html' $matrig report "$db" -o "$d" && changed &&
        [ "$(cat "$d/notes.txt" "$d/run9.html")" = "mine
mine" ] && cmp "$d/run2.html" "$tmp/mine" && mkdir "$tmp/other" && echo mine >"$tmp/other/index.html" &&
        fails_with 2 'nothing says that matrig wrote it: .*index.html' $matrig report "$db" -o "$tmp/other" && [ "$(ls -A "$tmp/other")" = index.html ] &&
        $matrig --quiet report "$db" -o "$d" --force && ! grep -q mine "$d/run2.html" && [ "$(cat "$d/run9.html")" = mine ]
}
voided() { # its page goes, unless somebody changed it
    $matrig landing "$db" 2 --void --reason 'a dog' >/dev/null && made 'others removed' && [ ! -e "$d/run2.html" ] && grep -q '1 that is void left out' "$d/index.html" &&
        ! grep -q run2.html "$d"/*.html && $matrig landing "$db" 2 --unvoid --reason 'no dog' >/dev/null && made ' pages made' && [ -e "$d/run2.html" ] &&
        echo mine >>"$d/run2.html" && $matrig landing "$db" 2 --void --reason 'a dog' >/dev/null && made ' pages made' && tail -n 1 "$d/run2.html" | grep -q mine
}
damaged() { # what is kept cannot be read: all is made anew
    for bytes in 10 3000; do
        printf 'xxxx' | dd of="$d/.matrig-report" bs=1 seek=$bytes conv=notrunc 2>/dev/null
        fails_with 2 'was changed.*matrig-report' $matrig report "$db" -o "$d" && $matrig report "$db" -o "$d" --force 2>"$tmp/said" &&
            grep -q ' 3 pages made, 0 as before' "$tmp/said" || return 1
    done
    : >"$d/.matrig-report" && made ' 3 pages made, 0 as before' && rm "$d/.matrig-report" && made ' 3 pages made, 0 as before'
}
interrupted() { # killed when the first page is there
    $matrig --quiet report "$db" -o "$tmp/i/" &
    local job=$!
    until [ -e "$tmp/i/run1.html" ] || ! kill -0 $job 2>/dev/null; do :; done
    kill -9 $job
    wait $job
    [ -e "$tmp/i/run1.html" ] || return 1
    for page in "$tmp"/i/*.html; do tail -c 16 "$page" | grep -q '</body></html>' || return 1; done
    $matrig --quiet report "$db" -o "$tmp/i" && [ "$(ls "$tmp/i" | xargs)" = "index.html run1.html run3.html run4.html" ]
}
memory() { # of 20 landings as of 4
    python3 tests/report/grow.py "$db" 20 && python3 - $matrig "$db" "$tmp/m" <<'EOP'
import os, subprocess, sys
matrig, db, folder = sys.argv[1:]
def peak_kb(*arguments):
    child = subprocess.Popen([matrig, "--quiet", "report", db, "-o", *arguments])
    return os.wait4(child.pid, 0)[2].ru_maxrss
one, all_ = peak_kb(folder + ".html", "--run", "1"), peak_kb(folder + "/")
print(one, all_)
assert all_ < one + 6000 and all_ < 40000
EOP
}
silly() {
    rm "$d/run9.html"
    fails_with 2 'is a folder.*-o F.html' $matrig report "$db" --run 1 -o "$d" && fails_with 3 'cannot make the folder' $matrig report "$db" -o "$tmp/none/none/" &&
        fails_with 3 'cannot make the folder' $matrig report "$db" -o "$db/" && $matrig --json report "$db" -o "$d" | grep -q '"landings":15,"made":13,"left":2'
}

check "a campaign of three landings" campaign
check "a front and three pages" first
check "they say what the one page says" same_words
check "they need nothing but each other" alone
check "nothing changed: nothing is written" again
check "one landing more" one_more
check "a note" noted
check "rows that a page rests on" rows_changed
check "SI units" options
check "files of the user's stay" own_files
check "a voided landing" voided
check "what is kept is damaged" damaged
check "killed in the middle" interrupted
check "memory does not grow" memory
check "silly input" silly
finish
