#!/usr/bin/env bash
# usage: jobs/film.sh [RUNS]
#
# Films in 1080p with their sound of the three scenes that play Ode to Joy or a tune: tutorial/5_music, tutorial/6_duet and
# musical_fountain, from the runs in RUNS (default out/), after running the scenes that are not there. They are left there
# as NAME.mp4, 1 to 15 MB each; minutes without a graphics card.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

# film RUNS SCENE [arguments of render.py]
film() {
  local place
  place="$1/$(basename "$2")"
  if ! grep -qs '"exit_code": 0' "$place/run.json"; then
    jobs/run.sh "inputs/$2.toml" -- --output "$place"
  fi
  jobs/render.sh render.py "$place" --size 1920 1080 --crf 20 --output "$place.mp4" "${@:3}"
}

main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    -*) fail "unknown argument $1; see --help" 2 ;;
  esac
  cd "$trevi_root"
  local runs="${1:-out}"
  mkdir -p "$runs"
  film "$runs" tutorial/5_music --elevation 20
  film "$runs" tutorial/6_duet --radius 0.045 --elevation 20 --sound inputs/ode_to_joy.wav
  film "$runs" musical_fountain --sound inputs/ode_to_joy.wav
}

main "$@"
