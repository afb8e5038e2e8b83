#!/usr/bin/env bash
# usage: jobs/run.sh SCENE [RANKS] [-- more arguments of trevi]
#
# Installs what is missing, builds, runs SCENE on RANKS ranks (default 2), draws the density curve and says where
# everything is. Output goes to out/<scene name>, or -2, -3, ... when that exists; with --restart to the newest of them.
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
  ranks=2
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

# report: what the run left, and how to look at it.
report() {
  echo
  if [[ -e $output/series.csv ]]; then
    /usr/bin/python3 postprocess/plot_series.py "$output" --scene "$scene" >/dev/null &&
      echo "density curve   $output/density.png"
    echo "series          $output/series.csv (one row a step)"
  fi
  if [[ -e $output/particles.pvd ]]; then
    echo "particles       $output/particles.pvd, pieces in $output/vtu"
    echo "look at them    paraview $output/particles.pvd (Apply, then colour by rgb, speed or density)"
  fi
  if [[ -e $output/particles.hdf.series ]]; then
    echo "particles       paraview $output/particles.hdf.series"
  fi
}

main() {
  local scene ranks extra output status=0
  parse_arguments "$@"
  cd "$trevi_root"
  setup release
  choose_output
  echo
  echo "mpirun -np $ranks build/release/trevi $scene ${extra[*]}"
  mpirun -np "$ranks" build/release/trevi "$scene" "${extra[@]}" || status=$?
  # 4: stopped on request after a checkpoint; what there is can be looked at.
  if [[ $status -eq 0 || $status -eq 4 ]]; then
    report
  fi
  exit "$status"
}

main "$@"
