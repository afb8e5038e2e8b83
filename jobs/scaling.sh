#!/usr/bin/env bash
# usage: jobs/scaling.sh [--studies LIST] [--ranks LIST] [--counted LIST] [--threads N] [--million] [--repeats N]
#                        [--output DIR] [--program FILE] [--no-tables]
#
# Strong and weak scaling of water at rest and in motion, balance and halo traffic, measured with mpirun on this machine
# or inside a Slurm allocation (jobs/scaling.sbatch). Runs go to DIR (default out/scaling); postprocess/scaling.py makes
# the tables and plots there, and postprocess/results/scaling_metrics.md says what the metrics mean.
#   --studies LIST   of: network strong weak cube moving counted balance (default all of them); weak grows a basin along
#                    the slabs, cube one that is as deep as long and wide, moving a cube that falls (strong and weak)
#   --ranks LIST     rank counts that are timed, with RANKSxTHREADS for more threads than --threads says (default: 1 2 4
#                    ... up to the cores of this machine)
#   --counted LIST   rank counts that only count messages, bytes and work, as the cores are too few (default: 2 4 8 16)
#   --threads N      threads of each rank (default 1: then cores are ranks)
#   --million        1 million particles and 0.5 million a rank, in place of 96,000 and 96,000 a rank
#   --repeats N      runs of each kind, taken in turns (default 3): medians and fastest are shown
#   --program FILE   a trevi that is built already, with bench_halo beside it in tests/benchmarks if there is one
#   --no-tables      runs only, as several jobs write to DIR; postprocess/scaling.py DIR makes the tables afterwards
# Lists are words in quotes: --ranks "1 2 1x2". Without --program all is built, with benchmarks, in build/bench.
# MPIRUN names the launcher (default mpirun). Time on more ranks than cores says nothing: counted runs are not timed.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

powers_of_two() {
  local ranks=1
  while ((ranks <= $1)); do
    echo "$ranks"
    ranks=$((2 * ranks))
  done
}

without_output=(output.vtu.every=1000.0 output.checkpoint.every=1000.0)

check_numbers() {
  local n
  [[ -n $2 ]] || fail "$1 needs a number" 2
  for n in $2; do [[ $n =~ ^[1-9][0-9]*${3:-}$ ]] || fail "$1 takes positive numbers, not '$n'" 2; done
}

# Of a word of --ranks: its ranks, its threads, its cores.
ranks_of() { echo "${1%x*}"; }
threads_of() { if [[ $1 == *x* ]]; then echo "${1#*x}"; else echo "$threads"; fi; }
cores_of() { echo $(($(ranks_of "$1") * $(threads_of "$1"))); }

parse_arguments() {
  local study
  studies="network strong weak cube moving counted balance" ranks="$(powers_of_two "$(nproc)")" counted="2 4 8 16"
  threads=1 million=no repeats=3 output=out/scaling program="" tables=yes
  while [[ $# -gt 0 ]]; do
    case "$1" in
      -h | --help) print_help && exit 0 ;;
      --million) million=yes && shift && continue ;;
      --no-tables) tables=no && shift && continue ;;
      --studies | --ranks | --counted | --threads | --repeats | --output | --program) ;;
      *) fail "unknown argument $1; see --help" 2 ;;
    esac
    [[ $# -gt 1 ]] || fail "$1 needs a value; see --help" 2
    printf -v "${1#--}" %s "$2"
    shift 2
  done
  check_numbers --ranks "$ranks" '(x[1-9][0-9]*)?'
  check_numbers --counted "$counted"
  check_numbers --threads "$threads"
  check_numbers --repeats "$repeats"
  for study in $studies; do
    [[ $study =~ ^(network|strong|weak|cube|moving|counted|balance)$ ]] || fail "--studies: there is no '$study'; see --help" 2
  done
  [[ -z $program || -x $program ]] || fail "--program: $program is no program" 2
}

build_benchmarks() {
  echo "Building with benchmarks in build/bench, five minutes on two cores the first time."
  trevi_packages+=(libbenchmark-dev)
  install_packages
  cmake --preset release -B build/bench -DTREVI_BENCHMARKS=ON -DTREVI_TESTS=OFF >/dev/null
  cmake --build build/bench -j "$(build_jobs)"
}

# run STUDY CASE RANKS[xTHREADS] NUMBER SCENE STEPS [KEY=VALUE ...]: one run, in DIR/STUDY/CASE/npRANKS[xTHREADS]-NUMBER.
# (The series, every fifth step, is for the times of single steps and the imbalance; wall_seconds leaves it out.)
run() {
  local place="$output/$1/$2/np$3-$4" ranks=$3 scene=$5 steps=$6 k settings=()
  shift 6
  for k in "$@"; do settings+=(--set "$k"); done
  rm -rf "$place"
  mkdir -p "$(dirname "$place")"
  echo "$place"
  "${MPIRUN:-mpirun}" -np "$(ranks_of "$ranks")" "$program" "$scene" --steps "$steps" --output "$place" \
    --progress none --threads "$(threads_of "$ranks")" --set output.series.every_steps=5 "${settings[@]}" >"$place.log" 2>&1 || fail "failed; see $place.log"
}

network() {
  local bench np k
  bench="$(dirname "$program")/tests/benchmarks/bench_halo"
  [[ -x $bench ]] || fail "$bench is missing; build with -DTREVI_BENCHMARKS=ON, or leave network out of --studies" 2
  mkdir -p "$output/network"
  for k in $ranks; do
    np="$(ranks_of "$k")"
    ((np > 1)) || continue
    "${MPIRUN:-mpirun}" -np "$np" "$bench" >"$output/network/np$np.csv"
  done
}

# The same water on more and more ranks.
strong() {
  local np k
  for ((k = 1; k <= repeats; k++)); do
    for np in $ranks; do
      if [[ $million == yes ]]; then
        run strong million "$np" "$k" inputs/bench_rest.toml 15 'domain.max=[10.0, 10.0, 12.0]' \
          'particles.0.max=[10.0, 10.0, 10.0]'
      else
        run strong 96k "$np" "$k" inputs/bench_rest.toml 60
      fi
    done
  done
}

# A basin that grows along the slabs by as much water for each core.
weak() {
  local np k cores
  for ((k = 1; k <= repeats; k++)); do
    for np in $ranks; do
      cores="$(cores_of "$np")"
      if [[ $million == yes ]]; then
        run weak million "$np" "$k" inputs/bench_rest.toml 15 "domain.max=[$((5 * cores)).0, 10.0, 12.0]" \
          "particles.0.max=[$((5 * cores)).0, 10.0, 10.0]"
      else
        run weak 96k "$np" "$k" inputs/bench_rest.toml 60 "domain.max=[$((6 * cores)).0, 4.0, 6.0]" \
          "particles.0.max=[$((6 * cores)).0, 4.0, 4.0]"
      fi
    done
  done
}

# A basin of as much water for each core that is as deep as long and wide, to two layers of particles.
cube() {
  local np k edge
  for ((k = 1; k <= repeats; k++)); do
    for np in $ranks; do
      if [[ $million == yes ]]; then
        edge="$(edge_of 500000 "$np")"
        run weak cube_million "$np" "$k" inputs/bench_rest.toml 15 "domain.max=[$edge, $edge, $(layers_more "$edge" 10)]" \
          "particles.0.max=[$edge, $edge, $edge]"
      else
        edge="$(edge_of 96000 "$np")"
        run weak cube_96k "$np" "$k" inputs/bench_rest.toml 60 "domain.max=[$edge, $edge, $(layers_more "$edge" 20)]" \
          "particles.0.max=[$edge, $edge, $edge]"
      fi
    done
  done
}

# edge_of PARTICLES RANKS[xTHREADS]: metres of a cube of so many for each core, 0.1 m apart, an even number of layers.
edge_of() { awk -v n="$(($1 * $(cores_of "$2")))" 'BEGIN {printf "%.1f", 0.2 * int(n ^ (1 / 3) / 2 + 0.5)}'; }
layers_more() { awk -v edge="$1" -v layers="$2" 'BEGIN {printf "%.1f", edge + 0.1 * layers}'; }

# A cube of water that falls, meets the floor and splashes; wider along the slabs by as much for each core.
moving() {
  local np k cores steps=150 size=() name=96k
  [[ $million == no ]] || { name=million && size=(fluid.spacing=0.0457 fluid.kernel_radius=0.0914); }
  for ((k = 1; k <= repeats; k++)); do
    for np in $ranks; do
      cores="$(cores_of "$np")"
      run strong "moving_$name" "$np" "$k" inputs/falling_cube.toml "$steps" "${size[@]}" "${without_output[@]}"
      run weak "moving_$name" "$np" "$k" inputs/falling_cube.toml "$steps" "${size[@]}" "${without_output[@]}" \
        "domain.max=[$(awk "BEGIN {print 4.65 + 4.8 * $cores}"), 5.85, 12.0]" \
        "particles.0.max=[$(awk "BEGIN {print 2.325 + 4.8 * $cores}"), 4.925, 8.4]"
    done
  done
}

# Messages, bytes and work of each rank.
counted() {
  local np
  for np in $counted; do
    run counted rest "$np" 1 inputs/bench_rest.toml 10
    run counted rest_filters "$np" 1 inputs/bench_rest.toml 10 vorticity.epsilon=0.002 viscosity.c=0.001
  done
}

# Cuts that follow the water, beside equal slabs.
balance() {
  local slabs np last=""
  for slabs in balanced equal; do
    for np in $counted; do
      run balance "dam_break_$slabs" "$np" 1 inputs/dam_break.toml 400 "domain.slabs=\"$slabs\"" \
        "${without_output[@]}"
    done
    [[ $million == yes ]] || continue
    for np in $ranks; do last=$np; done
    run balance "fountain_$slabs" "$last" 1 inputs/fountain.toml 140 "domain.slabs=\"$slabs\"" fluid.spacing=0.045 \
      fluid.kernel_radius=0.09 'fountain.0.center=[2.4, 2.9]' "${without_output[@]}"
  done
}

main() {
  local studies ranks counted threads million repeats output program tables study
  parse_arguments "$@"
  cd "$trevi_root"
  mpi_environment
  # Ranks that are bound to one core each would share it with whatever else runs there, and a rank that waits should
  # not keep another one from its core.
  export OMPI_MCA_hwloc_base_binding_policy="${OMPI_MCA_hwloc_base_binding_policy:-none}"
  export OMPI_MCA_mpi_yield_when_idle="${OMPI_MCA_mpi_yield_when_idle:-1}"
  if [[ -z $program ]]; then
    build_benchmarks
    program=build/bench/trevi
  fi
  for study in $studies; do "$study"; done
  [[ $tables == no ]] || /usr/bin/python3 postprocess/scaling.py "$output"
}

main "$@"
