#!/usr/bin/env bash
# The examples of matrig COMMAND --help run, every line of them, in a folder with what they name: a campaign of five landings and files of
# these names. An emulated board stands in the place of serial:/dev/ttyUSB0 and can:can0. What takes minutes is given less of the same.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
root=$PWD place=$tmp/place
mkdir -p "$place" && for name in build host hil tests; do ln -s "$root/$name" "$place/$name"; done
cd "$place" || exit 99
PATH=$root/build:$PATH

examples_of() { # COMMAND: a line each
    matrig "$1" --help | awk '
        sub(/.*Example:/, "") {on = 1}
        on && /^ *matrig / {print; next}
        on && NF {on = 0}' | sed -e 's/^ *//' -e 's/; matrig /\nmatrig /g'
}
campaign() {
    campaign_of campaign.db 5 && matrig --quiet export campaign.db 1 --format candump -o can.log && python3 tests/report/grow.py campaign.db 5
}
files() { # of the names that examples have
    cp can.log candump-2026-05-04.log && matrig --quiet bundle campaign.db 3 -o landing5.db || return 1
    matrig --quiet survey campaign.db --edges none --sheet sheet.csv && awk -F, -v OFS=, 'NR > 1 {$4 = 33.8} {print}' sheet.csv >read.csv &&
        matrig --quiet survey campaign.db --edges none --from read.csv || return 1
    printf '{"channels.*.rms_in": 9}' >limits.json
    printf '{"inertia": {"weight_lb": 160, "spacing_ft": 4, "cord_ft": 5, "period_s": 2}}' >readings.json
    cp tests/push/one.csv push.csv
    printf 't,x\n' >lvdt.csv && awk 'BEGIN {for (i = 0; i < 400; i++) printf "%.4f,%.5f\n", i * 0.002, i * 0.0001}' >>lvdt.csv
    printf '{"header_lines": 1, "time": {"column": "t"}, "channels": [{"column": "x", "channel": "d2", "unit": "in", "error": 0.001}]}' >lvdt.json
    printf '{"base": {"model": "chain", "N": 20, "F": 10, "tend": 0.02}, "vary": {"KL": [1e6, 2e6]}, "outputs": ["peak_u_ft"]}' >small.json
}
board() { # OPTION...: on the links of the line
    local links=()
    [[ $line != *serial:/* ]] || links+=(--serial pty:tty)
    [[ $line != *can:can0* ]] || links+=(--can unix:can)
    timeout 320 matrig-board --elf build/firmware/matrig.elf --flash flash.bin --nor nor.bin "${links[@]}" "$@" 2>board.err &
}
# Runs $line of $command; `allowed`: exit codes that are answers, too.
run_line() {
    local allowed="0" expected= typed=/dev/null board= status
    case $command in
    log | live | board) line=${line//campaign.db/day.db} ;;& # a campaign of their own: the other one keeps its five landings
    live) [[ $line != "matrig live "* ]] || line="timeout 0.5 ${line/8474/0}" allowed="0 124" ;;&
    log | live) [[ $line != *serial:/* ]] || { board --speed max --rig tests/runs/landing5.run; board=$!; } ;;
    flash) board --boot0 && board=$! && line="$line --baud 460800" ;;
    ready) allowed="0 1" ;; # the board at rest is another than the one that landed
    compare) allowed="0 1" ;;
    survey) [[ $line == *--load* ]] || { typed=typed; printf '33.8\nq\n' >typed; cp campaign.db other.db; line=${line/campaign.db/other.db}; } ;;
    # a sensor at rest while three values are typed: by its noise a gain that no sensor of the rig has, or none; the command says which
    calibrate) typed=typed && printf '0\n0.5\n1\nq\n' >typed && allowed="1 5" && expected='a board would refuse this|do not change with the known values' ;;
    board) line=${line/read 3/read 1} ;; # what the examples of log left in the black box
    study) line=$(sed -E 's/ --seeds [0-9]+//' <<<"$line")' --seeds 1' ;;
    error) line=${line/host\/scenes\/consistent_fig3_7/tests\/sim_reference\/scenes\/report_frictionless} ;;
    sweep) line=${line//host\/sweep\/examples\/threshold.json/small.json} ;;
    fit) line="$line --draws 60" allowed="0 1" ;; # 1: the model cannot be
    advise) line="$line --members 64 --before 2" && allowed="0 1" ;; # 1: against
    esac
    case $command in
    log | live | flash) ;;
    *) [[ $line != *serial:/* && $line != *can:can0* ]] || { board --speed real --for 90 --rig hil/rest.run; board=$!; } ;;
    esac
    line=${line//serial:\/dev\/ttyUSB0/pty:tty} line=${line//can:can0/unix:can} line=${line/--live 8473/--live 0}
    echo "$line"
    timeout 300 bash -c "$line" <$typed >said 2>&1
    status=$?
    tail -n 8 said
    [ -z "$board" ] || { kill $board; wait $board; } 2>/dev/null
    { [ -z "$expected" ] || grep -Eq -- "$expected" said; } && [[ " $allowed " == *" $status "* ]] || { echo "exit $status"; return 1; }
}
lines_run() {
    local count=0
    while read -r line; do
        count=$((count + 1))
        run_line || return 1
    done < <(examples_of "$command")
    [ $count -ge 1 ]
}

check "a campaign of five landings" campaign
check "files of the names that examples have" files
# In the order of help: log and live leave landings in the black box for board.
for command in $(matrig --json help | grep -o '"name":"[a-z]*"' | cut -d'"' -f4); do
    [ "$command" != demo ] || continue # demo.sh plays it
    check "matrig $command" lines_run
done
finish
