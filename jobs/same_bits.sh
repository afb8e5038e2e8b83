#!/usr/bin/env bash
# usage: jobs/same_bits.sh OLD NEW [STEPS] [SCENE...]
#
# Whether two builds of Trevi compute the same: OLD and NEW are two programs (build/release/trevi of two checkouts).
# Runs the small scenes of inputs/ and inputs/stress/ for STEPS steps (60) on 1 and 3 ranks in single and double
# precision with each and compares particles and series bit for bit. For changes that are to change nothing.
# Exit code 1 when a run differs or fails.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

if [[ $# -lt 2 || $1 == -h || $1 == --help ]]; then
  print_help
  [[ ${1:-} == -h || ${1:-} == --help ]] && exit 0 || exit 2
fi
mpi_environment
export OMPI_MCA_hwloc_base_binding_policy=none
programs=("$(realpath "$1")" "$(realpath "$2")")
steps="${3:-60}"
scenes=("${@:4}")
[[ ${#scenes[@]} -gt 0 ]] || scenes=("$trevi_root"/inputs/*_small.toml "$trevi_root"/inputs/stress/*.toml)
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

run() { # PROGRAM SCENE RANKS PRECISION FOLDER
  timeout 600 mpirun -np "$3" "$1" "$2" --output "$5" --steps "$steps" --progress none --set density.precision="$4" \
    --set output.series.every_steps=1 --set output.checkpoint.every_steps="$steps" >"$5.log" 2>&1
}

different=0 compared=0
for scene in "${scenes[@]}"; do
  for ranks in 1 3; do
    for precision in single double; do
      what="$(basename "$scene" .toml), $ranks ranks, $precision"
      for k in 0 1; do
        rm -rf "${work:?}/$k"
        run "${programs[$k]}" "$scene" "$ranks" "$precision" "$work/$k" ||
          { echo "$what: ${programs[$k]} failed: $(tail -n 1 "$work/$k.log")"; different=1; continue 2; }
      done
      compared=$((compared + 1))
      "$trevi_root/postprocess/same_bits.py" "$work/0" "$work/1" >"$work/said" ||
        { echo "$what: $(head -n 1 "$work/said")"; different=1; }
    done
  done
done
echo "$compared runs compared, $([[ $different == 0 ]] && echo "all the same bits" || echo "NOT all the same bits")"
exit $different
