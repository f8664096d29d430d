# Sourced, after cli/tap.sh, by a test that has said how a program is run that was built in another way:
#     other PROGRAM ARGUMENT...
# What matrig and matrig-board write is then the same as this build's, byte by byte: of a landing, of a campaign, of all scenes. of_landing_s: how
# much of the landing the other board plays, to the end if none is given.
. tests/board/played.sh
own() { "build/$1" "${@:2}"; }

boards_say_the_same() { # a landing on the emulated board; what is said first does not depend on how long it is
    local link
    played --elf build/firmware/matrig.elf --rig tests/runs/landing5.run --can "file:$tmp/own.can" --serial "file:$tmp/own.serial" 2>"$tmp/own.err" &&
        other matrig-board --elf build/firmware/matrig.elf --rig tests/runs/landing5.run --can "file:$tmp/other.can" --serial "file:$tmp/other.serial" \
            ${of_landing_s:+--for "$of_landing_s"} 2>"$tmp/other.err" || { cat "$tmp"/*.err; return 1; }
    for link in can serial; do
        if [ -n "${of_landing_s:-}" ]; then head -c "$(stat -c %s "$tmp/other.$link")" "$tmp/own.$link"; else cat "$tmp/own.$link"; fi >"$tmp/own.begun"
        [ "$(stat -c %s "$tmp/other.$link")" -gt 200000 ] && cmp "$tmp/own.begun" "$tmp/other.$link" || return 1
    done
}
faults_agree() { # where Unicorn is asked for more than its interface gives
    for side in own other; do
        $side matrig-board --elf build/tests/conformance/images/places.elf --serial "file:$tmp/$side.faults" --for 1 2>"$tmp/$side.err"
    done
    grep -q '^end$' "$tmp/own.faults" && cmp "$tmp/own.faults" "$tmp/other.faults"
}
logs_agree() { # what is stated of the landing; not when it came in
    for side in own other; do
        $side matrig --quiet --json log --can "file:$tmp/own.can" --serial "file:$tmp/own.serial" --db "$tmp/$side.db" >"$tmp/$side.json" || return 1
        python3 -c 'import json, sys; landings = json.load(sys.stdin)["landings"]
print(json.dumps(landings, indent=1, sort_keys=True))' <"$tmp/$side.json" >"$tmp/$side.landings"
    done
    [ -s "$tmp/own.landings" ] && cmp "$tmp/own.landings" "$tmp/other.landings"
}
campaigns_agree() { # one campaign, read by both
    for side in own other; do
        for format in csv mdf4 candump; do
            $side matrig export "$tmp/own.db" 1 --format $format -o "$tmp/$side.$format" 2>/dev/null || return 1
            cmp "$tmp/own.$format" "$tmp/$side.$format" || return 1
        done
    done
}
# What a command prints, without the time that it took.
print_of() { "$1" matrig "${@:2}" | sed 's/"[a-z_]*_ms":[0-9.e+-]*//g; s/in [0-9.]* m\?s\b//g'; } # SIDE ARGUMENT...
same_of() { # ARGUMENT...
    for side in own other; do
        print_of "$side" "$@" 2>"$tmp/$side.err" >"$tmp/$side.out"
    done
    [ -s "$tmp/own.out" ] && cmp "$tmp/own.out" "$tmp/other.out"
}
pages_agree() { # the date of making is set: the two are made at different minutes
    for side in own other; do
        SOURCE_DATE_EPOCH=0 $side matrig report "$tmp/own.db" -o "$tmp/page.html" 2>"$tmp/$side.err" || { cat "$tmp/$side.err"; return 1; }
        sed 's/[0-9.]* ms\b//g' "$tmp/page.html" >"$tmp/$side.html"
    done
    cmp "$tmp/own.html" "$tmp/other.html"
}
# The other's scenes take minutes under an emulator: they begin here, beside the checks before theirs.
simulate_scenes() { # SIDE
    local scene
    mkdir "$tmp/$1.scenes"
    for scene in host/scenes/*.json; do
        print_of "$1" --json sim "$scene" >"$tmp/$1.scenes/$(basename "$scene")" 2>/dev/null
    done
}
simulate_scenes other &
scenes=$!
scenes_agree() {
    wait $scenes && simulate_scenes own
    [ -z "$(find "$tmp/own.scenes" -size 0)" ] && diff -rq "$tmp/own.scenes" "$tmp/other.scenes"
}

check "the emulated board says the same, message by message" boards_say_the_same
check "faults are of the same instructions" faults_agree
check "matrig log states the same of the landing" logs_agree
check "a campaign is exported to the same CSV, MDF4 and candump" campaigns_agree
check "its landing reads the same" same_of --json landing "$tmp/own.db" 1
check "and compared the same" same_of --json compare "$tmp/own.db" 1 host/scenes/model_runway.json
check "the DBC is the same" same_of export --format dbc
check "help is the same" same_of help
check "every scene is simulated to the last digit" scenes_agree
check "the report is the same page" pages_agree
finish
