#!/usr/bin/env bash
# matrig sweep through a real Slurm (a node of its own: slurm_node.sh) and through GNU parallel. Needs root: slurmd does. All of it runs
# in namespaces of its own: the network is a loopback that nothing else sees, and when this script ends, every process in it does.
export PATH=$PATH:/usr/sbin:/sbin
inside="unshare --net --uts --pid --fork --kill-child --mount-proc"
if [ -z "${MATRIG_INSIDE:-}" ] && [ "$(id -u)" = 0 ] && $inside true 2>/dev/null; then
    MATRIG_INSIDE=1 exec $inside "$0"
fi
. "$(dirname "$0")/../cli/tap.sh"
. tests/linux/slurm_node.sh
m=build/matrig
if [ -z "${MATRIG_INSIDE:-}" ]; then
    echo "ok 1 - matrig sweep through Slurm and GNU parallel # SKIP needs root, and namespaces (unshare)"
    echo "1..1"
    exit 0
fi
installed() { for program in munged slurmctld slurmd sbatch parallel; do command -v $program || { echo "no $program: rm build/.linux-packages, make test-linux"; return 1; }; done; }
check "Slurm, munge and GNU parallel are installed" installed
# The second address is of a documentation network: names are looked up (AI_ADDRCONFIG) only where there is one beside 127.0.0.1.
network() { ip link set lo up && ip addr add 192.0.2.1/32 dev lo && hostname localhost; }
check "a loopback of its own" network
node=$(mktemp -d /tmp/matrig-slurm.XXXXXX)
trap 'slurm_end; rm -rf "$node"' EXIT
trap 'exit 130' INT TERM

cat >"$tmp/whole.json" <<'J'
{"base": {"model": "chain", "N": 20, "left": "free", "right": "free", "CL": 0, "Vac": 0, "s0": 0, "v0": 0, "friction": "none", "tend": 0.01},
 "vary": {"KL": {"from": 1e6, "to": 1e8, "count": 40, "scale": "log"}, "F": {"from": 1000, "to": 25000, "count": 25}},
 "outputs": ["peak_u_ft", "outputs.-1.u_ft.1"]}
J
rows() { $m --quiet --json report "$1" -o "$tmp/page.html"; } # FILE: its table, in the study's order, without times
same_table() { cmp <(rows "$1") "$tmp/whole.rows" && [ "$(grep -o '"case":"[0-9a-f]*"' "$1" | sort -u | wc -l)" = 1000 ] && [ "$(wc -l <"$1")" = 1000 ]; }
study() { mkdir -p "$tmp/$1" && cp "$tmp/whole.json" "$tmp/$1/s.json"; } # NAME: a folder of its own
wait_queue() { # until no job is left, 90 s at most
    for _ in $(seq 180); do
        [ -z "$(timeout 5 squeue --noheader 2>/dev/null)" ] && return
        sleep 0.5
    done
    squeue
    return 1
}
unbroken() { $m --quiet sweep "$tmp/whole.json" && rows "$tmp/whole.jsonl" >"$tmp/whole.rows" && grep -q '^{"cases":1000,"failed":0,"missing":0,' "$tmp/whole.rows"; }
check "1,000 cases without Slurm" unbroken

check "a Slurm of its own: munged, slurmctld, slurmd, one node with two cores" slurm_start "$node" 2
loopback() {
    ip -o addr
    ip route
    [ -z "$(ip -o addr | grep -v '^[0-9]*: lo ')" ] && [ -z "$(ip route)" ]
}
check "on a network of its own, loopback alone" loopback

study 'array of $8'
job_array() {
    local begun=$SECONDS
    timeout 120 $m sweep "$tmp/array of \$8/s.json" --slurm --shards 8 >"$tmp/o" 2>"$tmp/e"
    local code=$?
    cat "$tmp/o" "$tmp/e"
    echo "# figure: 1,000 cases as a job array of 8 tasks: $((SECONDS - begun)) s" >&3
    [ $code -eq 0 ] && grep -q '1000 gathered from 8 files, 0 failed, 0 missing' "$tmp/o" && grep -Eq 'Slurm job [0-9]+, 8 shards' "$tmp/e"
}
exec 3>&1
check "--slurm writes and submits the array, waits and gathers" job_array
check "the same table" same_table "$tmp/array of \$8/s.jsonl"
tasks() { # each of the eight ran as a task of that job, and had its share
    for i in 1 2 3 4 5 6 7 8; do
        [ "$(wc -l <"$tmp/array of \$8/s.$i-of-8.jsonl")" = 125 ] && [ -e "$tmp/array of \$8/s.jsonl.slurm-$i.log" ] || return 1
    done
    scontrol show job 1 | grep -c 'ArrayTaskId=[1-8] ' | grep -qx 8 && ! scontrol show job 1 | grep JobState= | grep -v COMPLETED
}
check "eight tasks of one job, 125 cases each" tasks

study own
own_array() { # somebody's own script, without --shard
    sbatch --wait --array=0-3 --output="$tmp/own/%a.log" --wrap "$PWD/$m --quiet sweep $PWD/$tmp/own/s.json -j 1" && cat "$tmp"/own/?.log &&
        $m sweep "$tmp/own/s.json" --gather | grep 'gathered from 4 files, 0 failed, 0 missing' && same_table "$tmp/own/s.jsonl"
}
check "in an array of one's own, 0-3, the tasks divide the study by themselves" timeout 120 bash -c "$(declare -f own_array same_table rows); m=$m tmp=$tmp; own_array"

# An array is cancelled while it runs; the same command afterwards does what is missing.
study cut
cancelled() {
    timeout 120 $m sweep "$tmp/cut/s.json" --slurm --shards 40 >"$tmp/o" 2>"$tmp/e" &
    local process=$!
    for _ in $(seq 300); do
        [ -s "$tmp/cut/s.3-of-40.jsonl" ] && break
        sleep 0.1
    done
    timeout 20 scancel --name=matrig-sweep
    wait $process
    local code=$?
    cat "$tmp/o" "$tmp/e"
    [ $code -eq 1 ] && grep -Eq ' [1-9][0-9]* missing' "$tmp/o"
}
check "a cancelled array: what is missing is said, exit 1" cancelled
finished() { timeout 120 $m sweep "$tmp/cut/s.json" --slurm --shards 6 >"$tmp/o" 2>&1; cat "$tmp/o"; grep -q ' 0 failed, 0 missing' "$tmp/o" && same_table "$tmp/cut/s.jsonl"; }
check "submitted again, in other shards: complete, the same table" finished

study later
later() {
    timeout 30 $m sweep "$tmp/later/s.json" --slurm --shards 4 --no-wait --with '--time=5 --comment=sweep' >"$tmp/o" 2>&1 && cat "$tmp/o" && wait_queue &&
        cat "$tmp"/later/*gather.log && same_table "$tmp/later/s.jsonl"
}
check "--no-wait gathers in a job of its own" later
study none
refused() { fails_with 3 'sbatch refused' bash -c "$m sweep $tmp/none/s.json --slurm --with '--partition=none' 2> >(grep -v '^sbatch' >&2)"; }
check "what sbatch refuses is said" refused

ended() { slurm_end; ! pgrep -f "$node" >/dev/null; }
check "all of Slurm is ended" ended

study "gnu's own & more"
gnu() { timeout 120 $m sweep "$tmp/gnu's own & more/s.json" --parallel -j 2 --shards 8 >"$tmp/o" 2>&1; cat "$tmp/o"; grep -q '1000 gathered from 8 files, 0 failed, 0 missing' "$tmp/o" && same_table "$tmp/gnu's own & more/s.jsonl"; }
check "--parallel: the same table through GNU parallel" gnu
finish
