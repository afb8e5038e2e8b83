#!/usr/bin/env bash
# usage: jobs/walk_tutorial.sh DIR
#
# Walks README's first screen and the tutorial as a newcomer would, in a bare Debian 12 of its own (jobs/bare_root.sh; as
# root, needs the network): runs all scenes of the tutorial with a picture of each, then every command of the page in its
# order (those of Slurm left out, ParaView installed but not started), and puts pictures and films into DIR to be
# looked at. Fails where a command does, and where ParaView has removed what setup.sh installed.
set -euo pipefail
# shellcheck source=jobs/bare_root.sh
source "$(dirname "${BASH_SOURCE[0]}")/bare_root.sh"

readonly page="inputs/tutorial/README.md"

# step COMMAND...: what it says goes to a log in DIR.
step() {
  printf '%s\n' "$*"
  { printf '\n$ %s\n' "$*" && inside env --chdir=/trevi bash -c "$*"; } >>"$pictures/log.txt" 2>&1 </dev/null ||
    { tail -n 20 "$pictures/log.txt" >&2 && fail "$*: failed"; }
}

walk() {
  local scene name command
  step jobs/run.sh inputs/fountain_small.toml
  for scene in "$trevi_root"/inputs/tutorial/*.toml; do
    name="$(basename "$scene" .toml)"
    step "jobs/run.sh inputs/tutorial/$name.toml"
    step "jobs/render.sh render.py out/$name --time 0.5 --output $name.png"
  done
  while IFS= read -r command; do
    case "$command" in
      sbatch* | paraview*) ;;
      jobs/run.sh*toml) ;; # the scenes, run above
      *) step "$command" ;;
    esac
  done < <(sed -n 's/^    \([a-z].*\)$/\1/p' "$trevi_root/$page")
  step apt-get install -y --no-install-recommends paraview
  step dpkg -s libvtk9-dev python3-vtk9
}

main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    "" | -*) fail "DIR is missing; see --help" 2 ;;
  esac
  mkdir -p "$1"
  pictures="$(cd "$1" && pwd)"
  : >"$pictures/log.txt"
  make_root >>"$pictures/log.txt" 2>&1
  copy_project
  trap 'cp "$root"/trevi/*.png "$root"/trevi/*.mp4 "$pictures" || true; take_down_root' EXIT
  walk
}

main "$@"
