#!/usr/bin/env bash
# Instruction budget by task (`make budget`): landing 5 on the emulated board, instructions by function, functions by source
# file. Cost = instructions x 1.5, divides and roots of the floating-point unit 14 cycles, of 168 MHz.
set -eu -o pipefail
cd "$(dirname "$0")/.."
elf=build/firmware/matrig.elf
out=build/budget
limit_percent=25
mkdir -p $out
build/matrig-board --elf $elf --rig tests/runs/landing5.run --can file:$out/can.log --serial file:$out/serial.bin --profile $out/profile.txt \
    2>$out/board.txt
seconds=$(sed -n 's/^matrig-board profile: [0-9]* instructions in \([0-9.]*\) s.*/\1/p' $out/profile.txt)
arm-none-eabi-nm -l $elf | awk '$2 ~ /^[tTwW]$/ && $4 { sub(/:[0-9]+$/, "", $4); print $3, $4 }' >$out/files.txt
awk -v seconds="$seconds" -v limit=$limit_percent '
    function task(file, name) {
        if (file !~ /(firmware|common)\//) return "library"
        if (file ~ /f407\/(scan|capture)\.c$/ || name == "mr_block_from_scans") return "sampling"
        if (file ~ /common\/(channels|measure)\.c$/) return "demodulation"
        if (file ~ /(blackbox|recorder|slowlog|boxlink|nor)\.c$/ || file ~ /common\/(blockpack|boxpage)\.c$/) return "storage"
        if (file ~ /(telemetry|can|uart)\.c$/ || file ~ /common\/(catalogue|framing|block|crc32)\.c$/) return "telemetry"
        if (file ~ /firmware\/landing\.c$/ || file ~ /common\/(gates|braking|passage|switches|staircase)\.c$/) return "speed"
        if (file ~ /common\/closure\.c$/) return "zones"
        if (file ~ /bands\.c$/) return "bands"
        return "the rest"
    }
    FNR == NR { file[$1] = $2; next }
    /^by kind/ { kinds = 1 }
    /^by function/ { kinds = 0; functions = 1; next }
    kinds && /floating point divide, root/ { divides = $1 }
    functions && $1 ~ /^[0-9]+$/ {
        name = $4; sub(/,$/, "", name); sub(/\..*/, "", name)
        total[task(file[name], name)] += $1; all += $1
    }
    END {
        n = split("sampling demodulation storage telemetry library speed zones bands", order, " ")
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
