#!/usr/bin/env bash
# usage: jobs/view.sh [arguments of trevi-view]
#
# Installs what is missing, builds trevi-view and starts it, with a virtual display where there is no screen. Without
# arguments it shows the newest run in out/.
#
#   jobs/view.sh                                          # what jobs/run.sh has just made
#   jobs/view.sh out/falling_cube                         # plays a finished or a running folder
#   jobs/view.sh inputs/fountain_small.toml               # starts a run and shows it as it computes
#   jobs/view.sh out/falling_cube --screenshot cube.png   # needs no hands and no screen
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    "")
      local newest
      newest="$(find "$trevi_root/out" -mindepth 2 -maxdepth 2 -name 'particles.*' -printf '%T@ %h\n' 2>/dev/null | sort -n |
        tail -n 1 | cut -d' ' -f2-)"
      [[ -n $newest ]] || fail "there is no run in out/ to look at; see --help" 2
      set -- "$newest"
      ;;
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
