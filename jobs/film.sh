#!/usr/bin/env bash
# usage: jobs/film.sh [RUNS]
#
# Films in 1080p of the three scenes with music: tutorial/5_music, tutorial/6_duet to the end of Ode to Joy, and
# musical_fountain, the last two with its melody as sound. Runs that are not in RUNS/film_NAME yet (default out/) are made first, or
# gone on with; the films are RUNS/NAME.mp4, 2 to 20 MB each. A quarter of an hour on two cores without a graphics card.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

# film RUNS SCENE END [arguments of render.py]
film() {
  local name
  name="$(basename "$2")"
  run_to_end "$1/film_$name" "$2" --set time.end="$3"
  jobs/render.sh render.py "$1/film_$name" --size 1920 1080 --crf 20 --output "$1/$name.mp4" "${@:4}"
}

main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    -*) fail "unknown argument $1; see --help" 2 ;;
  esac
  cd "$trevi_root"
  local runs="${1:-out}"
  mkdir -p "$runs"
  film "$runs" tutorial/5_music 3.0 --elevation 20
  film "$runs" tutorial/6_duet 17.0 --radius 0.045 --elevation 20 --sound inputs/ode_to_joy.wav
  film "$runs" musical_fountain 17.0 --sound inputs/ode_to_joy.wav
}

main "$@"
