#!/usr/bin/env bash
# matrig's manners: help with examples, man page, make install, NO_COLOR, --json. What commands take and what is said of
# it are the same rows (host/base/command.h; tests/host/test_command.c looks at them); here a user's words are asked.
. "$(dirname "$0")/tap.sh"
m=build/matrig
trap 'rm -rf "$root" "$away"' EXIT
root=$(mktemp -d /tmp/matrig.XXXXXX) away=$(mktemp -d /tmp/matrig.XXXXXX)
commands=$($m --json help | grep -o '"name":"[a-z]*"' | cut -d'"' -f4)

# --- help ---
check "the table is there" sh -c "[ $(wc -w <<<"$commands") -ge 25 ]"
examples() {
    local command
    for command in $commands; do
        $m $command --help >"$tmp/help" && grep -q "^Usage: matrig .* $command" "$tmp/help" &&
            sed -n '/Example:/,$p' "$tmp/help" | grep -q "matrig $command " || { echo "$command has no example"; return 1; }
        cmp "$tmp/help" <($m help $command) || return 1
    done
}
check "every command has help with an example" examples
overview() { for command in $commands; do $m --help | grep -q "^  $command " || return 1; done; }
check "and is listed" overview
check "a version" sh -c "$m --version | grep -Eq '^matrig [0-9]+\.[0-9]+\.[0-9]+\$' && $m --json --version | grep -q '^{\"version\":\"'"
check "help of what is not there" fails_with 2 "unknown command: 'lgo'" $m help lgo
check "an option of one letter with its value" fails_with 2 '-o works only with --cases' $m sweep none.json -ox
check "a flag takes none" fails_with 2 "unknown option: '-xy'" $m study none.json -xy
runs_examples() { # those that need no board and no campaign, as --help has them
    local line
    while read -r line; do
        eval "${line/#matrig/$m}" >"$tmp/o" 2>"$tmp/e" || { echo "$line"; cat "$tmp/e"; return 1; }
    done < <(for command in scale sim; do $m $command --help | sed -n 's/^Example: //p' | tr ';' '\n' | sed 's/^ //' | grep -v serial: |
        sed "s#-o [a-z]*#-o $tmp/out#; s#--csv [a-z]*#--csv $tmp/out#"; done)
}
check "examples run" runs_examples

# --- what is there stays as it was ---
cp host/scenes/model_runway.json "$tmp/scene.json"
cp "$tmp/scene.json" "$tmp/scene"
check "a history is not written over its scene" fails_with 2 'would overwrite the input' $m sim "$tmp/scene" --csv "$tmp/scene"
check "nor a scaled scene" fails_with 2 'would overwrite the input' $m scale "$tmp/scene.json" -o "$tmp/scene.json"
check "it is as it was" cmp "$tmp/scene.json" host/scenes/model_runway.json
no_survey() { # from a sheet that is none
    fails_with 4 'no column kind' $m --quiet survey "$tmp/s.db" --from "$tmp/scene.json" && [ -z "$($m survey "$tmp/s.db" --list)" ]
}
check "a sheet that cannot be read begins no survey" no_survey
check "a sheet with --json is one object" sh -c "$m --json survey '$tmp/s.db' --sheet '$tmp/sheet.csv' | python3 -m json.tool | grep -q places"
hostile() { # what a colleague's campaign may hold: nothing that a terminal takes for an order
    $m landing "$tmp/s.db" --series "$(printf 'a\033[31mb')" | cat -v | grep -q 'a \[31mb'
}
check "control characters are shown as spaces" hostile

# --- man page ---
man_lint() { groff -man -ww -b -Tutf8 -z build/matrig.1 build/matrig-*.1 2>"$tmp/lint" && [ ! -s "$tmp/lint" ]; }
check "groff has nothing to say about the man pages" man_lint
options_of() { $m $1 --help | sed -nE 's/^  (--?[a-z][a-z-]*)( .*)?$/\1/p' | sort -u; }
man_complete() { # a page for each command, with its options
    local command option
    for command in $commands; do
        [ $command != board ] || continue # its name is the emulated board's
        groff -man -Tascii -P-cbou build/matrig-$command.1 2>/dev/null >"$tmp/man.txt" && grep -q "matrig-$command - " "$tmp/man.txt" || { echo "no $command"; return 1; }
        for option in $(options_of $command); do
            grep -q -- "$option" "$tmp/man.txt" || [ $option = --help ] || { echo "$command $option"; return 1; }
        done
        grep -qw -- "$command" build/matrig.1 || { echo "matrig.1 lacks $command"; return 1; }
    done
}
check "there is a page for every command, with every option" man_complete

unknown() { # COMMAND... OPTION: not taken; one that nobody knows ends each before it does anything
    [[ $($m "$@" x --no-such-option 2>&1 </dev/null) == *"unknown option: '${*: -1}'"* ]]
}
taken() {
    local command option
    for command in $commands; do
        for option in $(options_of $command); do
            case $command$option in
            *--help) continue ;;
            board*) # one table for each of its words
                unknown board list $option && unknown board config $option && unknown board runway $option && unknown board arm $option && unknown board zero $option ;;
            *) unknown $command $option ;;
            esac && { echo "$command: $option"; return 1; }
        done
    done
    return 0
}
check "commands take what is offered" taken
# --- make install ---
export -n MAKEFLAGS MFLAGS MAKELEVEL
unset MAKEFLAGS MFLAGS
installs() { make -s install DESTDIR="$root" PREFIX=/usr; }
check "make install" installs
there() {
    local file
    for file in bin/matrig bin/matrig-board libexec/matrig/matrig-study share/matrig/matrig.elf share/matrig/scenes/model_runway.json share/man/man1/matrig.1 \
        share/doc/matrig/LICENSE share/doc/matrig/LICENSE.dygraphs share/doc/matrig/LICENCES.md; do
        [ -s "$root/usr/$file" ] || { echo "no $file"; return 1; }
    done
    grep -q GPL-2.0 "$root/usr/share/doc/matrig/LICENCES.md" && [ -x "$root/usr/bin/matrig" ] && ! find "$root" -path "*$PWD*" | grep . &&
        cmp build/firmware/matrig.elf "$root/usr/share/matrig/matrig.elf"
}
check "everything is where it belongs" there
records() {
    "$root/usr/bin/matrig-board" --elf "$root/usr/share/matrig/matrig.elf" --can "file:$away/can" --serial "file:$away/serial" --rig tests/runs/landing5.run &&
        "$root/usr/bin/matrig" --quiet log --can "file:$away/can" --serial "file:$away/serial" --db "$away/c.db"
}
check "installed programs record a landing" records
elsewhere() { # in a folder that has nothing to do with the sources: image, board and scene are found
    cd "$away" && "$root/usr/bin/matrig" --json replay c.db 1 >r.json && cat r.json && grep -q '^{.*}$' r.json &&
        "$root/usr/bin/matrig" compare c.db 1 >cmp.txt && cat cmp.txt && grep -q '^against  *model_runway.json' cmp.txt
}
studies() { # matrig-study is found, which is not on PATH, and by it the scene that came with matrig: the option is looked at after both
    fails_with 2 "unknown parameter: 'nonsense' for --fit" env PATH=/usr/bin:/bin \
        "$root/usr/bin/matrig" fit "$away/c.db" 1 --fit nonsense
}
check "and matrig-study begins to fit it" studies
check "and replay and compare it in another folder" sh -c "$(declare -f elsewhere); root=$root away=$away; elsewhere"
uninstalls() { make -s uninstall DESTDIR="$root" PREFIX=/usr && ! find "$root" -type f | grep .; }
check "make uninstall leaves no file" uninstalls

# --- colours ---
coloured() { TERM=xterm script -qec "$1 $m nonsense" /dev/null 2>&1 | grep -q "$(printf '\033')\\[3"; }
check "an error is coloured on a terminal" coloured ""
check "not with NO_COLOR" sh -c "! { $(declare -f coloured); m=$m; coloured NO_COLOR=1; }"
check "not in a file" sh -c "! $m nonsense 2>&1 | grep -q '$(printf '\033')'"

# --- one object with --json, whatever is asked ---
object() { # WORD...: JSON and nothing else
    $m --quiet --json "$@" >"$tmp/o.json"
    echo "exit $?" && [ "$(sqlite3 :memory: "select json_valid(readfile('$tmp/o.json'))")" = 1 ]
}
db=$away/c.db
printf '{"base": {"model": "chain", "N": 2, "F": 10, "tend": 0.001}, "vary": {"KL": [1e6, 2e6]}, "outputs": ["peak_u_ft"]}' >"$tmp/study.json"
printf '{"inertia": {"weight_lb": 160, "spacing_ft": 4, "cord_ft": 5, "period_s": 2}}' >"$tmp/readings.json"
for words in "show $db" "show $db 1" "landing $db" "landing $db 1" "compare $db 1" "report $db -o $tmp/r.html" \
    "export $db 1 --format csv -o $tmp/x.csv" "export --format dbc -o $tmp/x.dbc" "bundle $db 1 -o $tmp/bundle.db" "scale" "bands" \
    "sim host/scenes/friction_block.json" "error tests/sim_reference/scenes/report_frictionless.json" "sweep $tmp/study.json" "sweep $tmp/study.json --cases 1..2" "sweep $tmp/study.json --cases 1..2 -o $tmp/s.jsonl" "sweep $tmp/study.json --table $tmp/s.jsonl" \
    "params $tmp/readings.json" "survey $db --list" "live $db" help; do
    check "--json $(cut -d' ' -f1 <<<"$words")" object $words
done
finish
