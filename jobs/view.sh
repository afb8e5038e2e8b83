#!/usr/bin/env bash
# usage: jobs/view.sh [arguments of trevi-view]
#
# Installs what is missing, builds trevi-view and starts it, with a virtual display where there is no screen.
#
#   jobs/view.sh out/falling_cube                         # plays a finished or a running folder
#   jobs/view.sh inputs/fountain_small.toml               # starts a run and shows it as it computes
#   jobs/view.sh out/falling_cube --screenshot cube.png   # needs no hands and no screen
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    "") fail "what to look at is missing; see --help" 2 ;;
  esac
  local screen=()
  if [[ -z ${DISPLAY:-} ]]; then
    trevi_packages+=(xvfb xauth)
    screen=(xvfb-run -a)
  fi
  setup_program trevi trevi-view
  exec "${screen[@]}" "$trevi_root/build/release/trevi-view" "$@"
}

main "$@"
