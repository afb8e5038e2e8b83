#!/usr/bin/env bash
# usage: jobs/kill_test.sh [KILLS] [SEED]
#
# Kills one rank of a short run with -9 at KILLS random moments (default 20; SEED, default 1, chooses them), and at
# chosen ones: before anything is written, at step 0, during a checkpoint. After each, --restart latest must end in the
# same bits as a run that was left alone.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-20}" in
    -h | --help) print_help && exit 0 ;;
    *[!0-9]*) fail "KILLS must be a number, not '$1'; see --help" 2 ;;
  esac
  setup_program trevi
  TREVI_KILLS="${1:-20}" TREVI_KILL_SEED="${2:-1}" "$trevi_root/tests/regression/test_survival.py" Kill
}

main "$@"
