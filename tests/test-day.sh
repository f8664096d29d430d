#!/usr/bin/env bash
# The test day of docs/howto/test-day.md, run as it stands there, in one shell that stops at the first line that fails; then what each step must have
# said and left. Figures of the landing come from the run file, those of calibration and surveys from the numbers that the page gives.
cd "$(dirname "$0")" && . ./cli/tap.sh || exit 99
cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." || exit 99
day=build/day
said=$tmp/said.txt
rm -rf $day
{
    # a line that cannot be run any more is found here, and by its number
    echo 'set -eE; trap "echo failed: \$BASH_COMMAND" ERR; trap "kill \$(jobs -p) 2>/dev/null || true" EXIT'
    sed -n '/^```sh day$/,/^```$/{/^```/!p}' docs/howto/test-day.md
    echo 'echo the day is over'
} >"$tmp/day.sh"

whole_day() { timeout 300 bash "$tmp/day.sh" >"$said" 2>&1 </dev/null && tail -n 1 "$said" | grep -qx 'the day is over'; }
says() { grep -Eq -- "$1" "$said" || { echo "nobody says: $1"; tail -n 30 "$said"; return 1; }; }
truth() { awk -v name="$1" '$1 == "truth" && $2 == name {print $3}' tests/runs/landing5.run; }
within() { # PATTERN-WITH-A-NUMBER PART TRUTH: the number that is said is the truth's, to that part of it
    sed -nE "s/$1/\1/p" "$said" | head -n 1 | awk -v part="$2" -v truth="$3" '{print $1, truth; found = 1; d = $1 / truth - 1} END {exit !(found && d < part && -d < part)}'
}
calibrated() { # a line through the points: 620.5 codes an inch, by hand from the five of them
    says '^8 fields changed, stored and read back: revision 1' && within '^gain +([0-9.]+) in per code.*' 0.001 "$(awk 'BEGIN {print 1 / 620.55}')"
}
warned() { # before the wheel is in the middle of the braked part, and as the report's page has it
    says '^  zone +warned [0-9.]+ s after touchdown' && says '^  outcome ' && grep -q 'warned' $day/quick.html
}
surveyed() { says '^loaded +42 segments$' && says '^different +0$'; }
surveyed_again() { # 21 segments of ten mats opened by 0.004 in each, 21 closed: half way it has moved 0.084 in, and at the end not at all
    sqlite3 $day/campaign.db 'select count(*) from gage_surveys where ended_us is not null' | grep -qx 2 && says '^in-plane bow since survey 1: at most [+-]0\.000 ' &&
        says '^ *60\.0 +[+-]0\.084 ' && says '^ *120\.0 +[+-]0\.000 '
}
page_has_it_all() {
    grep -q 'brakes grabbed late' $day/report.html && grep -q 'test day' $day/report.html && grep -q 'ET-17' $day/landing5.db && grep -q '<dt>ready</dt><dd>go' $day/report.html
}

check "every line of the day in docs/howto/test-day.md runs" whole_day
check "flashed: the board runs the image" says '^board +runs it'
check "calibrated: the board holds it" calibrated
check "surveyed: the board was given the slack" surveyed
check "ready: go" says '^GO, UNCALIBRATED after '
check "landed: touchdown speed" within '^  touchdown +([0-9.]+) .*' 0.002 "$(truth touchdown_speed_ft_s)"
check "landed: deceleration" within '^  deceleration +([0-9.]+) .*' 0.02 "$(truth mean_deceleration_ft_s2)"
check "warned of a zone" warned
check "quick look: the page is there without a command" test -s $day/quick.html
check "surveyed again: what has moved" surveyed_again
check "compared" says '^against +model_runway.json'
check "the report tells of all of it" page_has_it_all
check "bundled and replayed: 0 fields differ" says '^result +0 of [0-9]{6} fields differ'
finish
