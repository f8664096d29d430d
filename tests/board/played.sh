# played: for shell tests, source it after tests/cli/tap.sh. The emulated board says the same bytes each time (tests/cli/two-process.sh), so a
# landing that several tests need is emulated once.
played_root=$PWD
played_kept_min=1440 # what no test has asked for in a day goes when something new comes

# played BOARD-OPTION...: as build/matrig-board with these options, of which --can and --serial are file:PATH or none. What the board said is
# made once for its program, image, options and the content of the files they name, kept in build/test-data/played, and copied.
played() {
    local can='' serial='' options=() word key kept status=0
    while [ $# -gt 0 ]; do
        case $1 in
        --can) can=${2#file:} && shift 2 ;;
        --serial) serial=${2#file:} && shift 2 ;;
        --nor | --flash | --vcd | --profile | --gdb) echo "played: $1 reads or writes a file besides: start build/matrig-board" >&2 && return 99 ;;
        *) options+=("$1") && shift ;;
        esac
    done
    key=$({
        for word in "$played_root/build/matrig-board" "${options[@]}"; do
            if [ -f "$word" ]; then sha256sum <"$word"; else printf '%s\n' "$word"; fi
        done
        stat -L -c '%n %s %Y' /usr/lib/*/libunicorn.so.2 2>/dev/null
    } | sha256sum | cut -c 1-24)
    kept=$played_root/build/test-data/played/$key
    mkdir -p "${kept%/*}"
    {
        flock 9 # who comes second waits until it is there
        if [ ! -d "$kept" ]; then
            find "${kept%/*}" -mindepth 1 -maxdepth 1 -mmin +$played_kept_min -exec rm -rf {} +
            rm -rf "$kept.new" && mkdir "$kept.new"
            "$played_root/build/matrig-board" --can "file:$kept.new/can" --serial "file:$kept.new/serial" "${options[@]}" 2>"$kept.new/said" 9>&-
            status=$?
            if [ $status -eq 0 ]; then mv "$kept.new" "$kept"; else cat "$kept.new/said" >&2; fi
        fi
    } 9>"$kept.lock"
    [ $status -eq 0 ] || return $status
    touch "$kept" "$kept.lock"
    { [ -z "$can" ] || [ "$can" = none ] || cp "$kept/can" "$can"; } &&
        { [ -z "$serial" ] || [ "$serial" = none ] || cp "$kept/serial" "$serial"; } && cat "$kept/said" >&2
}

# begun_landing DB: the campaign of the first 2.2 s of landing 5 over serial.
begun_landing() {
    played --elf "$played_root/build/firmware/matrig.elf" --serial "file:$tmp/begun" --rig "$played_root/tests/runs/landing5.run" --for 2.2 2>/dev/null &&
        "$played_root/build/matrig" --quiet log --serial "file:$tmp/begun" --db "$1" >/dev/null
}

# campaign_of DB LANDING...: a copy of the campaign of these landings of tests/runs in turn, each played whole and logged over both links, as
# the release says them; on standard output what matrig log said of the last one. Kept as what was played is.
campaign_of() {
    local db=$1 kept landing runs status=0
    shift
    mapfile -t runs < <(printf "$played_root/tests/runs/landing%s.run\n" "$@")
    kept=$played_root/build/test-data/played/$({
        printf '%s\n' "$@"
        cat "$played_root/build/matrig" "$played_root/build/matrig-board" "$played_root/build/firmware/matrig.elf" "${runs[@]}"
    } | sha256sum | cut -c 1-24)
    mkdir -p "${kept%/*}"
    {
        flock 8
        if [ ! -d "$kept" ]; then
            rm -rf "$kept.new" && mkdir "$kept.new"
            for landing in "${runs[@]}"; do
                played --elf "$played_root/build/firmware/matrig.elf" --can "file:$kept.new/can" --serial "file:$kept.new/serial" --rig "$landing" 2>/dev/null 8>&- &&
                    "$played_root/build/matrig" --quiet log --all --can "file:$kept.new/can" --serial "file:$kept.new/serial" --db "$kept.new/db" >"$kept.new/told" 8>&- ||
                    status=1
            done
            rm -f "$kept.new/can" "$kept.new/serial"
            [ $status -ne 0 ] || mv "$kept.new" "$kept"
        fi
    } 8>"$kept.lock"
    [ $status -eq 0 ] || return $status
    touch "$kept" "$kept.lock"
    cp "$kept/db" "$db" && cat "$kept/told"
}
