#!/usr/bin/env bash
# The test by which the report chose the spacing of cleats (5.5): with every fifth row nothing lifts, and the farther apart they are
# beyond ten the more does. A third of the stored study.
. "$(dirname "$0")/tap.sh"
python3 - >"$tmp/study.json" <<'P'
import json
study = json.load(open("host/landing_series/spacing/study.json"))
study["base"] = json.load(open("host/landing_series/spacing/line.json"))
study["base"]["seeds"] = 8
study["vary"] = {"landings.0.apply.cleat_every": [5, 10, 20]}
print(json.dumps(study))
P
check "a line of mats is swept" build/matrig sweep "$tmp/study.json" --cases 1..99 -o "$tmp/s.jsonl"
lifted() { grep -o "cleat_every\":$1}.*" "$tmp/s.jsonl" | grep -o 'with_waves":[0-9]*' | cut -d: -f2; }
check "nothing lifts with a cleat in every fifth row" test "$(lifted 5)" = 0
echo "# lines of 8 that lift: $(lifted 5), $(lifted 10), $(lifted 20)"
check "some with every twentieth, and no fewer than with every tenth" test "$(lifted 20)" -ge "$(lifted 10)" -a "$(lifted 20)" -gt 0
# as the gear goes 2 ft/s for 16.6 ft and nothing brakes it
path() { build/matrig --json study host/landing_series/spacing/line.json --seeds 1 | grep -q '"stop_ft":17.1[0-9]*,"deceleration_ft_s2":0.0,'; }
check "it is towed to the end" path
two() { sed 's/"tow_lb": 24/"tow_lb": 24, "deceleration_ft_s2": 4/' host/landing_series/spacing/line.json >"$tmp/two.json"; }
check "towed and braked" eval "two && fails_with 4 'one of deceleration_ft_s2, profile and tow_lb' build/matrig study '$tmp/two.json'"
finish
