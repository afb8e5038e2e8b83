#!/usr/bin/env bash
# usage: jobs/study_water.sh [more arguments of postprocess/study_water.py]
#
# Waves, pools at rest, wells, momentum and viscosity against the marks that water must meet: some 7 minutes on two
# cores.
# Writes postprocess/results/water.csv and its drawing.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-}" in -h | --help) print_help && exit 0 ;; esac
  trevi_packages+=(python3-h5py)
  setup_program trevi
  local results="$trevi_root/postprocess/results/water"
  "$trevi_root/postprocess/study_water.py" "$results.csv" "$@"
  "$trevi_root/postprocess/plot_water.py" "$results.csv" "$results.png"
}

main "$@"
