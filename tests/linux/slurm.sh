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
same_table() { cat $(ls "$1"/*.jsonl | sort -V) | cmp - "$tmp/whole.jsonl" && $m sweep "$tmp/whole.json" --table "$1"/*.jsonl | grep -q '^missing *0$'; } # FOLDER
unbroken() { $m --quiet sweep "$tmp/whole.json" --cases 1..1000 -o "$tmp/whole.jsonl" && [ "$(wc -l <"$tmp/whole.jsonl")" = 1000 ]; }
check "1,000 cases without Slurm" unbroken

check "a Slurm of its own: munged, slurmctld, slurmd, one node with two cores" slurm_start "$node" 2
loopback() {
    ip -o addr
    ip route
    [ -z "$(ip -o addr | grep -v '^[0-9]*: lo ')" ] && [ -z "$(ip route)" ]
}
check "on a network of its own, loopback alone" loopback

array() { # as docs/howto/sweep-on-a-cluster.md has it, with 125 cases a task
    local begun=$SECONDS
    mkdir -p "$tmp/array" && timeout 120 sbatch --wait --array=0-7 --output="$tmp/array/%a.log" --wrap \
        "$PWD/$m --quiet sweep $PWD/$tmp/whole.json --cases \$((125 * SLURM_ARRAY_TASK_ID + 1))..\$((125 * SLURM_ARRAY_TASK_ID + 125)) -o $PWD/$tmp/array/\$SLURM_ARRAY_TASK_ID.jsonl"
    local code=$?
    cat "$tmp"/array/*.log
    echo "# figure: 1,000 cases as a job array of 8 tasks: $((SECONDS - begun)) s" >&3
    [ $code -eq 0 ] && [ "$(ls "$tmp"/array/*.jsonl | wc -l)" = 8 ]
}
exec 3>&1
check "a job array of eight tasks" array
check "the same table" same_table "$tmp/array"
ended() { slurm_end; ! pgrep -f "$node" >/dev/null; }
check "all of Slurm is ended" ended

gnu() {
    mkdir -p "$tmp/gnu" && seq 1 125 1000 | timeout 120 parallel -j 2 --joblog "$tmp/gnu/log" --resume-failed \
        "$m --quiet sweep $tmp/whole.json --cases {}..\$(({} + 124)) -o $tmp/gnu/{}.jsonl"
    cat "$tmp/gnu/log"
    same_table "$tmp/gnu"
}
check "the same through GNU parallel" gnu
finish
