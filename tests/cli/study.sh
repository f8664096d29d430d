#!/usr/bin/env bash
# matrig-study: matrig links neither GSL nor SUNDIALS, and starts matrig-study for what needs them: where it is looked for, what it is
# given, and that it is in matrig's place then: process, streams, signals, exit codes.
. "$(dirname "$0")/tap.sh"
m=$PWD/build/matrig
study=$PWD/build/matrig-study
scene=host/scenes/rstar_fig3_8_soft.json
here=$PWD/$tmp
nowhere() { PATH=/nowhere "$@"; }

# --- what is linked ---
links() { ldd "$1" | grep -o -e 'libgsl[a-z]*' -e 'libsundials_[a-z]*' | sort -u; }
free_of_both() { ! links "$1" | grep . && ldd "$1" | grep -q libsqlite3; }
has_both() { links "$study" | tee "$tmp/links" && grep -q '^libgsl$' "$tmp/links" && grep -q '^libsundials_cvode$' "$tmp/links"; }
check "matrig links neither GSL nor SUNDIALS" free_of_both "$m"
check "matrig-study links both" has_both
check "so this would be seen" eval '! free_of_both "$study"'

# --- matrig alone ---
mkdir -p "$here/alone/bin"
cp "$m" "$here/alone/bin/"
alone=$here/alone/bin/matrig
for words in "fit no.db" "sweep no.json" "study no.json" "error no.json" "--json --quiet fit x" "sim $scene --solver cvode"; do
    # shellcheck disable=SC2086
    check "without matrig-study: $words" fails_with 3 'cannot start matrig-study, which runs matrig (fit|sweep|study|error|sim): not found next to .*/alone/bin/matrig, .*; build it with make all' env PATH=/nowhere "$alone" $words
done
check "with PATH unset too" fails_with 3 'or on PATH' env -u PATH "$alone" fit x
solves_alone() { # SOLVER...: all but cvode
    local solver
    for solver in "$@"; do
        nowhere "$alone" --json sim "$scene" --solver "$solver" >"$tmp/alone.json" || return 1
        grep -q '"status":"ok"' "$tmp/alone.json" || return 1
    done
}
check "all other solvers, and auto, need no matrig-study" solves_alone auto event implicit rkgs
same_help() { # WORD...
    nowhere "$alone" "$@" >"$tmp/help.alone" && "$m" "$@" >"$tmp/help" && cmp "$tmp/help.alone" "$tmp/help" && [ -s "$tmp/help" ]
}
for words in "help" "fit --help" "sweep --help" "help study" "--json help error"; do
    # shellcheck disable=SC2086
    check "the same without matrig-study: matrig $words" same_help $words
done
check "a wrong word after it is told by matrig-study as by matrig" fails_with 2 '^matrig: unknown option: .--bogus. of fit; see matrig fit --help' "$m" fit --bogus

# --- where it is looked for ---
fake() { # FOLDER: a matrig-study that says where it is
    mkdir -p "$1" && printf '#!/bin/sh\necho "%s"\n' "$1" >"$1/matrig-study" && chmod +x "$1/matrig-study"
}
started_in() { # FOLDER PATH
    [ "$(env PATH="$2" "$alone" fit x)" = "$1" ]
}
fake "$here/on path"
fake "$here/later"
mkdir -p "$here/folder/matrig-study" "$here/not"
touch "$here/not/matrig-study"
check "on PATH, the first folder that has it; a folder or a plain file of its name is passed over" \
    started_in "$here/on path" "/nowhere:$here/folder:$here/not::$here/on path:$here/later"
in_the_working_folder() { ! (cd "$here/later" && env PATH=: "$alone" fit x); }
check "an empty folder on PATH is not the working folder" in_the_working_folder
fake "$here/alone/libexec/matrig"
check "before it libexec/matrig of the installation" started_in "$here/alone/libexec/matrig" "$here/later"
by_link() { ln -sf "$alone" "$here/later/linked" && [ "$(nowhere "$here/later/linked" fit x)" = "$here/alone/libexec/matrig" ]; }
check "also through a link to matrig" by_link
fake "$here/alone/bin"
check "before that beside matrig" started_in "$here/alone/bin" "$here/later"

# --- what it is given, and what it gives back ---
put() { # a matrig-study of these lines beside matrig
    printf '#!/bin/bash\n%s\n' "$1" >"$here/alone/bin/matrig-study"
}
words_arrive() {
    put 'printf "[%s]\n" "$@"'
    "$alone" --quiet --si --json fit 'a b' '' '*' --draws=60 $'two\nlines' >"$tmp/words" &&
        sed 1,3d "$tmp/words" >"$tmp/words.rest" && printf '[%s]\n' --json --quiet --si fit 'a b' '' '*' --draws=60 $'two\nlines' | cmp - "$tmp/words.rest" &&
        [ "$(sed -n 1p "$tmp/words")" = '[--started-by]' ] && [ "$(sed -n 3p "$tmp/words")" = "[$alone]" ]
}
check "every word as it was typed" words_arrive
codes() {
    local code
    for code in 0 1 2 3 4 5 77; do
        put "exit $code"
        "$alone" fit x
        [ $? = $code ] || return 1
    done
}
check "exit codes" codes
streams() {
    put 'read -r line; echo "got $line"; echo "error" >&2'
    [ "$(echo hello | "$alone" fit x 2>"$tmp/streams.err")" = "got hello" ] && [ "$(cat "$tmp/streams.err")" = error ]
}
check "standard input, output and error" streams
same_process() {
    put 'echo $$'
    bash -c 'echo $$; exec "$1" fit x' bash "$alone" >"$tmp/pids" && [ "$(wc -l <"$tmp/pids")" = 2 ] && [ "$(uniq "$tmp/pids" | wc -l)" = 1 ]
}
check "in matrig's process: what stops the one stops the other" same_process
by_signal() {
    put 'kill -TERM $$; sleep 10'
    "$alone" fit x
    [ $? = 143 ]
}
check "a death by signal is one" by_signal
not_a_program() {
    printf '\1\2\3' >"$here/alone/bin/matrig-study"
    fails_with 3 'cannot start matrig-study, which runs matrig fit: .*/alone/bin/matrig-study \(Exec format error\)' "$alone" fit x
}
check "one that cannot be run" not_a_program
rm "$here/alone/bin/matrig-study"
check "another version" fails_with 2 'matrig-study is version [0-9.]+, but /x/matrig is version 0\.0\.1; install both from one build' "$study" --started-by 0.0.1 /x/matrig fit x
check "what is no study" fails_with 2 "unknown study: 'log'" "$study" log
check "nothing" fails_with 2 "unknown study: 'matrig-study'" "$study"

# --- it does its work ---
by_cvode() {
    "$m" --json sim "$scene" --solver cvode >"$tmp/cvode.json" && "$m" --json sim "$scene" --solver event >"$tmp/event.json" && grep -q '"solver":"cvode"' "$tmp/cvode.json" &&
        python3 - "$tmp/cvode.json" "$tmp/event.json" <<'P'
import json, sys
a, b = (json.load(open(f)) for f in sys.argv[1:])
worst = max(abs(v - w["u_ft"][k]) for o, w in zip(a["outputs"], b["outputs"]) for k, v in o["u_ft"].items())
print(worst)
sys.exit(not worst < 1e-5 or not a["outputs"])
P
}
check "cvode's answer is event's within 1e-5 ft" by_cvode
installed() {
    local root=$PWD
    mkdir -p "$here/moved/bin" "$here/moved/libexec/matrig" && cp "$m" "$here/moved/bin/" && cp "$study" "$here/moved/libexec/matrig/" &&
        (cd / && nowhere "$here/moved/bin/matrig" --json sim "$root/$scene" --solver cvode) | grep -q '"solver":"cvode"'
}
check "from an installation that was moved" installed
finish
