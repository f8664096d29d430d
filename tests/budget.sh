#!/usr/bin/env bash
# Instruction budget by task (`make budget`): landing 5 on the emulated board, told a plan and a chart before it, instructions by function, functions by source
# file. Cost = instructions x 1.5, divides and roots of the floating-point unit 14 cycles, of 168 MHz.
set -eu -o pipefail
cd "$(dirname "$0")/.."
elf=build/firmware/matrig.elf
out=build/budget
limit_percent=25
mkdir -p $out
rig=$out/landing5.run
python3 tests/board/chart.py tests/runs/landing5.run 0 35.5 0:7.0,1.5:7.0,1.7:8.5 >$rig
build/matrig-board --elf $elf --rig $rig --can file:$out/can.log --serial file:$out/serial.bin --profile $out/profile.txt \
    2>$out/board.txt
seconds=$(sed -n 's/^matrig-board profile: [0-9]* instructions in \([0-9.]*\) s.*/\1/p' $out/profile.txt)
arm-none-eabi-nm -l $elf | awk '$2 ~ /^[tTwW]$/ && $4 { sub(/:[0-9]+$/, "", $4); sub(/\..*/, "", $3); print $3, $4 }' >$out/files.txt
awk -v seconds="$seconds" -v limit=$limit_percent '
    function task(file, name) {
        if (file !~ /(firmware|common)\//) return "library"
        if (file ~ /f407\/(scan|capture)\.c$/ || name ~ /^(mr_block_from_(scans|some)|sum_columns|count_saturation)$/) return "sampling"
        if (file ~ /(common|firmware)\/(channels|measure|watch)\.c$/) return "demodulation"
        if (file ~ /(blackbox|recorder|slowlog|boxlink|nor)\.c$/ || file ~ /common\/(blockpack|boxpage)\.c$/) return "storage"
        if (file ~ /(telemetry|can|uart)\.c$/ || file ~ /common\/(catalogue|framing|block|crc32)\.c$/) return "telemetry"
        if (file ~ /common\/onboard\/landing\.c$/ || file ~ /common\/(gates|braking|passage|switches|staircase)\.c$/) return "speed"
        if (file ~ /common\/(predictor(_[a-z]+)?|matchain|zonescan|closure|runway|risk)\.c$/ || file ~ /(firmware\/(predict|runwaystore)|common\/onboard\/(predict_feed|release))\.c$/)
            return "prediction"
        if (file ~ /(bands|bandwatch|calibrate)\.c$/) return "bands"
        return "the rest"
    }
    FNR == NR { file[$1] = $2; next }
    /^by function/ { functions = 1; next }
    /floating point divide, root/ { divides = $1 }
    functions && $1 ~ /^[0-9]+$/ {
        name = $4; sub(/\..*/, "", name)
        total[task(file[name], name)] += $1; all += $1
    }
    END {
        n = split("sampling demodulation storage telemetry library speed prediction bands", order, " ")
        order[++n] = "the rest"
        printf "%-16s %14s %16s %10s\n", "task", "instructions/s", "cycles/s (x 1.5)", "of 168 MHz"
        for (i = 1; i <= n; i++) {
            rate = total[order[i]] / seconds
            printf "%-16s %14.0f %16.0f %9.2f%%\n", order[i], rate, 1.5 * rate, 1.5 * rate / 1.68e6
            if (i <= 5) taken += 1.5 * rate
        }
        extra = divides / seconds * 12.5
        printf "%-16s %14s %16.0f %9.2f%%\n", "divides, roots", "", extra, extra / 1.68e6
        printf "%-16s %14.0f %16.0f %9.2f%%\n", "all", all / seconds, 1.5 * all / seconds + extra, (1.5 * all / seconds + extra) / 1.68e6
        printf "sampling, demodulation, storage, telemetry, all of the library and of the divides: %.2f %% (limit %d %%)\n", (taken + extra) / 1.68e6, limit
        exit (taken + extra) / 1.68e6 > limit
    }' $out/files.txt $out/profile.txt | tee $out/budget.txt

# What is compiled for speed, and what should be: firmware/hot.txt.
awk '
    FILENAME ~ /hot.txt$/ { if (!/^#/) hot[$2] = $1; next }
    FILENAME ~ /files.txt$/ { sub(/^.*\/(firmware|common)\//, substr($2, match($2, /(firmware|common)\//), RLENGTH), $2)
        sub(/\.[ch]$/, "", $2); sub(/^firmware\/libc\/.*/, "firmware/libc/libc", $2); file[$1] = $2; next }
    /^by function/ { functions = 1; next }
    functions && $1 ~ /^[0-9]+$/ { name = $4; sub(/\..*/, "", name); total[file[name]] += $1; all += $1 }
    END {
        for (name in hot) { printf "%5.1f  %-24s of all instructions, compiled for speed (said: %.1f)\n", 100 * total[name] / all, name, hot[name] | "sort -rn"; sum += total[name] }
        close("sort -rn")
        printf "%5.1f  all of them\n", 100 * sum / all
        for (name in total) if (name ~ /^(common|firmware)\// && total[name] >= all / 100 && !(name in hot)) {
            printf "%5.1f  %-24s is compiled for size: give it a line in firmware/hot.txt\n", 100 * total[name] / all, name
            bad = 1
        }
        exit bad
    }' firmware/hot.txt $out/files.txt $out/profile.txt | tee $out/hot.txt

# The predictor over any second: profiles up to each quarter of a second, a second apart. All divides and roots are put down to it.
echo
echo "prediction through landing 5, by the second:"
from=1.25 to=7.0
until=$from
while awk -v a="$until" -v b=$to 'BEGIN { exit !(a <= b) }'; do
    build/matrig-board --elf $elf --rig $rig --for "$until" --profile $out/part.txt 2>/dev/null
    awk -v t="$until" '
        FNR == NR { file[$1] = $2; next }
        /floating point divide, root/ { divides = $1 }
        /^by function/ { functions = 1; next }
        functions && $1 ~ /^[0-9]+$/ {
            name = $4; sub(/\..*/, "", name)
            if (file[name] ~ /common\/(predictor(_[a-z]+)?|matchain|zonescan|closure|runway|risk)\.c$/ || file[name] ~ /(firmware\/predict|common\/onboard\/(predict_feed|release))\.c$/) n += $1
            all += $1
        }
        END { printf "%s %.0f %.0f %.0f\n", t, n, divides, all }' $out/files.txt $out/part.txt
    until=$(awk -v a="$until" 'BEGIN { print a + 0.25 }')
done >$out/parts.txt
most_percent=60
awk -v limit=$most_percent '
    { t[NR] = $1; n[NR] = $2; d[NR] = $3; all[NR] = $4 }
    END {
        for (i = 5; i <= NR; i++) {
            cost = (1.5 * (n[i] - n[i - 4]) + 12.5 * (d[i] - d[i - 4])) / 1.68e6
            sum = (1.5 * (all[i] - all[i - 4]) + 12.5 * (d[i] - d[i - 4])) / 1.68e6
            if (cost > worst) { worst = cost; at = t[i] }
            if (sum > worst_sum) worst_sum = sum
        }
        printf "  busiest second (to %.2f s): %.1f %% of 168 MHz (limit %d %%); the busiest second of all tasks together: %.1f %%\n", at, worst, limit, worst_sum
        exit !(worst > 0 && worst <= limit)
    }' $out/parts.txt | tee -a $out/budget.txt
# Wait states and the bus are not modelled: the same landing with more cycles for each instruction. What the board itself says of its load ten
# times a second, by the second.
echo
printf '%-16s %10s %15s %12s  %s\n' "cycles each" "mean load" "busiest second" "blocks lost" "predictor" | tee -a $out/budget.txt
for cpi in 1.0 1.5 2.0; do
    build/matrig-board --elf $elf --cpi $cpi --rig $rig --can file:$out/cpi.log --serial file:$out/cpi.bin 2>/dev/null
    rm -f $out/campaign.db
    build/matrig --quiet log --can file:$out/cpi.log --serial file:$out/cpi.bin --db $out/campaign.db >$out/cpi.txt || true
    python3 - $cpi "$(sed -n 's/.*(\(.*\) instead of every mat.*/\1/p' $out/cpi.txt)" $out/cpi.log <<'END' | tee -a $out/budget.txt
import struct, sys
said = [struct.unpack("<IHH", bytes.fromhex(line.split("#")[1])) for line in open(sys.argv[3]) if " 181#" in line]
load = [permille / 10 for _, permille, _ in said]
print("%-16s %9.1f%% %14.1f%% %12d  %s" % (sys.argv[1], sum(load) / len(load), max(sum(load[i:i + 10]) / 10 for i in range(len(load) - 9)),
                                            said[-1][2], sys.argv[2] or "every mat"))
END
done
echo "what it takes, and what it leaves alone:"
build/matrig --quiet log --can file:$out/can.log --serial file:$out/serial.bin --db $out/campaign.db >$out/log.txt || true
arm-none-eabi-nm -l -S --radix=d $elf | awk '/(common\/(predictor(_[a-z]+)?|matchain|zonescan|closure|runway|risk)|firmware\/(predict|runwaystore)|common\/onboard\/(predict_feed|release))\.c:/ { n += $2 }
    END { printf "  flash %d bytes\n", n }' | tee -a $out/budget.txt
gdb-multiarch -batch -ex 'printf "  RAM %d bytes: model and what is told %d, memory of the runway %d\n", sizeof(struct predict) + sizeof(struct runwaystore), sizeof(struct predict), sizeof(struct runwaystore)' $elf 2>/dev/null | tee -a $out/budget.txt
awk '/worst case/ { print "  stack of the firmware, " $0 }' build/firmware/stack.txt | tee -a $out/budget.txt
grep -E '^  data ' $out/log.txt | tee -a $out/budget.txt
grep -q '^  data .* 0 gaps, 0 faults$' $out/log.txt # no block lost, no task late
rm -f $out/campaign.db
