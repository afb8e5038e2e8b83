#!/usr/bin/env bash
# usage: jobs/study_stability.sh [more arguments of postprocess/study_stability.py]
#
# The stress cases of inputs/stress with the report's preset, with the default (20 s of simulated time each) and with
# densities from Poly6: some 10 minutes on two cores.
# Writes postprocess/results/stability.csv and its drawing.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-}" in -h | --help) print_help && exit 0 ;; esac
  trevi_packages+=(python3-h5py)
  setup_program trevi
  local results="$trevi_root/postprocess/results/stability"
  "$trevi_root/postprocess/study_stability.py" "$results.csv" "$@"
  "$trevi_root/postprocess/stability_matrix.py" "$results.csv" "$results.png"
}

main "$@"
