#!/usr/bin/env bash
# Each board's image (`make boards`): its size, its channels, and what landing 5 and the demo say on the emulated board of its name.
# usage: boards.sh BOARD...
set -eu -o pipefail
cd "$(dirname "$0")/.."
out=build/boards
rm -rf $out
mkdir -p $out
table=$out/boards.txt
printf '%-10s %7s %7s %7s %7s %6s %3s %3s %19s %17s %15s %13s %7s\n' board flash left RAM left image d g touchdown deceleration stop instructions demo >$table
printf '%-10s %7s %7s %7s %7s %6s %3s %3s %19s %17s %15s %13s %7s\n' '' bytes bytes bytes bytes crc '' '' ft/s ft/s2 ft 'of landing 5' s >>$table
for board in "$@"; do
    elf=build/firmware/matrig.elf
    [ "$board" = zg ] || elf=build/firmware/$board/matrig.elf
    build/matrig-board --elf $elf --rig tests/runs/landing5.run --can file:$out/$board.can --serial file:$out/$board.serial 2>$out/$board.err
    build/matrig --quiet log --can file:$out/$board.can --serial file:$out/$board.serial --db $out/$board.db >$out/$board.txt
    begin=$(date +%s.%N)
    build/matrig demo $out/$board --elf $elf >$out/$board.demo 2>&1
    end=$(date +%s.%N)
    value() { sed -n "s/^  $1 *\([-0-9.]* +- [0-9.]*\).*/\1/p" $out/$board.txt; }
    count() { sqlite3 $out/$board.db "select count(*) from channels where kind = $1"; }
    # program, behind the vectors; data and what is zeroed, with the stack
    { sed -n 's/^\([A-Z]*\) : .* LENGTH = (\([0-9]*\)).*/\1 \2/p' "$(dirname $elf)/matrig.ld"; arm-none-eabi-size -A $elf; } |
        awk '{ kib[$1] = $2 } $1 ~ /^\.(text|ARM\.exidx|data)$/ { flash += $2 } $1 ~ /^\.(stack|data|bss|noinit)$/ { ram += $2 }
        END { print flash, 1024 * kib["PROGRAM"] - flash, ram, 1024 * kib["RAM"] - ram }' >$out/size
    read -r flash flash_left ram ram_left <$out/size
    printf '%-10s %7d %7d %7d %7d %6s %3d %3d %19s %17s %15s %13s %7.1f\n' "$board" "$flash" "$flash_left" "$ram" "$ram_left" \
        "$(sed -n 's/.*image \([0-9a-f]\{6\}\).*/\1/p' $out/$board.txt)" "$(count 1)" "$(count 2)" "$(value touchdown)" "$(value deceleration)" "$(value stop)" \
        "$(sed -n 's/.*), \([0-9]*\) instructions.*/\1/p' $out/$board.err)" "$(awk -v a="$begin" -v b="$end" 'BEGIN { print b - a }')" >>$table
    grep -Eq '^  faults +none$' $out/$board.txt && grep -Eq '^  gaps +none$' $out/$board.txt
done
cat $table
