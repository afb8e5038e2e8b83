#!/usr/bin/env bash
# usage: jobs/faults.sh [CALLS [KILLS [RESTARTS]]]
#
# What can go wrong around a run, at full length (an hour or two): the first CALLS (default 60) renames, fsyncs and
# writes fail, one a run; a disk is full, or slow, for each file in turn; the clock of the day jumps; a rank is lost at
# KILLS (default 200) calls of MPI, spread over a run; a run is gone on with RESTARTS (default 1000) times, each time on
# another number of ranks; 64 ranks share the cores; a small fountain plays for two hours. Each run must end as it
# should, each restart in the bits of a run that was left alone, and the memory stay. Needs a build in build/release.
# The short forms are ctest's `faults` and `endurance`; runs that are killed at any moment: jobs/kill_test.sh.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-60}${2:-200}${3:-1000}" in
    *-h*) print_help && exit 0 ;;
    *[!0-9]*) fail "CALLS, KILLS and RESTARTS must be numbers, not '$*'; see --help" 2 ;;
  esac
  cd "$trevi_root"
  mpi_environment
  export TREVI="$PWD/build/release/trevi" TREVI_RESTARTS="${3:-1000}" TREVI_RANKS=64 TREVI_SECONDS=7200
  tests/regression/test_faults.py "$PWD/build/release/tests/libfault_shim.so" "${1:-60}" "${2:-200}"
  tests/regression/test_endurance.py
}

main "$@"
