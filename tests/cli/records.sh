#!/usr/bin/env bash
# Records of what the crew sets, inspects and writes down. Limits and values are those of the report of 1973: joints of 12 lb/in and 0.036 in
# (2.5, 2.7.2), separation at 30 degrees (2.5), CBR of 11 % (4.1), mats of 140 to 160 lb by 7^3 (table 3.1), tires of 5 psi (2.3),
# a path 1.4 ft left of the center (4.2), 50 to 90 F (2.7.1), 13 panels dislocated (4.1).
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
db=$tmp/campaign.db
export USER=tester
campaign_of "$db" 1 4 >/dev/null
sqlite3 "$db" 'pragma wal_checkpoint(truncate)' >/dev/null
cp "$db" "$tmp/none.db"
record() { $matrig --quiet record "$db" "$@"; }
field() { $matrig --json record "$1" | python3 -c "import json, sys; r = [r for r in json.load(sys.stdin)['records'] if r['id'] == $2][0]; print(r$3)"; }
bytes() { cat "$1" "$1-wal" 2>/dev/null | wc -c; }

none_cost_nothing() { # no table, no byte, no section; a campaign of before has just that
    [ "$(sqlite3 "$tmp/none.db" "select count(*) from sqlite_schema where name like 'records%'")" = 0 ] || return 1
    local was
    was=$(bytes "$tmp/none.db")
    $matrig record "$tmp/none.db" 2>"$tmp/err" && grep 'no records yet' "$tmp/err" && $matrig --json record "$tmp/none.db" 2>/dev/null | grep '{"records":\[\]}' || return 1
    $matrig --json report "$tmp/none.db" -o "$tmp/none.html" >/dev/null && ! grep 'id="records"\|Conditions, damage' "$tmp/none.html" && [ "$(bytes "$tmp/none.db")" = "$was" ]
}
adds() { # a value as it is typed, in any unit of its kind
    record conditions 1 drive=coast touchdown_plywood=yes tire_psi=5 temperature_f=20degC membrane='vinyl, "6 mil"' planned_braking_ft_s2=4 left_of_center_ft='16.8 in' >"$tmp/said" || return 1
    grep 'records added *1$' "$tmp/said" && $matrig --json record "$db" conditions 1 >"$tmp/said" && python3 - "$tmp/said" <<'PY'
import json, sys
r, = json.load(open(sys.argv[1]))["records"]
assert r["fields"] == {"drive": "coast", "touchdown_plywood": "yes", "tire_psi": 5, "temperature_f": 68, "membrane": 'vinyl, "6 mil"',
                       "planned_braking_ft_s2": 4, "left_of_center_ft": 1.4}, r
assert r["kind"] == "conditions" and r["run"] == 1 and r["valid"] and r["who"] == "tester"
PY
}
keeps_the_last() { # what changes with each landing is not kept: the temperature
    record conditions 2 planned_braking_ft_s2=4.6 --who kl >"$tmp/said" || return 1
    cat "$tmp/said"
    tr '\n' ' ' <"$tmp/said" | grep '^Kept from record 1: drive=coast, touchdown_plywood=yes, tire_psi=5, membrane=vinyl, "6 mil", left_of_center_ft=1.4\.' && [ "$(wc -l <"$tmp/said")" -le 5 ] && ! grep 'temperature\|planned' "$tmp/said" &&
        [ "$(field "$db" 2 "['fields']['drive']")" = coast ] && [ "$(field "$db" 2 "['fields'].get('temperature_f')")" = None ] && [ "$(field "$db" 2 "['who']")" = kl ]
}
errors_stay_with_their_value() {
    record --correct 2 temperature_f='23 degC +- 1 degC' --reason 'thermometer read' >/dev/null && python3 - "$($matrig --json record "$db" conditions 2)" <<'PY'
import json, sys
f = json.loads(sys.argv[1])["records"][-1]["fields"]
assert abs(f["temperature_f"] - (23 * 9 / 5 + 32)) < 1e-12 and abs(f["temperature_f_error"] - 9 / 5) < 1e-12, f
PY
}
judged() { $matrig --json record "$db" "$@" >"$tmp/said" && cat "$tmp/said" >&2 && sed -n 's/.*"result":"\([^"]*\)".*/\1/p' "$tmp/said"; }
passes_and_fails() {
    while IFS='|' read -r expected words; do
        eval "set -- $words"
        is=$(judged "$@")
        [ "$is" = "$expected" ] || { echo "$words: $is"; return 1; }
    done <<'T'
pass|mat 1 joint_lb_in=12.5 slack_in=0.030 unhinge_deg=31 weight_lb=0.45
fail|mat 2 joint_lb_in=11.5
within its error of the limit|mat 3 joint_lb_in=12.3+-0.4
within its error of the limit|mat 4 'joint_lb_in=2102 N/m +/- 5'
fail|mat 5 slack_in=1mm
pass|mat 6 slack_in='0.9 mm+-0.01 mm'
fail|mat 7 weight_lb=0.5 joint_lb_in=30
fail|mat 8 unhinge_deg=29 weight_lb=0.42
pass|subgrade 30 cbr_percent=11
fail|subgrade '40 ft' cbr_percent='10.9 %'
pass|subgrade 12.192m cbr_percent=40%
fail|subgrade 50 cbr_percent=10
within its error of the limit|subgrade 60 cbr_percent=10+-2
T
    [ "$(field "$db" 14 "['station_ft']")" = 40.0 ] # 12.192 m
}
of_a_place() { # a mat, a station
    $matrig record "$db" mat 2 >"$tmp/said" && cat "$tmp/said" && grep -c '^ *[0-9]* *2 *fail' "$tmp/said" | grep '^1$' && grep '^0 pass, 1 fail,' "$tmp/said" && [ "$($matrig --json record "$db" subgrade 40ft | grep -o '"id"' | wc -l)" = 2 ] &&
        $matrig record "$db" mat 400 2>&1 | grep 'no record matches: ' && fails_with 2 'out of range: 421 for mat' $matrig record "$db" mat 421
}
worst_first() {
    record mat >"$tmp/said" || return 1
    cat "$tmp/said"
    grep '2 pass, 4 fail, 2 within the error of a limit\.$' "$tmp/said" && [ "$(grep -o '^ *[0-9]\+ \+[0-9]\+ *\(fail\|pass\|within\)' "$tmp/said" | awk '{print $3}' | uniq | tr '\n' ' ')" = 'fail within pass ' ]
}
corrections_keep_their_history() {
    local before
    before=$(sqlite3 "$db" 'select count(*) from records')
    record --correct 5 joint_lb_in=12.8 --reason 'read again' >/dev/null && record mat >"$tmp/said" && grep '12.8 (was 11.5)' "$tmp/said" && grep 'read again' "$tmp/said" || return 1
    [ "$(sqlite3 "$db" 'select count(*) from records')" = $((before + 1)) ] && [ "$(field "$db" 5 "['fields']['joint_lb_in']")" = 11.5 ] && [ "$(field "$db" 5 "['valid']")" = False ] || return 1
    fails_with 2 'no valid record 5: record 17 corrects it; give 17$' $matrig record "$db" --correct 5 joint_lb_in=1 --reason again && fails_with 2 'no valid record 99: .*; matrig record DB lists them' $matrig record "$db" --correct 99 joint_lb_in=1 --reason again &&
        fails_with 2 'nothing changes: record 17 has these values already' $matrig record "$db" --correct 17 joint_lb_in=12.8 --reason again && fails_with 2 'the mat of a record cannot be corrected; add a new record, then matrig record DB --withdraw 17 --reason' $matrig record "$db" --correct 17 mat=3 --reason x && fails_with 2 'needs --reason' $matrig record "$db" --correct 6 joint_lb_in=1 &&
        sqlite3 "$db" "update records set fields='{}'" 2>&1 | grep 'history stays' && sqlite3 "$db" 'delete from records' 2>&1 | grep 'history stays'
}
withdrawn_ones_stay() {
    record --withdraw 11 --reason 'wrong mat' >/dev/null && record mat >"$tmp/said" && grep '^ *11 *8 *wrong mat' "$tmp/said" && grep '3 pass, 2 fail, 2 within' "$tmp/said" &&
        [ "$(field "$db" 11 "['valid']")" = False ] && fails_with 2 'no valid record 11: it is withdrawn' $matrig record "$db" --withdraw 11 --reason twice
}
what_was_different() {
    $matrig landing "$db" 2 --correct weight_lb=1300 --reason weighed >/dev/null
    $matrig --json record "$db" --compare 1 2 >"$tmp/said" && python3 - "$tmp/said" <<'PY'
import json, sys
d = {r["field"]: (r["from"], r["to"]) for r in json.load(open(sys.argv[1]))["differences"]}
assert d == {"weight_lb": (None, "1300"), "temperature_f": ("68", "73.4 +- 1.8"), "planned_braking_ft_s2": ("4", "4.6")}, d
PY
    # damage: what only one of the landings has; no record of a kind is stated as such
    cp "$tmp/none.db" "$tmp/w.db"
    w() { $matrig --quiet record "$tmp/w.db" "$@"; }
    w --compare 1 2 | grep '^Neither RUN 1 nor RUN 2 has a record\.$' && w damage 1 station_ft=85 what=weld >/dev/null && w damage 2 station_ft=85 what=weld >/dev/null && w --compare 1 2 | grep '^The records of RUN 1 and RUN 2 do not differ\.$' || return 1
    w damage 2 station_ft=12 what=rivet pieces=2 >/dev/null && w conditions 1 drive=coast tire_psi=5 >/dev/null && w --compare 1 2 >"$tmp/said" && cat "$tmp/said" || return 1
    grep '^  tire pressure (psi)  *5  *no record$' "$tmp/said" && grep '^  damage 1: station (ft)  *-  *12$' "$tmp/said" && [ "$(wc -l <"$tmp/said")" = 6 ]
}
csv_round_trip() {
    $matrig --quiet record "$tmp/copy.db" launch track_ft=375 drop_ft=20 glide_deg=3 overhang_ft=17 >/dev/null || return 1
    for kind in conditions mat subgrade; do
        record $kind -o "$tmp/$kind.csv" || return 1
    done
    for kind in mat subgrade; do
        $matrig --json record "$tmp/copy.db" $kind --csv "$tmp/$kind.csv" >"$tmp/said" && $matrig --quiet record "$tmp/copy.db" $kind -o "$tmp/copy.csv" && cmp "$tmp/$kind.csv" "$tmp/copy.csv" || return 1
    done
    cp "$tmp/none.db" "$tmp/other.db" && $matrig --quiet record "$tmp/other.db" conditions --csv "$tmp/conditions.csv" >/dev/null && $matrig --quiet record "$tmp/other.db" conditions -o "$tmp/copy.csv" &&
        cmp "$tmp/conditions.csv" "$tmp/copy.csv" && grep 'vinyl, ""6 mil""' "$tmp/copy.csv" || return 1
    # the digest of a picture and the marks of a height are in the sheet, too
    printf '\xff\xd8\xff a picture' >"$tmp/wave.jpg"
    for db in "$tmp/other.db" "$tmp/copy.db"; do cp "$tmp/none.db" "$db"; done
    $matrig --quiet record "$tmp/other.db" picture 2 file="$tmp/wave.jpg" height_ft='2 ft +- 0.02 ft: 100,300 500,300 200,240' >/dev/null && $matrig --quiet record "$tmp/other.db" picture -o "$tmp/picture.csv" &&
        grep "$(sha256sum "$tmp/wave.jpg" | cut -c 1-64)" "$tmp/picture.csv" && $matrig --quiet record "$tmp/copy.db" picture --csv "$tmp/picture.csv" >/dev/null &&
        [ "$(field "$tmp/other.db" 1 "['fields']")" = "$(field "$tmp/copy.db" 1 "['fields']")" ] && field "$tmp/copy.db" 1 "['fields']['height_ft_marks']" | grep '^2 ft' || return 1
    printf '\xff\xd8\xff another picture' >"$tmp/wave.jpg" && cp "$tmp/none.db" "$tmp/copy.db" && fails_with 3 'line 2: the picture has changed: ' $matrig record "$tmp/copy.db" picture --csv "$tmp/picture.csv" || return 1
    db=$tmp/campaign.db
    # a line that does not fit adds nothing of its file
    printf 'mat,joint_lb_in\n20,12.5\n21,-3\n' >"$tmp/bad.csv"
    fails_with 2 'bad.csv, line 3: out of range: -3 for joint_lb_in' $matrig record "$db" mat --csv "$tmp/bad.csv" && ! record mat | grep '12.5.* 20 ' &&
        printf 'mat,joint_lb_in\n20\n' >"$tmp/bad.csv" && fails_with 4 'line 2: the header has 2 cells' $matrig record "$db" mat --csv "$tmp/bad.csv" &&
        printf 'run,station_ft,what,note\n2,88,weld,"abc\n3,12,joint,x"\n' >"$tmp/bad.csv" && fails_with 4 'line 2: a quote is not closed' $matrig record "$db" damage --csv "$tmp/bad.csv" &&
        fails_with 2 'the damage ends beyond the runway' $matrig record "$db" damage 2 station_ft=118 length_ft=20 what=weld &&
        fails_with 2 'the level part is longer than the track' $matrig record "$db" launch track_ft=100 level_ft=200 &&
        [ "$(sqlite3 "$db" "select count(*) from records where place = 20")" = 0 ]
}
corrected_later() { # records that kept the value that was corrected are named, and not changed
    cp "$tmp/none.db" "$tmp/l2.db"
    l() { $matrig --quiet record "$tmp/l2.db" "$@"; }
    l conditions 1 tire_psi=5 temperature_f=70 >/dev/null && l conditions 2 temperature_f=70 >/dev/null && l --correct 1 tire_psi=6 temperature_f=71 --reason x >"$tmp/said" && cat "$tmp/said" &&
        grep '^Later records still have the old value: tire_psi in record 2\.$' "$tmp/said" && [ "$(field "$tmp/l2.db" 2 "['fields']['tire_psi']")" = 5.0 ] &&
        l --correct 2 tire_psi=6 --reason x >"$tmp/said" && ! grep 'Later records' "$tmp/said"
}
pictures_in_the_report() { # shown if they are unchanged and not too large
    cp "$tmp/none.db" "$tmp/p2.db"
    printf '\xff\xd8\xff picture' >"$tmp/small.jpg" && head -c 2000001 /dev/zero | sed '1s/^/\x89PNG\r\n\x1a\n/' >"$tmp/large.png" && printf '\xff\xd8\xff old' >"$tmp/gone.jpg"
    for file in small.jpg large.png gone.jpg; do $matrig --quiet record "$tmp/p2.db" picture 1 file="$tmp/$file" shows="<$file>" >/dev/null || return 1; done
    rm "$tmp/gone.jpg"
    sqlite3 "$tmp/p2.db" "insert into records (made_us, kind, landing, fields) values (1, 'picture', 1, '{\"file\": \"nothing.jpg\"}')" && $matrig record "$tmp/p2.db" picture | grep ' nothing.jpg' || return 1
    $matrig --quiet report "$tmp/p2.db" -o "$tmp/p2.html" >/dev/null && grep -o '<figure><figcaption>Record.*' "$tmp/p2.html" | cut -c 1-400 >"$tmp/said"
    cat "$tmp/said"
    [ "$(wc -l <"$tmp/said")" = 4 ] && grep -F "Record 1: &lt;small.jpg&gt;</figcaption><img " "$tmp/said" | grep -F "src=\"data:image/jpeg;base64,$(base64 -w0 "$tmp/small.jpg")\">" &&
        grep -F 'large.png&gt; (not shown: ' "$tmp/said" | grep 'has 2.0 MB, but the limit is 2 MB)' && grep 'not shown: the picture is missing: ' "$tmp/said"
}
pictures() { # the digest is the file's
    printf '\xff\xd8\xff not really a picture' >"$tmp/bow.jpg"
    record picture 2 file="$tmp/bow.jpg" station_ft=88 shows='two small waves' >/dev/null && [ "$(sqlite3 "$db" "select json_extract(fields, '\$.file_sha256') from records where kind = 'picture'")" = "$(sha256sum "$tmp/bow.jpg" | cut -c 1-64)" ] &&
        fails_with 3 'cannot read .*none.jpg .given for file' $matrig record "$db" picture 2 file="$tmp/none.jpg" && fails_with 4 'not a picture: tests/cli/records.sh' $matrig record "$db" picture 2 file=tests/cli/records.sh &&
        fails_with 2 'file is missing; give file=PATH' $matrig record "$db" picture 2 station_ft=88 shows=wave && fails_with 3 'cannot read /' $matrig record "$db" picture 2 file=/
}
pictures_from_anywhere() { # the path is relative to the folder of the database, else absolute
    local at=$tmp/at other=$tmp/other matrig=$PWD/$matrig
    mkdir -p "$at/film" "$other" && cp "$tmp/none.db" "$at/a.db" && printf '\xff\xd8\xff 1' >"$at/film/1.jpg" && printf '\xff\xd8\xff 2' >"$other/2.jpg" || return 1
    (cd "$at/film" && $matrig --quiet record ../a.db picture 1 file=1.jpg && cd "../../other" && $matrig --quiet record ../at/a.db picture 1 file=2.jpg) >/dev/null || return 1
    [ "$(field "$at/a.db" 1 "['fields']['file']")" = film/1.jpg ] && [ "$(field "$at/a.db" 2 "['fields']['file']")" = "$(realpath "$other/2.jpg")" ] && $matrig record "$at/a.db" picture >"$tmp/said" && ! grep 'picture .*: /' "$tmp/said" &&
        $matrig --quiet report "$at/a.db" -o "$tmp/at.html" && grep -c '<figcaption>.*base64,' "$tmp/at.html" | grep '^2$' || return 1
    # a sheet, too, from any folder
    (cd "$other" && $matrig --quiet record ../at/a.db picture -o 2.csv && cp ../none.db ../at/b.db && $matrig --quiet record ../at/b.db picture --csv 2.csv) >/dev/null && [ "$(field "$at/b.db" 1 "['fields']['file']")" = film/1.jpg ] || return 1
    printf '\xff\xd8\xff 3' >"$other/2.jpg" && rm "$at/film/1.jpg" && $matrig record "$at/a.db" 1 >"$tmp/said" && cat "$tmp/said" && tr '\n' ' ' <"$tmp/said" | tr -s ' ' >"$tmp/line" &&
        grep 'Record 1: the picture is missing: .*/at/film/1.jpg; restore it, or give its path: .*Record 2: the picture has changed: .*/other/2.jpg; ' "$tmp/line"
}
# 2 ft are 400 pixels, 60 of them 0.3 ft; the errors are worked by hand in tests/host/test_rig.c. The page itself: tests/browser/picture.py.
heights() {
    local all=$tmp/p.db id
    cp "$db" "$all"
    id=$(sqlite3 "$all" 'select max(id) from records')
    $matrig --quiet record "$all" --correct "$id" height_ft='2 ft +- 0.02 ft: 100,300 500,300 200,240' --reason film >/dev/null && [ "$(field "$all" $((id + 1)) "['fields']['height_ft']")" = 0.3 ] &&
        field "$all" $((id + 1)) "['fields']['height_ft_error']" | grep '^0.007' && $matrig record "$all" picture | grep 'height (ft)' && $matrig record "$all" picture | grep ' 0.3 +- 0.007' || return 1
    bad() { fails_with 2 "$1" $matrig record "$all" --correct $((id + 1)) height_ft="$2" --reason film; }
    bad 'not a list of marks: .2 ft: 1,2 3,4.' '2 ft: 1,2 3,4' && bad 'out of range: 0 ft' '0 ft: 0,0 90,0 1,1' && bad 'the points of known distance are only 9 pixels apart' '2 ft: 0,0 9,0 1,1' && bad 'the scale of the picture' '2 ft: 0,0 90,0 nan,1' || return 1
    $matrig record "$all" --measure $((id + 1)) -o "$tmp/marks.html" && grep '<title>matrig picture' "$tmp/marks.html" && grep -F "<svg id=\"picture\" data-file=\"$(realpath "$tmp/bow.jpg")\" data-campaign=\"$all\" data-record=\"$((id + 1))\"></svg>" "$tmp/marks.html" || return 1
    fails_with 2 'no file for the page' $matrig record "$all" --measure $((id + 1)) && echo other >"$tmp/bow.jpg" &&
        fails_with 3 'the picture has changed: .*bow.jpg' $matrig record "$all" --measure $((id + 1)) -o "$tmp/marks.html" && printf '\xff\xd8\xff not really a picture' >"$tmp/bow.jpg"
}
in_the_report() {
    record damage 2 station_ft=85 what=dislocated pieces=13 side=left note='<i>overrun' >/dev/null && $matrig --json report "$db" -o "$tmp/with.html" >/dev/null || return 1
    grep -q '<section id="records">' "$tmp/with.html" && [ "$(grep -c 'Conditions, damage and pictures' "$tmp/with.html")" = 2 ] && grep -q '3 pass, 2 fail, 2 within' "$tmp/with.html" &&
        grep -q '&lt;i&gt;overrun' "$tmp/with.html" && ! grep -q '<i>overrun' "$tmp/with.html" && grep -q '12.8 (was 11.5)' "$tmp/with.html" && grep -q 'wrong mat' "$tmp/with.html" &&
        grep -q "SHA-256 $(sha256sum "$tmp/bow.jpg" | cut -c 1-12)" "$tmp/with.html" && sed 's/<[^>]*>/ /g' "$tmp/with.html" | grep 'planned braking (ft/s.*) *4 *4.6 '
}
# Mats are 2 ft by 7: mat 2 from 2/7 to 4/7 ft. Valid records alone; mat 8 (2 to 16/7 ft) was withdrawn.
map_in_the_report() {
    cp "$db" "$tmp/m.db" && $matrig --quiet record "$tmp/m.db" damage 2 station_ft=88 length_ft=5 what=weld repair=relaid >/dev/null && $matrig --json report "$tmp/m.db" -o "$tmp/map.html" >/dev/null && python3 - "$tmp/map.html" <<'PY'
import json, re, sys
page = open(sys.argv[1]).read()
found, = re.findall(r'aria-label="damage and acceptance against station"><script type="application/json">(.*?)</script>', page, re.S)
figure = json.loads(found)
assert [k[1] for k in figure["k"]] == ["damage", "repaired", "fail", "within its error of a limit", "pass"]
shapes = {(s[0], round(s[1], 3), round(s[2], 3), int(s[4])) for s in figure["p"][0]["i"]}
mat = lambda kind, n: (kind, round((n - 1) * 2 / 7, 3), round(n * 2 / 7, 3), 1)
assert {s for s in shapes if s[3] == 1} == {mat("passed", 1), mat("passed", 2), mat("closed", 3), mat("closed", 4), mat("failed", 5), mat("passed", 6), mat("failed", 7)}, shapes
assert {s for s in shapes if s[3] == 2} == {("damaged", 85, 85.286, 2), ("repaired", 88, 93, 2)}, shapes
assert {(k, round((a + b) / 2, 2)) for k, a, b, row in shapes if row == 0} == {("passed", 30), ("failed", 40), ("passed", 40), ("failed", 50), ("closed", 60)}, shapes
PY
    [ $? = 0 ] && cp "$tmp/none.db" "$tmp/c.db" && $matrig --quiet record "$tmp/c.db" conditions 1 drive=coast >/dev/null && $matrig --json report "$tmp/c.db" -o "$tmp/c.html" >/dev/null && ! grep 'damage and acceptance' "$tmp/c.html"
}
units_of_all() { # every number but a count has a unit; rounded when it is converted; large errors without exponent; one spelling on the page
    $matrig --json record --kinds | python3 -c '
import json, re, sys
bare = {f for fields in json.load(sys.stdin).values() for f, text in fields.items() if re.search(r": [-0-9.e+]+ to [-0-9.e+]+($|[,;])", text)}
assert bare == {"pieces", "repaired"}, bare' || return 1
    cp "$tmp/none.db" "$tmp/u.db"
    u() { $matrig --quiet record "$tmp/u.db" "$@"; }
    u joint 3 stiffness_lb_ft=12000+-300 >/dev/null && u joint | grep ' 12000 +- 300 ' && u mat 3 weight_lb=200kg >/dev/null && u mat -o "$tmp/u.csv" && grep ',440.924524,' "$tmp/u.csv" || return 1
    u conditions 1 planned_braking_ft_s2=4 tire_contact_in2=3.2 >/dev/null && $matrig --quiet report "$tmp/u.db" -o "$tmp/u.html" >/dev/null && grep -q 'planned braking (ft/s²)' "$tmp/u.html" && ! grep -o '>[^<>{}]*ft/s2[^<>{}]*<' "$tmp/u.html"
}
in_si() { $matrig --si record "$db" mat 2>&1 | tee "$tmp/said" | grep 'joint strength (N/m)' && grep "$(awk 'BEGIN {printf "%.6g", 12.8 * 4.4482216152605 / 0.0254}')" "$tmp/said" && $matrig --si record "$db" conditions | grep -F "23 +- 1 "; }
bundled_repairs() { # RUN 2 is RUN 1 of the bundle, so what RUN 3 begins with is RUN 2
    cp "$tmp/none.db" "$tmp/b.db"
    $matrig --quiet record "$tmp/b.db" damage 2 station_ft=60 what=weld repair=relaid repaired=3 >/dev/null && $matrig --quiet bundle "$tmp/b.db" 2 -o "$tmp/b1.db" && [ "$(field "$tmp/b1.db" 1 "['fields']['repaired']")" = 2.0 ]
}
with_a_bundle() { $matrig --quiet bundle "$db" 2 -o "$tmp/one.db" && $matrig record "$tmp/one.db" >"$tmp/said" && grep 'dislocated' "$tmp/said" && grep '12.8 (was 11.5)' "$tmp/said" && ! grep '^ *1 *1 *coast' "$tmp/said"; }
once() { # a field given twice, a record or a sheet entered twice; the second piece of damage has a place of its own
    cp "$tmp/none.db" "$tmp/o.db"
    printf 'mat,joint_lb_in\n20,12.5\n' >"$tmp/once.csv"
    fails_with 2 'two values for joint_lb_in' $matrig record "$tmp/o.db" mat 20 joint_lb_in=12.5 joint_lb_in=13 && $matrig --quiet record "$tmp/o.db" mat --csv "$tmp/once.csv" >/dev/null &&
        fails_with 2 'once.csv, line 2: recorded already: record 1 of mat;' $matrig record "$tmp/o.db" mat --csv "$tmp/once.csv" && fails_with 2 'recorded already: record 1 of mat' $matrig record "$tmp/o.db" mat 20 joint_lb_in=12.5 &&
        $matrig --quiet record "$tmp/o.db" damage 1 what=rivet station_ft=88 >/dev/null && fails_with 2 'recorded already: record 2 of damage' $matrig record "$tmp/o.db" damage 1 what=rivet station_ft=88 && $matrig --quiet record "$tmp/o.db" damage 1 what=rivet station_ft=89 >/dev/null &&
        $matrig --quiet record "$tmp/o.db" --correct 1 joint_lb_in=13 --reason x >/dev/null && fails_with 2 'recorded already: record 4 of mat; .* --correct 4 ' $matrig record "$tmp/o.db" mat 20 joint_lb_in=12.5 &&
        $matrig --quiet record "$tmp/o.db" --withdraw 4 --reason x >/dev/null && $matrig --quiet record "$tmp/o.db" mat 20 joint_lb_in=12.5 >/dev/null
}
measured_again() { # a third reading may equal the first; a sheet with all three goes out and in
    cp "$tmp/none.db" "$tmp/o.db"
    o() { $matrig --quiet record "$tmp/o.db" "$@"; }
    o mat 20 joint_lb_in=12.5 >/dev/null && o mat 20 joint_lb_in=13 >/dev/null && o mat 20 joint_lb_in=12.5 >/dev/null && fails_with 2 'recorded already: record 3 of mat' $matrig record "$tmp/o.db" mat 20 joint_lb_in=12.5 || return 1
    o damage 1 what=weld station_ft=88 pieces=2 >/dev/null && o damage 1 what=weld station_ft=88 pieces=3 >/dev/null && o damage 1 what=rivet station_ft=88 >/dev/null && o damage 1 what=weld station_ft=88 pieces=2 >/dev/null &&
        fails_with 2 'recorded already: record 7 of damage' $matrig record "$tmp/o.db" damage 1 what=weld station_ft=88 pieces=2 && fails_with 2 'recorded already: record 6 of damage' $matrig record "$tmp/o.db" damage 1 what=rivet station_ft=88 || return 1
    o mat -o "$tmp/again.csv" && $matrig --quiet record "$tmp/again.db" mat --csv "$tmp/again.csv" >/dev/null && fails_with 2 'recorded already: record 3 of mat' $matrig record "$tmp/again.db" mat 20 joint_lb_in=12.5 || return 1
    printf 'mat,joint_lb_in\n21,12.5\n22,12.5\n21,12.5\n' >"$tmp/again.csv" && fails_with 2 'again.csv, line 4: recorded already' $matrig record "$tmp/o.db" mat --csv "$tmp/again.csv"
}
large_sheet() { # in proportion to its lines: 0.3 s of processor; 20 s when all records were loaded again for each line
    (echo mat,joint_lb_in && seq -f '%.0f' 3000 | awk '{print $1 % 420 + 1 "," 12 + $1 / 1000}') >"$tmp/large.csv"
    (ulimit -t 6 && $matrig --quiet record "$tmp/large.db" mat --csv "$tmp/large.csv" | grep '^records added *3000$') && $matrig --quiet record "$tmp/large.db" mat -o "$tmp/out.csv" && [ "$(grep -c ^ "$tmp/out.csv")" = 3001 ]
}
rules() { # each sentence names what is wrong
    cp "$tmp/none.db" "$tmp/o.db"
    while IFS='|' read -r expected words; do
        eval "set -- $words"
        fails_with 2 "$expected" $matrig record "$tmp/o.db" "$@" || return 1
    done <<'T'
repaired is the first RUN after the repair|damage 2 station_ft=88 what=weld repair=relaid repaired=2
repaired is beyond the next RUN|damage 1 station_ft=88 what=weld repair=relaid repaired=99999
not a whole number: 2.5 for repaired|damage 1 station_ft=88 what=weld repair=relaid repaired=2.5
repaired needs the field repair|damage 1 station_ft=88 what=weld repaired=2
a repair needs station_ft|damage 1 what=weld repair=relaid
shares of the axles do not sum to 100|conditions 1 front_axle_percent=60 middle_axle_percent=60
shares of the axles do not sum to 100|conditions 1 front_axle_percent=30 middle_axle_percent=30 rear_axle_percent=30
not a temperature: .C. for temperature_f|conditions 1 temperature_f=C
not a standard error: '' for temperature_f|conditions 1 temperature_f='24 C+-'
not a temperature: .24 degCs. for|conditions 1 temperature_f='24 degCs'
not a list of marks|picture 1 height_ft='2 ft: 100,300 500,300 200,240 px'
no field: --correct N needs|--correct 1 --reason x
unexpected PLACE|mat 12 -o $tmp/no.csv
no kind|12 -o $tmp/no.csv
unexpected PLACE|damage 2 --csv $tmp/once.csv
no such landing: RUN 9|conditions 9
not a standard error: '-0.01' for joint_lb_in; give a number of 0 or more in lb/in, such as 12.5.-0.4|mat 9 joint_lb_in=12+--0.01
not a standard error: 'nan' for joint_lb_in|mat 9 joint_lb_in=12+-nan
not a standard error: ' 10%' for joint_lb_in|mat 9 'joint_lb_in=12 +- 10%'
not a standard error: '' for slack_in|mat 9 slack_in=0.03±
negative number: '-5' of record; places are 0 or more, and a value needs its name: NAME=-5|subgrade -5
no place: a record of mat needs the number of the mat|mat joint_lb_in=12
not a number: 'twelve' for mat|mat twelve joint_lb_in=12
unexpected argument: '.-' of record; quote a FIELD=VALUE that has blanks|mat 9 joint_lb_in=12 +- 0.4
out of range: 421 for mat; allowed: 1 to 420|mat 421 joint_lb_in=12
out of range: 0 for joint|joint 0 stop_deg=3
out of range: 130 for station_ft; allowed: 0 to 120 ft|subgrade 130 cbr_percent=12
out of range: 9 for left_of_center_ft; allowed: -7 to 7 ft|conditions 1 left_of_center_ft=9
out of range: 66 for width_ft; allowed: 0 to 14 ft|damage 1 what=weld width_ft=66
out of range: 121 for station_ft|damage 1 station_ft=121
no value|mat 5 joint_lb_in=
wrong record of damage: what is missing; give what=KIND|damage 1 station_ft=88
wrong record of damage: what is missing|damage 1 note=bent
one line of at most|damage 1 what=weld note=$'two\nlines'
the value of note .* not only blanks|damage 1 what=weld note='  '
the value of note|damage 1 what=weld note=$'\e[31mred'
the value of note|damage 1 what=weld note=$'\xc2\x9b31mred'
the value of note|damage 1 what=weld note=$'M\xfcller'
the value of --who|damage 1 what=weld --who $'M\xfcller'
the value of --who|damage 1 what=weld --who ''
the value of --who; give one line of at most 39|damage 1 what=weld --who 1234567890123456789012345678901234567890
give one line of UTF-8 for --reason|--withdraw 1 --reason $'M\xfcller'
T
    # a note that another program wrote does not reach the terminal with its codes
    cp "$tmp/o.db" "$tmp/n.db" && $matrig --quiet record "$tmp/n.db" damage 1 what=rivet note=x >/dev/null && sqlite3 "$tmp/n.db" "insert into records (made_us, kind, landing, fields) values (1, 'damage', 1, '{\"note\": \"\u001b[31mred\"}')" &&
        $matrig record "$tmp/n.db" damage | grep ' \[31mred' && ! $matrig record "$tmp/n.db" damage | grep $'\e' || return 1
    $matrig --quiet record "$tmp/o.db" conditions 1 front_axle_percent=33.3 middle_axle_percent=33.3 rear_axle_percent=33.3 >/dev/null && $matrig --quiet record "$tmp/o.db" damage 1 station_ft=88 what=weld repair=relaid repaired=2 >/dev/null
}
kept_values() { # FIELD= leaves a kept value out; a corrected old record is not the newest
    cp "$tmp/none.db" "$tmp/k.db"
    k() { $matrig --quiet record "$tmp/k.db" "$@"; }
    k conditions 1 drive=coast tire_psi='5+-0.2' >/dev/null && k conditions 2 tire_psi= >"$tmp/said" && ! grep tire_psi "$tmp/said" && [ "$(field "$tmp/k.db" 2 "['fields']")" = "{'drive': 'coast'}" ] || return 1
    k --correct 2 tire_psi=6 --reason x >/dev/null && [ "$(field "$tmp/k.db" 3 "['fields']")" = "{'drive': 'coast', 'tire_psi': 6.0}" ] || return 1
    k subgrade 10 fill_in=24 cbr_percent=20 >/dev/null && k subgrade 20 fill_in=30 cbr_percent=21 >/dev/null && k --correct 4 fill_in=26 --reason x >/dev/null && k subgrade 30 cbr_percent=22 >/dev/null &&
        [ "$(field "$tmp/k.db" 7 "['fields']['fill_in']")" = 30.0 ]
}
names_the_limit() { record mat 30 joint_lb_in=11 weight_lb=0.45 >"$tmp/said" && grep '^ *[0-9]* *30  fail *11 (below 12)  *0.45 ' "$tmp/said" && grep '^Limit of joint strength: report 2.5: ' "$tmp/said" && ! grep 'Limit of weight' "$tmp/said" &&
    record mat 31 slack_in=0.04 weight_lb=0.47+-0.01 >"$tmp/said" && grep '^ *[0-9]* *31  fail *0.04 (above 0.036)  *0.47 +- 0.01 (limit 0.4665) ' "$tmp/said" && $matrig --si record "$db" mat 2>&1 | grep '1.016 (above 0.9144)'; }
headers() { # columns and their separator
    printf 'mat joint_lb_in\n20 12.5\n' >"$tmp/h.csv"
    fails_with 2 'h.csv, line 1: unknown field: .mat joint_lb_in. .*the first line names the columns' $matrig record "$db" mat --csv "$tmp/h.csv" || return 1
    printf 'joint_lb_in,slack_in\n12.5,0.03\n' >"$tmp/h.csv"
    fails_with 4 'h.csv, line 1: no column mat; add it' $matrig record "$db" mat --csv "$tmp/h.csv" || return 1
    printf 'MAT,slack_in,slack_in\n20,0.03,0.03\n' >"$tmp/h.csv"
    fails_with 2 'h.csv, line 1: two values for slack_in' $matrig record "$db" mat --csv "$tmp/h.csv" || return 1
    cp "$tmp/none.db" "$tmp/h.db"
    printf 'RUN,drive\n1,coast\n' >"$tmp/h.csv"
    $matrig --quiet record "$tmp/h.db" conditions --csv "$tmp/h.csv" >/dev/null
}
from_a_spreadsheet() { # byte order mark, semicolons or tabs, CRLF, empty columns and lines; a workbook is named
    cp "$tmp/none.db" "$tmp/h.db"
    printf '\xef\xbb\xbfrun;what;station_ft;note;;\r\n1;weld;88;"a;b, c";;\r\n;;;;;\r\n1;rivet;89;;;\r\n' >"$tmp/h.csv"
    $matrig --quiet record "$tmp/h.db" damage --csv "$tmp/h.csv" >/dev/null && [ "$(field "$tmp/h.db" 1 "['fields']")" = "{'note': 'a;b, c', 'station_ft': 88.0, 'what': 'weld'}" ] && [ "$(sqlite3 "$tmp/h.db" 'select count(*) from records')" = 2 ] || return 1
    printf 'run\twhat\tstation_ft\n1\tweld\t90\n' >"$tmp/h.csv" && $matrig --quiet record "$tmp/h.db" damage --csv "$tmp/h.csv" >/dev/null && [ "$(field "$tmp/h.db" 3 "['fields']['station_ft']")" = 90.0 ] || return 1
    printf 'run;what;station_ft\n1;weld;90,5\n' >"$tmp/h.csv" && fails_with 2 "line 2: a comma in a number: '90,5' for station_ft; write a point: 90.5" $matrig record "$tmp/h.db" damage --csv "$tmp/h.csv" &&
        printf 'PK\3\4 workbook' >"$tmp/h.csv" && fails_with 4 'not a sheet of records: .*h.csv' $matrig record "$tmp/h.db" damage --csv "$tmp/h.csv"
}
day() { printf "$1" | timeout 600 $matrig day "$2" 2>&1 >"$tmp/said.raw"; tr '\r' '\n' <"$tmp/said.raw" >"$tmp/said"; }
day_asks_for_what_is_used() { # once a landing, with the last values; Enter keeps them
    cp "$tmp/none.db" "$tmp/d.db"
    day '1\njk\n\n\n\nq\n' "$tmp/d.db" && ! grep 'run conditions\|damage' "$tmp/said" || { cat "$tmp/said"; return 1; }
    $matrig --quiet record "$tmp/d.db" conditions 1 drive=coast tire_psi=5 end_weight_lb=200 >/dev/null && $matrig --quiet record "$tmp/d.db" damage 1 station_ft=12 what=rivet >/dev/null || return 1
    #     look  operator weight waves | coast kept, release height, plywood x 2, tires wrong and right, the rest | damage at 88, none more | note
    day '1\njk\n\n\n\n8.5\nno\n\n500\n5.5\n\n\n\n\n\n\n\n\n70\n\n\n\n\n\n88\nweld\n\n\n\n\n\n\n\nq\n' "$tmp/d.db"
    cat "$tmp/said"
    [ "$(grep -o 'run conditions: ' "$tmp/said" | wc -l)" = 20 ] && grep -q 'propulsion on the track, coast|truck (Enter: coast, -: no value): ' "$tmp/said" && grep -q 'tire pressure, psi (Enter: 5, -: no value): ' "$tmp/said" && ! grep 'after the repair' "$tmp/said" || return 1
    [ "$(sqlite3 "$tmp/d.db" "select fields from records where kind = 'conditions' order by id desc limit 1")" = '{"drive":"coast","end_weight_lb":200.0,"release_ft":8.5,"temperature_f":70.0,"tire_psi":5.5,"touchdown_plywood":"no"}' ] || { sqlite3 "$tmp/d.db" 'select * from records'; return 1; }
    [ "$(sqlite3 "$tmp/d.db" "select fields from records where kind = 'damage' order by id desc limit 1")" = '{"station_ft":88.0,"what":"weld"}' ] || return 1
    day '1\njk\n\n\n80\nweld\n\n\n\n\nopen\n\n81\nweld\n\n\n\n\nrelaid\n3\n\n\n\nq\n' "$tmp/d.db" && ! grep 'run conditions: ' "$tmp/said" || return 1 # RUN 2 has them
    [ "$(grep -o 'first RUN after the repair' "$tmp/said" | wc -l)" = 1 ] && [ "$(sqlite3 "$tmp/d.db" "select fields ->> 'repaired' from records order by id desc limit 1")" = 3.0 ]
}
answers_stay() { # before q and before the end of input; nothing is kept of questions that were not reached, nor after -
    cp "$tmp/none.db" "$tmp/q.db"
    $matrig --quiet record "$tmp/q.db" conditions 1 drive=coast tire_psi=5 crew=abc >/dev/null
    day '1\njk\n\n\n\n9\nq\nq\nq\n' "$tmp/q.db" && [ "$(field "$tmp/q.db" 2 "['fields']")" = "{'drive': 'coast', 'release_ft': 9.0}" ] || { cat "$tmp/said"; return 1; }
    grep -q 'q ends the questions' "$tmp/said" && $matrig --quiet record "$tmp/q.db" --withdraw 2 --reason again >/dev/null
    day '1\n\n\n\n\n8' "$tmp/q.db" && [ "$(field "$tmp/q.db" 4 "['fields']")" = "{'drive': 'coast', 'release_ft': 8.0}" ] || { cat "$tmp/said"; return 1; }
    $matrig --quiet record "$tmp/q.db" --withdraw 4 --reason again >/dev/null
    day '1\n\n\n\n-\n\n\n\n6\nq\n' "$tmp/q.db" && [ "$(field "$tmp/q.db" 6 "['fields']")" = "{'tire_psi': 6.0}" ] || { cat "$tmp/said"; return 1; }
    $matrig --quiet record "$tmp/q.db" --withdraw 6 --reason again >/dev/null
    day '1\n\n\n\nq\n' "$tmp/q.db" && [ "$(sqlite3 "$tmp/q.db" 'select count(*) from records')" = 7 ]
}
asked_again() { # shares of 110 % are refused; the third is answered again, the rest stays
    cp "$tmp/none.db" "$tmp/a.db"
    $matrig --quiet record "$tmp/a.db" conditions 1 drive=coast >/dev/null
    day '1\njk\n\n\ntruck\n\n\n\n5\n\n\n\n30\n40\n40\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n30\nq\nq\nq\n' "$tmp/a.db"
    [ "$(field "$tmp/a.db" 2 "['fields']")" = "{'drive': 'truck', 'front_axle_percent': 30.0, 'middle_axle_percent': 40.0, 'rear_axle_percent': 30.0, 'tire_psi': 5.0}" ] || { cat "$tmp/said"; return 1; }
}
from_the_landing_before() { # not from a later one that was recorded first
    cp "$tmp/none.db" "$tmp/e.db"
    $matrig --quiet record "$tmp/e.db" conditions 2 tire_psi=7 >/dev/null && $matrig record "$tmp/e.db" conditions 1 drive=coast >"$tmp/said" && ! grep 'tire_psi' "$tmp/said"
}
temperatures() {
    local i=0
    for t in '24 degC' $'24\tdegC\t' '24 deg C' '24 degc' '24 C' '24 °C' '297.15 K' '75.2' '75.2 F'; do
        cp "$tmp/none.db" "$tmp/t.db"
        $matrig --quiet record "$tmp/t.db" conditions 1 temperature_f="$t" >/dev/null && [ "$(sqlite3 "$tmp/t.db" "select round(fields ->> 'temperature_f', 9) from records")" = 75.2 ] || { echo "$t"; sqlite3 "$tmp/t.db" 'select fields from records'; return 1; }
    done
}
at_one_error() { # of the limit of 12 lb/in
    cp "$tmp/none.db" "$tmp/t.db"
    $matrig record "$tmp/t.db" mat 1 joint_lb_in=12.5+-0.5 | grep 'result *within its error of the limit$'
}
bad_sheets() {
    cp "$tmp/none.db" "$tmp/t.db"
    printf 'run,drive\n1,coast\n1,truck\n' >"$tmp/twice.csv"
    printf 'run,drive\n' >"$tmp/head.csv"
    fails_with 2 'twice.csv, line 3: recorded already' $matrig record "$tmp/t.db" conditions --csv "$tmp/twice.csv" && fails_with 4 'no records: .*head.csv' $matrig record "$tmp/t.db" conditions --csv "$tmp/head.csv" &&
        [ "$($matrig --json record "$tmp/t.db" | grep -c '"id"')" = 0 ]
}
worst_of_a_sheet() {
    printf 'mat,joint_lb_in\n10,9\n11,14\n' >"$tmp/sheet.csv"
    $matrig record "$tmp/e.db" mat --csv "$tmp/sheet.csv" | tee "$tmp/said" | grep 'worst result *fail$' || { cat "$tmp/said"; return 1; }
    # one sentence for one fault
    printf 'mat,joint_lb_in\n20,9\n21,12.1+-0.2\n22,10.5\n23,14\n' >"$tmp/sheet.csv"
    $matrig record "$tmp/e.db" mat --csv "$tmp/sheet.csv" >"$tmp/said" && cat "$tmp/said" && [ "$(grep -c '^Limit of joint strength: report 2.5' "$tmp/said")" = 1 ] && [ "$(grep -c Limit "$tmp/said")" = 1 ] &&
        grep '^1 pass, 2 fail, 1 within' "$tmp/said" && [ "$(grep -c '^ *[0-9]* *2[0-3] ' "$tmp/said")" = 4 ]
}
during_a_log() { # the table is made while another program writes to the campaign
    local board log status=1
    build/matrig-board --elf build/firmware/matrig.elf --serial "pty:$tmp/tty" --speed real --rig hil/rest.run 2>/dev/null &
    board=$!
    await test -e "$tmp/tty"
    $matrig --quiet log --serial "pty:$tmp/tty" --db "$tmp/l.db" </dev/null >"$tmp/log.txt" 2>&1 &
    log=$!
    await test -s "$tmp/l.db" && $matrig --quiet record "$tmp/l.db" mat 1 joint_lb_in=12.5 >/dev/null && $matrig --quiet record "$tmp/l.db" mat 2 joint_lb_in=12.5 >/dev/null && sleep 1 && kill -0 $log && status=0
    kill -INT $log
    wait $log || status=2
    kill $board
    cat "$tmp/log.txt"
    [ $status = 0 ] && [ "$(sqlite3 "$tmp/l.db" 'select count(*), (select ended_by from sessions) from records')" = '2|signal' ] && [ "$(sqlite3 "$tmp/l.db" 'pragma integrity_check')" = ok ]
}
slips() {
    fails_with 2 "unknown field: 'joint_lb' .*did you mean joint_lb_in" $matrig record "$db" mat 9 joint_lb=12 && fails_with 2 'did you mean mat\?' $matrig record "$db" matt 9 &&
        fails_with 2 'out of range: 500 for tire_psi; allowed: 1 to 200 psi' $matrig record "$db" conditions 1 tire_psi=500 && fails_with 2 'a length instead of a stress' $matrig record "$db" conditions 1 tire_psi=5in &&
        fails_with 2 'needs RUN' $matrig record "$db" conditions tire_psi=5 && fails_with 2 'not a whole number: 1.5 for mat' $matrig record "$db" mat 1.5 joint_lb_in=12 && fails_with 2 'needs no place' $matrig record "$db" launch 3 drop_ft=20 && fails_with 2 'RUN 9' $matrig record "$db" conditions 9 tire_psi=5 &&
        fails_with 2 'did you mean coast\?' $matrig record "$db" conditions 1 drive=cost && fails_with 2 'no kind' $matrig record "$db" 1 tire_psi=5 && fails_with 2 'more than one action' $matrig record "$db" --correct 1 --withdraw 2 &&
        fails_with 2 'recorded already: record 1 of conditions; .* --correct 1 ' $matrig record "$db" conditions 1 tire_psi=5 &&
        fails_with 2 'unexpected KIND' $matrig record "$db" conditions --correct 1 tire_psi=5 --reason x && fails_with 2 'one landing only' $matrig record "$db" --compare 1 &&
        fails_with 3 'no such database' $matrig record "$tmp/mistyped.db" conditions 1 tire_psi=5 && fails_with 3 'no such database' $matrig record "$tmp/mistyped.db" --withdraw 1 --reason x && [ ! -e "$tmp/mistyped.db" ]
}
kinds() { # every limit has its section of the report; no kind has more than 25 lines
    $matrig --json record --kinds >"$tmp/said" && python3 - "$tmp/said" <<'PY'
import json, re, sys
kinds = json.load(open(sys.argv[1]))
limits = {(k, f): text.split("; limit: ")[1] for k, fields in kinds.items() for f, text in fields.items() if "; limit: " in text}
assert set(limits) == {("subgrade", "cbr_percent"), ("mat", "joint_lb_in"), ("mat", "unhinge_deg"), ("mat", "slack_in"), ("mat", "weight_lb")}, limits
assert all(re.match(r"report (\d\.\d|table \d\.\d)", l) for l in limits.values())
assert len(kinds) == 7 and max(len(fields) for fields in kinds.values()) <= 23
PY
}

check "a campaign without records has nothing of them" none_cost_nothing
check "a record is added, with units" adds
check "fields left out keep the last value, and the answer lists them" keeps_the_last
check "a standard error stays with its value" errors_stay_with_their_value
check "pass, fail, within the error of a limit" passes_and_fails
check "the records of a mat or station are listed" of_a_place
check "acceptance has the worst first, and counts" worst_first
check "corrections keep their history" corrections_keep_their_history
check "withdrawn records stay, and do not count" withdrawn_ones_stay
check "what was different between two landings" what_was_different
check "CSV out and in is the same" csv_round_trip
check "a correction names later records with the old value" corrected_later
check "a picture has the digest of its file" pictures
check "a picture is found from any folder" pictures_from_anywhere
check "pictures in the report" pictures_in_the_report
check "heights from marks in a picture" heights
check "the report has them, escaped" in_the_report
check "a map of damage and acceptance" map_in_the_report
check "units of all numbers" units_of_all
check "in SI" in_si
check "passed on with a bundle" with_a_bundle
check "a bundle renumbers the RUN of a repair" bundled_repairs
check "a day asks only for kinds in use" day_asks_for_what_is_used
check "answers before q or the end of input are recorded" answers_stay
check "a refused record is asked for again with its answers" asked_again
check "values are kept from the landing before" from_the_landing_before
check "temperatures in every unit" temperatures
check "a value one error from its limit" at_one_error
check "sheets with two records of a landing, and with none" bad_sheets
check "a sheet has the worst result of its lines" worst_of_a_sheet
check "the first records while a log runs" during_a_log
check "nothing is recorded twice" once
check "a later reading may equal an earlier one" measured_again
check "a sheet of 3,000 lines" large_sheet
check "records that contradict themselves are refused" rules
check "kept values can be left out, and are the newest" kept_values
check "a value beyond its limit is named" names_the_limit
check "the header of a sheet is checked" headers
check "a sheet from a spreadsheet program" from_a_spreadsheet
check "slips are refused with the near word" slips
check "limits have their sources" kinds
lost_text() { # of a sheet: a carriage return or NUL inside a line, a column twice
    local rest='mat,joint_lb_in\r\n' n=$tmp/lost.csv
    printf "${rest}90,12.5\r91,9\r\n" >"$n" && fails_with 4 'line 2: a NUL or carriage return' $matrig --quiet record "$tmp/lost.db" mat --csv "$n" &&
        printf "${rest}90,12.5\r\n91,9\0,99\r\n" >"$n" && fails_with 4 'line 3: a NUL or carriage return' $matrig --quiet record "$tmp/lost.db" mat --csv "$n" &&
        printf 'mat,joint_lb_in,mat\n70,12.5,71\n' >"$n" && fails_with 4 'line 1: two columns mat' $matrig --quiet record "$tmp/lost.db" mat --csv "$n" &&
        ! sqlite3 "$tmp/lost.db" 'select 1 from records' 2>/dev/null | grep 1 && fails_with 2 'a place has no standard error' $matrig --quiet record "$tmp/lost.db" subgrade '41+-3' cbr_percent=12 || return 1
    fails_with 2 'the value of joint_lb_in is too long' $matrig --quiet record "$tmp/lost.db" mat 14 joint_lb_in="12.5$(printf %61s)kN/m" &&
        printf '\x37\x7f\x06\x82 of a write-ahead log' >"$tmp/lost-wal.csv" && fails_with 2 'would overwrite a database' $matrig --quiet record "$tmp/lost.db" mat -o "$tmp/lost-wal.csv"
}
other_picture() { # has not the height that was measured in the first one
    cp "$db" "$tmp/other.db" && printf '\xff\xd8\xff one' >"$tmp/one.jpg" && printf '\xff\xd8\xff two' >"$tmp/two.jpg" &&
        $matrig --quiet record "$tmp/other.db" picture 1 file="$tmp/one.jpg" height_ft='2 ft +- 0.02 ft: 100,300 500,300 200,240' >/dev/null || return 1
    local id
    id=$(sqlite3 "$tmp/other.db" 'select max(id) from records')
    $matrig record "$tmp/other.db" --correct "$id" file="$tmp/two.jpg" --reason 'wrong picture' | grep 'height was measured in the old picture' &&
        $matrig --json record "$tmp/other.db" | python3 -c 'import json, sys
r = json.load(sys.stdin)["records"]; print(r[-2:])
assert r[-2]["fields"]["height_ft"] == 0.3 and not any("height" in k for k in r[-1]["fields"])'
}
check "a sheet and a value lose no text" lost_text
check "a corrected picture has not the height of the old one" other_picture
finish
