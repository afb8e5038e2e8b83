#!/usr/bin/env bash
# usage: jobs/try_slurm.sh [--keep]
#
# Tries trevi.sbatch and scaling.sbatch with a real Slurm (slurm-wlm and munge of Debian 12): a cluster of one node, with
# the cores of this machine, in a temporary folder, taken down at the end. --keep leaves its logs. A Slurm that is on the
# machine is not touched. Takes five minutes.
#   - A run that is longer than its jobs may be: signalled before the limit, it puts itself back into the queue and goes
#     on with --restart latest, until it is done. On the way a job is told to write a checkpoint, and once the node fails,
#     so that Slurm puts the job back. In the end all bits are those of a run without Slurm on another number of ranks.
#   - A job that is cancelled ends with a checkpoint.
#   - scaling.sbatch measures on one rank and more, and leaves its table.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
trevi_packages+=(slurm-wlm munge python3-h5py)

daemons=()

# wait_for SECONDS WHAT COMMAND...: until COMMAND is true.
wait_for() {
  local end=$((SECONDS + $1)) what="$2"
  shift 2
  until "$@"; do
    ((SECONDS < end)) || fail "waited in vain for $what; see $work (kept)"
    sleep 0.2
  done
}

free_ports() {
  /usr/bin/python3 -c 'import socket
s = [socket.socket() for _ in range(2)]
[x.bind(("127.0.0.1", 0)) for x in s]
print(*(x.getsockname()[1] for x in s))'
}

write_configuration() {
  local controller node
  read -r controller node < <(free_ports)
  mkdir -p "$work"/{state,spool,run}
  # Credentials live 5 s (as a rule two minutes), as long as a job that is put back waits for its turn.
  cat >"$work/slurm.conf" <<CONF
ClusterName=try
SlurmctldHost=$(hostname -s)(127.0.0.1)
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthInfo=socket=$work/run/munge.socket,cred_expire=5
SlurmctldPort=$controller
SlurmdPort=$node
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/run/slurmctld.pid
SlurmdPidFile=$work/run/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
KillWait=30
$(slurmd -C | head -n 1) NodeAddr=127.0.0.1 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE
CONF
  # Nothing here asks for control groups, and this plugin then leaves them alone.
  echo "CgroupPlugin=cgroup/v1" >"$work/cgroup.conf"
  (umask 077 && head -c 1024 /dev/urandom >"$work/munge.key")
}

is_idle() { [[ $(sinfo -h -o %t 2>/dev/null) == idle ]]; }

# Daemons stay in the foreground, as children of this script.
start_slurm() {
  export SLURM_CONF="$work/slurm.conf"
  chmod 755 "$work" "$work/run"
  munged --foreground --force --key-file="$work/munge.key" --socket="$work/run/munge.socket" \
    --pid-file="$work/run/munged.pid" --log-file="$work/munged.log" --seed-file="$work/munge.seed" &>"$work/munged.log" &
  daemons+=($!)
  wait_for 20 munged test -S "$work/run/munge.socket"
  slurmctld -D -f "$work/slurm.conf" &>/dev/null &
  daemons+=($!)
  slurmd -D -f "$work/slurm.conf" &>/dev/null &
  daemons+=($!)
  wait_for 60 "a node that is idle" is_idle
}

take_down() {
  local status=$? job
  if [[ ${#daemons[@]} -gt 1 ]]; then
    for job in $(squeue -h -o %A 2>/dev/null); do scancel "$job"; done
    sleep 2
  fi
  for ((k = ${#daemons[@]} - 1; k >= 0; k--)); do
    kill "${daemons[k]}" 2>/dev/null || true
    wait "${daemons[k]}" || true
  done
  if [[ $status -ne 0 || $keep == yes ]]; then
    echo "logs, jobs and runs are in $work"
  else
    rm -rf "$work"
  fi
}

write_scene() {
  cat >"$work/scene.toml" <<SCENE
[domain]
min = [0.0, 0.0, 0.0]
max = [1.6, 0.6, 1.6]
[fluid]
spacing = 0.1
[[particles]]
min = [0.0, 0.0, 0.0]
max = [1.6, 0.6, 0.6]
[[fountain]]
center = [0.8, 0.3]
diameter = 0.25
height = 0.4
speed = 5.0
[time]
dt = 0.016666666666666667
end = 100000.0
[gravity]
[output.series]
every_steps = 100
[output.checkpoint]
every_steps = 1000
keep = 2
SCENE
}

# Thousands of steps of a minute and a quarter, whatever this machine is.
thousands_of_steps() {
  local from
  from="$(date +%s%N)"
  mpirun -np "$ranks" "$TREVI" "$work/scene.toml" --output "$work/trial" --steps 2000 --progress none >/dev/null
  echo $((75 * 2000 * 1000000 / (($(date +%s%N) - from) / 1000) / 1000 + 2))
}

# submit NAME STEPS [arguments of sbatch]: prints the job's number.
submit() {
  sbatch --parsable --ntasks="$ranks" --output="$work/$1.log" "${@:3}" jobs/trevi.sbatch "$work/scene.toml" \
    --output "$work/$1" --steps "$2" --progress none
}

state_of() { scontrol show job "$1" | sed -n 's/^ *JobState=\([A-Z_]*\).*/\1/p'; }
is_in_state() { [[ $(state_of "$1") == "$2" ]]; }
has_steps() { [[ -e $work/$1/series.csv && $(wc -l <"$work/$1/series.csv") -gt $2 ]]; }
has_said() { grep -qs "$2" "$work/$1.log"; }
checkpoints_other_than_thousands() { find "$work/$1" -name 'checkpoint_*.h5' ! -name '*000.h5' | wc -l; }
has_odd_checkpoint() { [[ $(checkpoints_other_than_thousands "$1") -gt 0 ]]; }
has_started_again() { [[ $(grep -c '^trevi 1' "$work/$1.log") -gt $2 ]]; }
reason_of() { sed -n 's/.*"exit_reason": "\(.*\)".*/\1/p' "$work/$1/run.json"; }

# The run that outlives its jobs: limit 1 min, signalled 20 s before it or earlier (Slurm looks twice a minute).
try_requeue() {
  local job steps turns
  steps=$(($(thousands_of_steps) * 1000))
  echo "A run of $steps steps in jobs of a minute:"
  job="$(submit run "$steps" --time=1 --signal=B:USR2@20)"
  wait_for 60 "the first steps" has_steps run 3
  scancel --signal=USR1 --batch "$job"
  wait_for 30 "a checkpoint on request" has_odd_checkpoint run
  echo "  told to write a checkpoint, it did and went on"
  wait_for 120 "the job to be signalled" has_said run "back into the queue"
  echo "  signalled before its limit, it stopped and went back into the queue"
  wait_for 120 "the second job" has_started_again run 1
  turns="$(wc -l <"$work/run/series.csv")"
  wait_for 60 "steps of the second job" has_steps run $((turns + 20))
  scontrol update NodeName="$(hostname -s)" State=DOWN Reason="a trial"
  wait_for 60 "the job to be put back" is_in_state "$job" PENDING
  # The node may have come back by itself (ReturnToService), and is then not to be resumed.
  scontrol update NodeName="$(hostname -s)" State=RESUME 2>/dev/null || true
  echo "  after its node had failed, Slurm put it back into the queue"
  wait_for 400 "the end of the run" is_in_state "$job" COMPLETED
  echo "  done in $(grep -c '^trevi 1' "$work/run.log") jobs"
  mpirun -np 3 "$TREVI" "$work/scene.toml" --output "$work/straight" --steps "$steps" --progress none >/dev/null
  /usr/bin/python3 postprocess/same_bits.py "$work/run" "$work/straight" || fail "not the bits of a run without Slurm"
  echo "  the same bits as a run without Slurm, on 3 ranks in place of $ranks"
}

try_cancel() {
  local job
  job="$(submit cancelled 100000000 --time=5)"
  wait_for 60 "the steps of a job" has_steps cancelled 3
  scancel "$job"
  wait_for 60 "the end of the job" is_in_state "$job" CANCELLED
  wait_for 40 "a checkpoint" has_odd_checkpoint cancelled
  echo "A job that was cancelled: $(reason_of cancelled), with a checkpoint"
}

try_scaling() {
  local studies=strong
  [[ ! -x $(dirname "$TREVI")/tests/benchmarks/bench_halo ]] || studies="network strong"
  sbatch --wait --ntasks-per-node="$ranks" --output="$work/scaling.log" jobs/scaling.sbatch --studies "$studies" \
    --repeats 1 --output "$work/scaling" >/dev/null || fail "scaling.sbatch failed; see $work/scaling.log"
  echo "scaling.sbatch, $studies:"
  sed 's/^/  /' "$work/scaling.log"
}

main() {
  case "${1:-}" in
    "" | --keep) keep=$([[ $# -gt 0 ]] && echo yes || echo no) ;;
    -h | --help) print_help && exit 0 ;;
    *) fail "unknown argument $1; see --help" 2 ;;
  esac
  setup_program trevi
  cd "$trevi_root"
  export TREVI="${TREVI:-$trevi_root/build/release/trevi}" PATH="$PATH:/usr/sbin"
  ranks=$(($(nproc) > 1 ? 2 : 1))
  work="$(mktemp -d -p "${TMPDIR:-/tmp}" try_slurm.XXXXXX)"
  trap take_down EXIT
  write_configuration
  start_slurm
  write_scene
  try_requeue
  try_cancel
  try_scaling
}

main "$@"
