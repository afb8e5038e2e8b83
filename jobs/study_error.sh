#!/usr/bin/env bash
# usage: jobs/study_error.sh [more arguments of postprocess/study_error.py]
#
# Errors against run time of all density methods: some 8 minutes on one core, which should have nothing else to do.
# Writes postprocess/results/error_against_run_time.csv and its drawing.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-}" in -h | --help) print_help && exit 0 ;; esac
  trevi_packages+=(python3-h5py)
  setup_program trevi
  local results="$trevi_root/postprocess/results/error_against_run_time"
  "$trevi_root/postprocess/study_error.py" "$results.csv" "$@"
  "$trevi_root/postprocess/work_precision.py" "$results.csv" "$results.png"
}

main "$@"
