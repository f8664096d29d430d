#!/usr/bin/env bash
# A gain in the wrong unit, or of swapped columns, on its whole way: points, configuration, board, ready. A transducer of the emulated rig
# gives 0.5 V/in of 3.3 V and 4096 codes, so 620.6 codes an inch: known values in any unit must come to 1 / 620.6 in per code.
. "$(dirname "$0")/tap.sh"
matrig=build/matrig
elf=build/firmware/matrig.elf
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT

# at_rest COMMAND...: against a board at rest
at_rest() { with_board --serial "unix:$sockets/serial" --rig hil/rest.run -- "$@"; }
config() { at_rest $matrig board --serial "unix:$sockets/serial" config "$@"; }
ready() {
    at_rest $matrig --quiet ready "$tmp/campaign.db" --serial "unix:$sockets/serial" "$@" >"$tmp/ready.txt" 2>&1
    local status=$?
    cat "$tmp/ready.txt"
    return $status
}
value() { awk -v name="$2 = " 'index($0, name) == 1 { sub(/^[^=]*= /, ""); sub(/  # .*/, ""); print }' "$1"; }
calibrate() { $matrig calibrate "$1" --points "$tmp/points.csv" --config "$tmp/rig.cfg" -o "$tmp/new.cfg" --force "${@:2}"; }

# gives CHANNEL INPUT PER-CODE OPTION...: the file of points, read so, gives this gain to a thousandth
gives() {
    calibrate "$1" "${@:4}" || return 1
    value "$tmp/new.cfg" "channel[$2].unit_per_code" | awk -v is="$3" '{d = $1 / is - 1; print $1, is; exit !(d < 1e-3 && d > -1e-3)}' &&
        $matrig board config check "$tmp/new.cfg"
}
refuses() { # CHANNEL EXIT PATTERN OPTION...: and nothing is written
    rm -f "$tmp/new.cfg"
    fails_with "$2" "$3" $matrig calibrate "$1" --points "$tmp/points.csv" --config "$tmp/rig.cfg" -o "$tmp/new.cfg" --force "${@:4}" && [ ! -e "$tmp/new.cfg" ]
}
per_in=$(awk 'BEGIN {print 1 / 620.55}')
per_lb=$(awk 'BEGIN {print 3.3 / 4096 / 0.005}')

a_configuration() { config get -o "$tmp/rig.cfg"; }
units_are_converted() {
    printf 'mm,codes\n0,62.1\n12.7,372.4\n25.4,682.6\n12.7,372.3\n0,62.0\n' >"$tmp/points.csv"
    gives d3 3 "$per_in" && gives d3 3 "$per_in" --table && gives d3 3 "$per_in" --known 0.05mm || return 1
    value "$tmp/new.cfg" 'channel[3].zero_error' | awk '{exit !($1 > 0.0019 && $1 < 0.0021)}' || return 1
    printf 'displacement [cm],counts\n0,62.1\n1.27,372.4\n2.54,682.6\n' >"$tmp/points.csv" && gives d3 3 "$per_in" || return 1
    printf 'm,codes\n0,62.1\n0.0127,372.4\n0.0254,682.6\n' >"$tmp/points.csv" && gives d3 3 "$per_in" || return 1
    printf 'value,codes\n0 mm,62.1\n0.5 in,372.4\n0.0254 m,682.6\n' >"$tmp/points.csv" && gives d3 3 "$per_in" || return 1
    # 40 lb are 177.93 N, 18.144 kg
    printf 'N,codes\n0,496.5\n177.93,744.7\n355.86,993.0\n' >"$tmp/points.csv" && gives t2 10 "$per_lb" || return 1
    printf 'load (kN),codes\n0,496.5\n0.17793,744.7\n0.35586,993.0\n' >"$tmp/points.csv" && gives t2 10 "$per_lb" || return 1
    printf 'kgf,codes\n0,496.5\n18.144,744.7\n36.287,993.0\n' >"$tmp/points.csv" && gives t2 10 "$per_lb"
}
columns_go_by_their_names() {
    printf 'codes,mm\n62.1,0\n372.4,12.7\n682.6,25.4\n' >"$tmp/points.csv" && gives d3 3 "$per_in"
}
without_a_unit_it_is_refused() {
    printf '0,62.1\n12.7,372.4\n25.4,682.6\n' >"$tmp/points.csv"
    refuses d3 4 'the first line has no column names: .*points.csv, line 1; name the columns: mm,codes' || return 1
    printf 'value,codes\n0,62.1\n12.7,372.4\n25.4,682.6\n' >"$tmp/points.csv" && refuses d3 4 'points.csv, line 2; ' || return 1
    printf 'lb,codes\n0,62.1\n12.7,372.4\n25.4,682.6\n' >"$tmp/points.csv"
    refuses d3 4 'the unit of the values does not belong to this channel: .*use in, mm, cm, m or ft for a transducer'
}
an_odd_name_is_refused() { # a unit that matrig does not know, or one that is scaled
    local name
    for name in daN kip 'load (daN)' 'tenths of lb' 'tenths (lb)' 'load (lb/10)' 'lb x10' 'lb (0.1)'; do
        printf '%s,codes\n0,496.5\n17.793,744.7\n35.586,993.0\n' "$name" >"$tmp/points.csv"
        refuses t2 4 'the first line has no column names' || return 1
    done
}
mistakes_are_refused() {
    printf 'in,codes\n0,62.1\n12.7,372.4\n25.4,682.6\n' >"$tmp/points.csv"
    refuses d3 1 'channel\[3\].unit_per_code is 0.0409.*: the value per code is larger than that of any sensor of the rig; .*the unit of the values may have been mm$' || return 1
    printf 'in,codes\n62.1,0\n372.4,0.5\n682.6,1\n' >"$tmp/points.csv"
    refuses d3 1 'is 620.*the columns may be swapped$' || return 1
    printf 'lb,codes\n0,496.5\n177.93,744.7\n355.86,993.0\n' >"$tmp/points.csv"
    refuses t2 1 'the unit of the values may have been N$' || return 1
    printf 'in,codes\n0,62.1\n0.5,3724\n1,6826\n' >"$tmp/points.csv"
    refuses d3 1 'code out of range: 3724 for d3, point 2' || return 1
    printf 'in,codes\n0,62.1\n1.27,372.4\n2.54,682.6\n' >"$tmp/points.csv" # cm: possible, but not what it was
    calibrate d3 2>"$tmp/err" && grep -q 'd3: gain 0.001611 -> 0.004093 in per code, a factor of 2.54, compared with' "$tmp/err" &&
        cp "$tmp/new.cfg" "$tmp/jump.cfg" && $matrig board config check "$tmp/jump.cfg"
}
a_slip_of_the_pen_is_refused() { # 628.6 for 682.6: the gain would be 9 % off; the others fit to 0.0003 in
    printf 'mm,codes\n0,62.1\n12.7,372.4\n25.4,628.6\n12.7,372.3\n0,62.0\n' >"$tmp/points.csv"
    refuses d3 1 'the points deviate from their fit by 0.029 in, which is 2.9 % of their span .limit: 1 %.: .*points.csv; without point 3 .1 in, 628.6 codes. the other points fit within 8.1e-05 in: .* --accept REASON$' &&
        refuses d3 1 'without point 3' --table && refuses d3 2 'a reason of one line' --accept "" || return 1
    calibrate d3 >"$tmp/out" 2>/dev/null
    grep 'worst$' "$tmp/out" && calibrate d3 --miss 5 && [ "$(head -n 1 "$tmp/new.cfg")" = '# d3: the deviation from the fit was accepted: --miss 5: the points deviate from their fit by 2.9 % of their span' ] && calibrate d3 --accept 'stop bent at 1 in' &&
        [ "$(head -n 1 "$tmp/new.cfg")" = '# d3: the deviation from the fit was accepted: stop bent at 1 in' ] && $matrig board config check "$tmp/new.cfg" || return 1
    goes_on() { $matrig calibrate "$1" --points "$tmp/points.csv" --config "$tmp/$2.cfg" -o "$tmp/$3.cfg" --force "${@:4}" >/dev/null && head -n 2 "$tmp/$3.cfg" | tr '\n' /; }
    [[ $(goes_on d4 new next --accept bent) == "# d4: the deviation from the fit was accepted: bent/# d3: the deviation from the fit was accepted: stop bent at 1 in/" &&
        $(goes_on d4 next last --miss 5) == "# d4: the deviation from the fit was accepted: --miss 5: "*"/# d3: the deviation from the fit was accepted: stop bent at 1 in/" ]] || return 1
    $matrig --json calibrate d3 --points "$tmp/points.csv" --config "$tmp/rig.cfg" 2>/dev/null | jq -e '.exit == 1 and .kind == "limit" and (.points | length) == 5' || return 1
    printf 'mm,codes\n0,62.1\n12.7,372.4\n25.4,628.6\n' >"$tmp/points.csv" # of three, any
    refuses d3 1 'no single point causes the deviation'
}
check_and_set_refuse_what_is_impossible() {
    sed -E 's/^(channel\[3\].unit_per_code = ).*/\10.0409309603/' "$tmp/rig.cfg" >"$tmp/mm.cfg"
    fails_with 1 'channel\[3\].unit_per_code is 0.0409.*mm.cfg:[0-9]+; the gain of a transducer must be .*; the unit of the values may have been mm$' $matrig board config check "$tmp/mm.cfg" &&
        fails_with 1 'the unit of the values may have been mm' $matrig board --serial "unix:$sockets/none" config set "$tmp/mm.cfg"
}
set_refuses_a_jump() {
    ! config set "$tmp/jump.cfg" 2>"$tmp/set.err" && cat "$tmp/set.err" && [ "$(wc -l <"$tmp/set.err")" = 1 ] &&
        grep -q 'd3: gain 0.001611 -> 0.004093 in per code, a factor of 2.54, compared with the board' "$tmp/set.err"
}
set_sends_it_with_force() { config set "$tmp/jump.cfg" --force | grep -q '^channel\[3\].unit_per_code: 0.00161.* -> 0.00409'; }
# Any change of the configuration since the last landing is no-go for ready, until it is said with --expect-config.
ready_compares_with_the_landing() { # RUN 1 of the board as built in
    timeout 600 build/matrig-board --elf $elf --serial "unix:$sockets/serial" --can "unix:$sockets/can" --rig tests/runs/landing5.run 2>"$tmp/board.err" &
    timeout 600 $matrig --quiet log --all --serial "unix:$sockets/serial" --can "unix:$sockets/can" --db "$tmp/campaign.db" >"$tmp/log.txt" 2>&1
    wait
    ready
    [ $? = 1 ] && grep -Eq '^NO-GO +configuration .*as in RUN 1' "$tmp/ready.txt" && ready --expect-config "$tmp/jump.cfg"
}

check "a configuration to begin with" a_configuration
check "values are converted from the unit that is written" units_are_converted
check "columns go by their names" columns_go_by_their_names
check "values without a unit are refused" without_a_unit_it_is_refused
check "nor is a name of a column that is not understood" an_odd_name_is_refused
check "mistakes of units and columns are refused, and named" mistakes_are_refused
check "a transposed digit is refused, and its point named; a reason takes it" a_slip_of_the_pen_is_refused
check "config check and config set refuse an impossible gain" check_and_set_refuse_what_is_impossible
check "config set refuses a jump" set_refuses_a_jump
check "and sends it with --force" set_sends_it_with_force
check "ready: another configuration than the landing's is no-go, but for --expect-config" ready_compares_with_the_landing
finish
