# A Slurm of one node of its own: munged, slurmctld and slurmd, in a folder of its own, for a network of its own. Source it; it defines
# slurm_start FOLDER CPUS and slurm_end. Nothing of a Slurm that this computer has is used or changed.
slurm_processes=()

free_port() { # one that nobody listens on
    local port
    for _ in $(seq 100); do
        port=$((20000 + RANDOM))
        (exec 3<>"/dev/tcp/127.0.0.1/$port") 2>/dev/null || { echo $port; return; }
    done
    return 1
}

slurm_config() { # FOLDER CPUS
    local host
    host=$(hostname -s)
    cat <<C
ClusterName=sweep
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$(free_port)
SlurmdPort=$(free_port)
AuthType=auth/munge
AuthInfo=socket=$1/munge.socket
CryptoType=crypto/munge
CommunicationParameters=NoInAddrAny
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$1/state
SlurmdSpoolDir=$1/spool
SlurmctldPidFile=$1/slurmctld.pid
SlurmdPidFile=$1/slurmd.pid
SlurmctldLogFile=$1/slurmctld.log
SlurmdLogFile=$1/slurmd.log
MailProg=/bin/true
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_min_interval=100000
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
InactiveLimit=0
KillWait=2
MinJobAge=10
Waittime=0
SlurmctldTimeout=60
SlurmdTimeout=60
NodeName=$host NodeAddr=127.0.0.1 CPUs=$2 State=UNKNOWN
PartitionName=sweep Nodes=$host Default=YES MaxTime=INFINITE State=UP
C
}

slurm_start() { # FOLDER CPUS: true when the node takes jobs, within 30 s
    local folder=$1
    mkdir -p "$folder/state" "$folder/spool"
    chmod 0755 "$folder"
    (umask 077 && head -c 1024 /dev/urandom >"$folder/munge.key")
    munged --foreground --force --socket="$folder/munge.socket" --key-file="$folder/munge.key" --pid-file="$folder/munged.pid" \
        --log-file="$folder/munged.log" --seed-file="$folder/munged.seed" >"$folder/munged.out" 2>&1 &
    slurm_processes+=($!)
    export SLURM_CONF=$folder/slurm.conf
    slurm_config "$folder" "$2" >"$SLURM_CONF"
    for _ in $(seq 50); do [ -S "$folder/munge.socket" ] && break; sleep 0.1; done
    slurmctld -D -f "$SLURM_CONF" >"$folder/slurmctld.out" 2>&1 &
    slurm_processes+=($!)
    slurmd -D -f "$SLURM_CONF" >"$folder/slurmd.out" 2>&1 &
    slurm_processes+=($!)
    local begun=$SECONDS
    while [ $((SECONDS - begun)) -lt 30 ]; do
        [ "$(timeout 5 sinfo --noheader --format=%t 2>/dev/null)" = idle ] && return
        sleep 0.2
    done
    tail -n 5 "$folder"/*.log "$folder"/*.out
    return 1
}

slurm_end() { # the daemons, and the steps that they started
    local process
    timeout 10 scancel --user=root >/dev/null 2>&1
    for process in "${slurm_processes[@]}"; do kill "$process" 2>/dev/null; done
    for _ in $(seq 50); do
        kill -0 "${slurm_processes[@]}" 2>/dev/null || break
        sleep 0.1
    done
    for process in "${slurm_processes[@]}"; do kill -9 "$process" 2>/dev/null; done
    wait "${slurm_processes[@]}" 2>/dev/null
    slurm_processes=()
}
