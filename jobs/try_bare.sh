#!/usr/bin/env bash
# usage: jobs/try_bare.sh [SCENE]
#
# What a newcomer waits for: in a bare Debian 12 of its own (jobs/bare_root.sh; as root, needs the network), the time of the
# first jobs/run.sh SCENE (default inputs/falling_cube.toml), which installs packages, builds and runs; of the same with the
# packages there, but nothing built; and of a run of one step after that, which is the start of any further one.
set -euo pipefail
# shellcheck source=jobs/bare_root.sh
source "$(dirname "${BASH_SOURCE[0]}")/bare_root.sh"

# timed WHAT ARGUMENTS...: of jobs/run.sh; what it says goes to a file.
timed() {
  local what="$1" log from
  shift
  log="$(mktemp)"
  from="$(date +%s%N)"
  inside env --chdir=/trevi jobs/run.sh "$@" >"$log" 2>&1 </dev/null || { tail -n 20 "$log" >&2 && fail "$what: failed"; }
  printf '%-30s %6.1f s\n' "$what" "$((($(date +%s%N) - from) / 10000000))e-2"
  rm "$log"
}

main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    -*) fail "unknown argument $1; see --help" 2 ;;
  esac
  local scene="${1:-inputs/falling_cube.toml}"
  make_root >/dev/null 2>&1
  copy_project
  timed "packages, build, run" "$scene"
  rm -rf "$root/trevi/build"
  timed "build, run" "$scene"
  timed "one step, all being there" "$scene" -- --steps 1
}

main "$@"
