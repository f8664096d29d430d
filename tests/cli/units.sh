#!/usr/bin/env bash
# A number is read with its unit wherever a person writes one (units.txt): the same in another unit gives the same bytes, a unit of another kind
# is refused in one line.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
d=$tmp/d
mkdir -p "$d"
played --elf build/firmware/matrig.elf --can "file:$d/board.log" --serial "file:$d/board.bin" --rig tests/runs/landing5.run 2>/dev/null
build/matrig --quiet log --can "file:$d/board.log" --serial "file:$d/board.bin" --db "$d/campaign.db" >/dev/null
sockets=$(mktemp -d /tmp/matrig.XXXXXX)
trap 'rm -rf "$sockets"' EXIT
with_board --serial "unix:$sockets/serial" -- build/matrig board --serial "unix:$sockets/serial" config get -o "$d/rig.cfg" >/dev/null

cat >"$d/short.json" <<'J'
{"model": "chain", "N": 3, "L": 2, "F": 60, "KL": 1e5, "gap0": [0.01, 0.02, 0.01, 0.01], "grit": 3, "Vac": 20, "tend": 0.02, "f": 0.5}
J
cat >"$d/short_si.json" <<'J'
{"model": "chain", "N": 3, "L": "60.96 cm", "F": "266.89329691563 N", "KL": "1459390.29372064304 N/m",
 "gap0": ["3.048 mm", 0.02, "0.12 in", "0.3048 cm"], "grit": "3 lbf", "Vac": "6.096 m/s", "tend": "20 ms", "f": 0.5}
J
sed 's/"L": 2/"L": "3 lb"/' "$d/short.json" >"$d/wrong_L.json"
sed 's/"L": 2/"L": "3"/' "$d/short.json" >"$d/bare_L.json"
sed 's/"grit": 3/"grit": [1, "3 mm", 1, 1]/' "$d/short.json" >"$d/wrong_grit.json"
cat >"$d/small.json" <<'J'
{"name": "small", "scene": {"N": 30, "L": 2}, "seeds": 1, "engine": {"use": "chain"}, "runway": {"gap_in": [0.01, 0.05]}, "stations_ft": [30, 60],
 "landings": [{"touchdown_ft": 6, "speed_ft_s": 25, "deceleration_ft_s2": 9}]}
J
cat >"$d/small_si.json" <<'J'
{"name": "small", "scene": {"N": 30, "L": 2}, "seeds": 1, "engine": {"use": "chain"}, "runway": {"gap_in": ["0.254 mm", "1.27 mm"]}, "stations_ft": ["9.144 m", 60],
 "landings": [{"touchdown_ft": "72 in", "speed_ft_s": "7.62 m/s", "deceleration_ft_s2": "2.7432 m/s2"}]}
J
sed 's/\[0.01, 0.05\]/"3 lb"/' "$d/small.json" >"$d/wrong_study.json"
cat >"$d/readings.json" <<'J'
{"inertia": {"weight_lb": {"value": 140, "error": 0.5}, "spacing_ft": 2, "cord_ft": 4, "period_s": {"readings": [1.278, 1.281]}},
 "hinge": {"angle_deg": [11, 12, 13, 14], "moment_ft_lb": [1745, 3490, 5235, 6981]}}
J
cat >"$d/readings_si.json" <<'J'
{"inertia": {"weight_lb": {"value": "63.5029318 kg", "error": "0.5 lb"}, "spacing_ft": "609.6 mm", "cord_ft": "48 in", "period_s": {"readings": ["1278 ms", 1.281]}},
 "hinge": {"angle_deg": [11, "12 deg", 13, 14], "moment_ft_lb": [1745, "41880 in lb", 5235, 6981]}}
J
printf 'in,codes\n0,62.1\n0.5,372.4\n1,682.6\n0.5,372.3\n0,62.0\n' >"$d/in.csv"
printf 'mm,codes\n0,62.1\n12.7,372.4\n1 in,682.6\n1.27cm,372.3\n0 ft,62.0\n' >"$d/mixed.csv"
printf 'in,codes\n0,62.1\n0.5 lb,372.4\n' >"$d/wrong_points.csv"
echo '{"channels.*.rms_in": 10, "missing_channels": 8}' >"$d/limits.json"
echo '{"channels.*.rms_in": "254 mm", "missing_channels": 8}' >"$d/limits_si.json"
echo '{"channels.*.rms_in": "3 lb"}' >"$d/wrong_limits.json"
printf 'test,load (lb),force (lb),displacement (in)\na,100,3 mm,0\n' >"$d/wrong_push.csv"
echo '{"base": "short.json", "vary": {"L": {"from": 1, "to": 3, "count": 3}}, "outputs": ["status"]}' >"$d/sweep.json"
echo '{"base": "short.json", "vary": {"L": {"from": "304.8 mm", "to": "3 ft", "count": 3}}, "outputs": ["status"]}' >"$d/sweep_si.json"
sed 's/304.8 mm/3 lb/' "$d/sweep_si.json" >"$d/wrong_sweep.json"
printf 'mats 1\njoint 1 2 lb\njoint 2 0\n' >"$d/wrong.runway"
printf 'kind,line,place,reading_in,note\ngap,1,1,3 lb,\n' >"$d/wrong.csv"
sed 's/^site.mat_length_ft = .*/site.mat_length_ft = 533.4 mm/' "$d/rig.cfg" >"$d/wrong.cfg"

run() { eval "build/matrig --quiet $1"; }
# What the files of the two are called, in which unit they are, and how long it took, is no result.
shown() {
    run "$1" >"$tmp/shown" 2>"$tmp/err" || { cat "$tmp/err"; return 1; }
    sed -E 's/_si\././g; s/mixed\.csv/in.csv/g; s/"(run_ms|pass_ms|wall_s|cpu_s|seconds)":[0-9.e-]+//g; s/("error_estimate":\{"u_ft":[0-9.]{4})[0-9]*/\1/; /^(simulated in|unit of the values) /d' "$tmp/shown"
}
same() {
    shown "$1" >"$tmp/one" && shown "$2" >"$tmp/other" && [ -s "$tmp/one" ] && diff "$tmp/one" "$tmp/other"
}
refused() { eval "fails_with \"$1\" \"\$2\" build/matrig --quiet $3"; }
count=0
while IFS='|' read -r kind first second third; do
    case $kind in
    same) check "$second" same "$first" "$second" ;;
    refused) check "$third" refused "$first" "$second" "$third" ;;
    *) continue ;;
    esac
    count=$((count + 1))
done <tests/cli/units.txt
check "at least 47 of them" test $count -ge 47
finish
