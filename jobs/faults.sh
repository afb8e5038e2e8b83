#!/usr/bin/env bash
# usage: jobs/faults.sh [CALLS]
#
# Makes the first CALLS (default 60) renames, fsyncs and writes of a run fail, one a run, and an fsync take its time;
# each run must end with 3 and a message, and its restart in the bits of a run that was left alone. Needs a build in
# build/release. The short form is ctest's `faults`; runs that are killed: jobs/kill_test.sh.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-60}" in
    -h | --help) print_help && exit 0 ;;
    *[!0-9]*) fail "CALLS must be a number, not '$1'; see --help" 2 ;;
  esac
  cd "$trevi_root"
  mpi_environment
  TREVI="$PWD/build/release/trevi" tests/regression/test_faults.py "$PWD/build/release/tests/libfault_shim.so" "${1:-60}"
}

main "$@"
