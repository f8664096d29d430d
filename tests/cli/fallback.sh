#!/usr/bin/env bash
# What the predictor falls back on, on the emulated board in landing 5, and what the user is told: a channel lost, all lost, no switches, a
# third of the budget. (A damaged memory: tests/cli/runway.sh.) The message verdict: basis bits 4 blind, 8 no motion, 16 degraded.
. "$(dirname "$0")/tap.sh"
. tests/board/played.sh
matrig=build/matrig
variants=build/tests/variant

fly() { # NAME ELF OPTION...: logged into NAME.db
    local name=$1 elf=$2
    shift 2
    played --elf "$elf" --can "file:$tmp/$name.can" --serial "file:$tmp/$name.serial" --rig tests/runs/landing5.run --for 5.5 "$@" 2>"$tmp/$name.err" &&
        { $matrig --quiet log --all --can "file:$tmp/$name.can" --serial "file:$tmp/$name.serial" --db "$tmp/$name.db" >"$tmp/$name.txt" 2>"$tmp/$name.log" ||
            grep -q 'the link ended inside a frame' "$tmp/$name.log"; }
}
ask() { sqlite3 "$tmp/$1.db" "$2"; }
moving='block between 2500 and 5000' # the gear rolls and brakes
bit() { ask "$1" "select printf('%.2f', avg((basis & $2) <> 0)) from predictions where $moving"; }
same_to_the_last_bit() { build/tests/again/again "$tmp/$1.db" 1 >"$tmp/$1.again"; cat "$tmp/$1.again"; grep -q '"possible":true.*"differ":0,' "$tmp/$1.again"; }

whole() { fly whole build/firmware/matrig.elf && [ "$(bit whole 4)$(bit whole 8)$(bit whole 16)" = 0.000.000.00 ] && [ "$(ask whole 'select max(doubts) from trust where block > 1500')" = 0 ]; }
one_lost() { # transducer 4, bits 6 and 7 of the doubts: missing; the zone is warned of all the same
    printf 'matrig-faults 1\nat 1.0  transducer 4 open\n' >"$tmp/one.faults"
    fly one build/firmware/matrig.elf --faults "$tmp/one.faults" && [ "$(ask one 'select min(doubts), max(doubts) from trust where block > 1500')" = '64|64' ] &&
        [ "$(bit one 4)" = 0.00 ] && grep 'zone  *warned' "$tmp/one.txt"
}
all_lost() { # it runs on the model alone, and says so
    fly all $variants/switches.elf && [ "$(bit all 4)" = 1.00 ] && [ "$(ask all "select group_concat(distinct level) from predictions where $moving")" = 0 ] &&
        grep 'zone  *warned' "$tmp/all.txt" && grep 'inferred  *100 % of the zone' "$tmp/all.txt"
}
no_switches() { # kinematic, as soon as something moves
    { echo 'matrig-faults 1'; for p in $(seq 24); do echo "at 0.5  switch $p skip"; done; } >"$tmp/none.faults"
    fly none build/firmware/matrig.elf --faults "$tmp/none.faults" && [ "$(bit none 8)" = 1.00 ] &&
        [ "$(ask none 'select group_concat(distinct level) from predictions where block between 3500 and 5000')" = 4 ] &&
        [ "$(ask none 'select min(mats) from zones where block between 5000 and 5450')" -ge 60 ] # what has moved stays so: 71 by the truth
}
a_third() { # one level down where the budget asks for it
    fly third $variants/frugal.elf && [ "$(ask third 'select count(distinct level) from predictions')" -ge 2 ] &&
        [ "$(ask third 'select count(*) from predictions where (basis & 16 <> 0) <> (level > 0)')" = 0 ] &&
        ask third "select level, count(*), min(block), max(block) from predictions group by level" && grep 'zone  *warned' "$tmp/third.txt"
}

# What the user reads of it: in matrig log's summary, and in the report.
told() { # NAME WORDS
    grep -A 9 '^  predictor' "$tmp/$1.txt"
    $matrig --quiet report "$tmp/$1.db" -o "$tmp/$1.html" >"$tmp/report.txt" 2>&1 || { cat "$tmp/report.txt"; return 1; }
    grep -Eq "$2" "$tmp/$1.txt" && grep -Eq "$2" "$tmp/$1.html"
}
nothing_told() { ! grep -E 'no transducer corrects|left out|instead of every mat|no switch measures|restarted' "$tmp/whole.txt" && told whole 'runway state at arming: from a landing or a survey since the reset; joint resistance 1.0'; }

check "nothing lost: no doubt, every mat" whole
check "a channel lost: it is named, and left out" one_lost
check "all lost: it runs blind, and says so" all_lost
check "no switches: transducers and survey alone" no_switches
check "a third of the budget: a cheaper level, and that is said" a_third
check "nothing lost: nothing of the kind is said" nothing_told
check "a channel lost, in words" told one 'transducer 4 \(70.0 ft\) was left out: missing, from'
check "all lost, in words" told all 'no transducer corrects the model'
check "no switches, in words" told none 'no switch measures the position of the gear'
check "a third of the budget, in words" told third 'two mats in one instead of every mat'
for name in whole one all none third; do
    check "$name: the host computes the same, to the last bit" same_to_the_last_bit $name
done
finish
