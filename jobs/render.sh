#!/usr/bin/env bash
# usage: jobs/render.sh SCRIPT RUN [more arguments of the script]
#        jobs/render.sh gallery [RUNS]
#
# Installs what is missing (with the build's packages: xvfb, ffmpeg, scipy) and starts SCRIPT, render.py or surface.py of
# postprocess/, with a virtual display. "gallery" makes all pictures of postprocess/results/report_figures.md and the film
# out/musical_fountain.mp4 from the runs in RUNS (default out/), after running the scenes that are not there, or going on
# with those that were cut short (minutes each). Pictures in postprocess/results/ are written over.
#
#   jobs/render.sh render.py out/fountain --time 4 --output fountain.png
#   jobs/render.sh render.py out/musical_fountain --sound inputs/ode_to_joy.wav --output fountain.mp4
#   jobs/render.sh surface.py out/musical_fountain --time 3.5 --output water.png
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
trevi_packages+=(xvfb xauth ffmpeg python3-scipy)

# show SCRIPT RUN ...: a script that draws, with a virtual display.
show() {
  local script="$1"
  shift
  xvfb-run -a /usr/bin/python3 "$trevi_root/postprocess/$script" "$@"
}

gallery() {
  local runs="$1" results=postprocess/results scene small=(--size 800 600)
  for scene in trevi_fountain musical_fountain fountain fountain_shapes fountain_heights constant_fountain falling_cube; do
    run_to_end "$runs/$scene" "$scene"
  done
  run_to_end "$runs/falling_cube_report" falling_cube --set 'density.preset="report"'
  show render.py "$runs/trevi_fountain" --time 3.0 --radius 0.034 --elevation 24 --azimuth -72 \
    --output $results/trevi_fountain.png --size 1080 760
  show render.py "$runs/musical_fountain" --time 2.6 --output $results/musical_fountain.png "${small[@]}"
  show render.py "$runs/fountain" --time 4.5 --output $results/fountain.png "${small[@]}"
  show render.py "$runs/fountain_shapes" --time 1.3 --elevation 18 --output $results/fountain_shapes.png "${small[@]}"
  show render.py "$runs/fountain_heights" --time 4.5 --output $results/fountain_heights.png "${small[@]}"
  show surface.py "$runs/musical_fountain" --time 2.6 --tint 0.85 \
    --output $results/musical_fountain_water.png "${small[@]}"
  show surface.py "$runs/fountain_shapes" --time 1.3 --elevation 18 \
    --output $results/fountain_shapes_water.png --size 720 540
  /usr/bin/python3 postprocess/plot_series.py "$runs/constant_fountain" --output $results/constant_fountain_density.png
  /usr/bin/python3 postprocess/plot_series.py "$runs/falling_cube" "$runs/falling_cube_report" \
    --output $results/falling_cube_density.png
  /usr/bin/python3 postprocess/jet_heights.py $results/jet_heights.png
  show render.py "$runs/musical_fountain" "${small[@]}" --sound inputs/ode_to_joy.wav --output out/musical_fountain.mp4
}

main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    render.py | surface.py) install_packages && show "$@" ;;
    gallery)
      cd "$trevi_root"
      install_packages
      mkdir -p out
      gallery "${2:-out}"
      ;;
    *) fail "the first argument is render.py, surface.py or gallery; see --help" 2 ;;
  esac
}

main "$@"
