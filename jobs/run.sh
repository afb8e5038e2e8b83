#!/usr/bin/env bash
# usage: jobs/run.sh SCENE [RANKS] [-- more arguments of trevi]
#
# Installs what is missing, builds the program (not its tests), runs SCENE on all cores, draws the density curve and says where everything is. RANKS
# is the number of ranks, which share the cores as threads; by default there is one for each NUMA node, so on a machine
# with a single one there is one rank, and no mpirun. Output goes to out/<scene name>, or -2, -3, ... when that exists; with --restart to the newest of them.
# trevi runs in the root of the project, so paths after -- are relative to that.
#
#   jobs/run.sh inputs/falling_cube.toml
#   jobs/run.sh inputs/fountain.toml 4 -- --set time.end=2.0
#   jobs/run.sh inputs/fountain.toml 4 -- --restart latest
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

# Sets scene, ranks and extra.
parse_arguments() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    "" | -*) fail "SCENE is missing; see --help" 2 ;;
  esac
  [[ -r $1 ]] || fail "no such scene: $1" 2
  scene="$(realpath "$1")"
  scene="${scene#"$trevi_root"/}"
  shift
  ranks=""
  if [[ $# -gt 0 && $1 != -- ]]; then
    [[ $1 =~ ^[1-9][0-9]*$ ]] || fail "RANKS must be a positive number, not '$1'" 2
    ranks=$1
    shift
  fi
  [[ $# -eq 0 || $1 == -- ]] || fail "arguments for trevi go after --; got '$1'" 2
  extra=("${@:2}")
}

# Sets output: what the user asked for, the newest run for a restart, or else a fresh directory.
choose_output() {
  local base newest="" number=1 restart=no i
  output=""
  for ((i = 0; i < ${#extra[@]}; i++)); do
    case "${extra[i]}" in
      --output) output="${extra[i + 1]:-}" ;;
      --output=*) output="${extra[i]#*=}" ;;
      --restart | --restart=*) restart=yes ;;
    esac
  done
  [[ -z $output ]] || return 0
  base="out/$(basename "${scene%.*}")"
  output="$base"
  while [[ -e $output ]]; do
    newest="$output"
    number=$((number + 1))
    output="$base-$number"
  done
  if [[ $restart == yes && -n $newest ]]; then
    output="$newest"
  fi
  extra+=(--output "$output")
}

# NUMA nodes with processors that this process may use; each has memory of its own, which is slower from another.
numa_nodes() {
  /usr/bin/python3 -c 'import glob, os
nodes = {os.path.basename(node) for cpu in os.sched_getaffinity(0)
         for node in glob.glob(f"/sys/devices/system/cpu/cpu{cpu}/node[0-9]*")}
print(max(1, len(nodes)))'
}

# Sets launch: nothing for one rank, which then has all cores. mpirun would bind one or two ranks to a core each, and so
# to a thread each: ranks are bound to NUMA nodes, of which they share the cores, or not at all where there is only one.
choose_launch() {
  local nodes
  nodes="$(numa_nodes)"
  ranks="${ranks:-$nodes}"
  launch=()
  [[ $ranks -gt 1 ]] || return 0
  launch=(mpirun -np "$ranks")
  if [[ -n ${OMPI_MCA_hwloc_base_binding_policy:-}${OMPI_MCA_rmaps_base_mapping_policy:-} ]]; then
    return 0 # as the user says
  elif [[ $nodes -gt 1 && $(mpirun --version) == *"Open MPI"* ]]; then
    launch+=(--map-by numa --bind-to numa:overload-allowed)
  elif [[ $nodes -gt 1 ]]; then
    launch+=(--bind-to numa) # MPICH, which places them one after the other on the nodes
  else
    launch+=(--bind-to none)
  fi
}

# The fields of the frames, as their first file names them.
fields_of_frames() {
  find "$output/vtu" -name '*.pvtu' -print0 -quit |
    xargs -0 -r sed -n '/<PPointData/,/<\/PPointData/s/.*<PDataArray[^>]*Name="\([^"]*\)".*/\1/p' | paste -sd, | sed 's/,/, /g'
}

# report: what the run left, and how to look at it.
report() {
  local shown # as the shell takes it
  shown="$(printf %q "$output")"
  echo
  if [[ -e $output/series.csv ]]; then
    /usr/bin/python3 postprocess/plot_series.py "$output" --scene "$scene" >/dev/null &&
      echo "density curve   $output/density.png"
    echo "series          $output/series.csv (one row a step)"
  fi
  if [[ -e $output/particles.pvd ]]; then
    echo "particles       $output/particles.pvd, pieces in $output/vtu"
    echo "look at them    paraview $shown/particles.pvd (Apply, then colour by $(fields_of_frames))"
    echo "                jobs/view.sh $shown"
  fi
  if [[ -e $output/particles.hdf.series ]]; then
    echo "particles       paraview $shown/particles.hdf.series"
  fi
}

main() {
  local scene ranks extra output launch status=0
  parse_arguments "$@"
  cd "$trevi_root"
  setup_program trevi
  choose_output
  choose_launch
  local run=("${launch[@]}" build/release/trevi "$scene" "${extra[@]}")
  echo
  echo "${run[*]}"
  "${run[@]}" || status=$?
  # 4: stopped on request after a checkpoint; what there is can be looked at.
  if [[ $status -eq 0 || $status -eq 4 ]]; then
    report
  fi
  exit "$status"
}

main "$@"
