#!/bin/bash
# A Slurm cluster on loopback, slurmctld and two slurmd, bakes a scene and loses a node on the
# way: killed (SIGKILL), with the task that runs there. The bake must end with the bytes of
# `rrf bake` on one machine. Needs root, and Debian's packages, which it installs.
#
#     sudo tests/engines/slurm_cluster.sh
set -euo pipefail
cd "$(dirname "$0")/../.."
RRF=$(realpath "${RRF:-${CARGO_TARGET_DIR:-target}/release/rrf}")

if ! command -v slurmctld slurmd sbatch munged >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends \
        slurmctld slurmd slurm-client munge
fi

D=$(mktemp -d /tmp/rrf-slurm-XXXXXX)
mkdir -p "$D/state" "$D/spool-n1" "$D/spool-n2"
dd if=/dev/urandom of="$D/munge.key" bs=1024 count=1 status=none
chmod 755 "$D"
chmod 600 "$D/munge.key"

pids=()
finish() {
    for pid in "${pids[@]}"; do kill -9 "$pid" 2>/dev/null || true; done
    wait 2>/dev/null
    [ -n "${KEEP:-}" ] || rm -rf "$D"
}
trap finish EXIT

# MaxArraySize 3: four fits need two arrays. cred_expire: a requeued job may start
# again that long after its node was lost.
cat >"$D/slurm.conf" <<CONF
ClusterName=rrf
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmctldPort=26817
AuthType=auth/munge
AuthInfo=socket=$D/munge.socket,cred_expire=5
SlurmUser=root
SlurmdUser=root
StateSaveLocation=$D/state
SlurmdSpoolDir=$D/spool-%n
SlurmctldPidFile=$D/slurmctld.pid
SlurmdPidFile=$D/slurmd-%n.pid
SlurmctldLogFile=$D/slurmctld.log
SlurmdLogFile=$D/slurmd-%n.log
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SlurmdParameters=config_overrides
SlurmdTimeout=10
ReturnToService=2
MaxArraySize=3
NodeName=n1 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=26818 CPUs=1 RealMemory=4000
NodeName=n2 NodeHostname=$(hostname -s) NodeAddr=127.0.0.1 Port=26819 CPUs=1 RealMemory=4000
PartitionName=all Nodes=n1,n2 Default=YES State=UP
CONF
export SLURM_CONF=$D/slurm.conf

munged --foreground --force --key-file="$D/munge.key" --socket="$D/munge.socket" \
    --pid-file="$D/munge.pid" --log-file="$D/munge.log" --seed-file="$D/munge.seed" >"$D/munged.out" 2>&1 &
pids+=($!)
for _ in $(seq 100); do [ -S "$D/munge.socket" ] && break || sleep 0.1; done
slurmctld -D -c -f "$SLURM_CONF" >"$D/slurmctld.out" 2>&1 &
pids+=($!)
for node in n1 n2; do
    slurmd -D -N $node -f "$SLURM_CONF" >"$D/slurmd-$node.out" 2>&1 &
    pids+=($!)
done
victim=${pids[-1]}
for _ in $(seq 300); do
    [ "$(sinfo -h -t idle -o %D 2>/dev/null)" = 2 ] && break || sleep 0.2
done
sinfo -h -o '%D nodes %T'

SETTINGS="--method nets --light-box=-0.6,1.3,-0.6,0.6,1.8,0.6 --rows 8000 --cells 4 --paths 8 --rounds 4 --target 0.29 --most-cells 6"
"$RRF" bake --quiet scenes/cornell-box/scene.pbrt -o "$D/whole" $SETTINGS >/dev/null
python3 pipeline/engines/slurm/submit.py --scene scenes/cornell-box/scene.pbrt --run "$D/run" \
    --rrf "$RRF" --seconds 0 -- $SETTINGS

# kill n2 when a task is running on it: slurmd, its step daemon and the task
killed=""
for _ in $(seq 6000); do
    [ -f "$D/run.slurm/log" ] && grep -q ended "$D/run.slurm/log" && break
    jobs=$(squeue -h -w n2 -t running -n rrf-task -o %i 2>/dev/null || true)
    if [ -n "$jobs" ]; then
        kill -9 "$victim"
        # what runs there knows this cluster and that node by its environment
        for process in /proc/[0-9]*; do
            { tr "\0" "\n" <"$process/environ"; } 2>/dev/null |
                grep -cEx "SLURM_CONF=$SLURM_CONF|SLURMD_NODENAME=n2" | grep -qx 2 || continue
            parent=$(awk '/^PPid/ { print $2 }' "$process/status" 2>/dev/null || true)
            grep -qx slurmstepd "/proc/$parent/comm" 2>/dev/null && kill -9 "$parent" || true
            kill -9 "${process#/proc/}" 2>/dev/null || true
        done
        killed=$jobs
        echo "killed n2 while it ran $jobs"
        break
    fi
    sleep 0.05
done
[ -n "$killed" ] || { echo "no task ran on n2: nothing was tested" >&2; exit 1; }

for _ in $(seq 3000); do
    grep -Eq "ended|given up" "$D/run.slurm/log" && break || sleep 0.2
done
cat "$D/run.slurm/log"
grep -q "ended" "$D/run.slurm/log"
diff -r --exclude=seconds.json "$D/whole" "$D/run"
echo "2 nodes, 1 killed with a task in hand: the same bytes, $SECONDS s"
echo "1 passed, 0 failed"
