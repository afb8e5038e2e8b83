#!/usr/bin/env bash
# usage: jobs/gallery.sh [SCENE ...] [--runs RUNS]
#
# Runs the scenes of inputs/gallery, all of them or those that are named, and makes their pictures and films anew:
# postprocess/results/gallery/SCENE.webp. Runs that are in RUNS (default out/gallery) are not made again. On two cores each
# scene takes up to twelve minutes, its picture half a minute, and a film up to ten.
#
#   jobs/gallery.sh
#   jobs/gallery.sh vortex drop
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
trevi_packages+=(xvfb xauth python3-scipy python3-pil)

# How each picture is taken: the script, the time (s), or times of a film, and where the camera looks at.
declare -A pictures=(
  [stone_fountain]="surface.py --time 3.5 --azimuth -72 --elevation 22 --box -4.8 -3.1 0 4.8 3.1 6.1"
  [breaking_wave]="surface.py --times 3.0 4.12 --slow 1.5 --azimuth -58 --elevation 9 --box 16.6 0 0.8 20 1.2 2.2"
  [dam_and_pillar]="surface.py --time 0.85 --azimuth -55 --elevation 16 --box 0.2 0 0 5.4 2.88 1.7"
  [vortex]="surface.py --time 2.75 --azimuth -60 --elevation 46 --box -1.3 -1.3 0.9 1.3 1.3 2.3"
  [spout]="surface.py --time 2.0 --azimuth -62 --elevation 14 --box 0 -1.1 0.1 3.6 1.1 1.9"
  [weir]="surface.py --time 3.5 --azimuth -52 --elevation 20 --box 0.6 0 0 7.6 2.6 1.3"
  [drop]="surface.py --times 0.06 0.8 --slow 2 --azimuth -105 --elevation 18 --box 0.9 0.9 0.2 2.7 2.7 1.1"
  [rainbow_cube]="render.py --times 0 0.92 --slow 2 --elevation 20 --box 0.2 0.2 0 6.8 6.8 4.1"
)
scenes=(stone_fountain breaking_wave dam_and_pillar vortex spout weir drop rainbow_cube)

# picture SCENE RUN
picture() {
  local words script light=() size=(960 640)
  read -ra words <<<"${pictures[$1]}"
  script="${words[0]}"
  [[ $script != surface.py ]] || light=(--light day)
  [[ ${words[1]} != --times ]] || size=(600 400)
  xvfb-run -a /usr/bin/python3 "postprocess/$script" "$2" --size "${size[@]}" "${light[@]}" "${words[@]:1}" \
    --output "postprocess/results/gallery/$1.webp"
}

main() {
  local runs=out/gallery chosen=() scene
  while [[ $# -gt 0 ]]; do
    case "$1" in
      -h | --help) print_help && exit 0 ;;
      --runs) [[ $# -gt 1 ]] || fail "--runs wants a folder" 2 && runs="$2" && shift ;;
      *) [[ -n ${pictures[$1]:-} ]] || fail "$1 is no scene of the gallery; they are ${scenes[*]}" 2 && chosen+=("$1") ;;
    esac
    shift
  done
  cd "$trevi_root"
  install_packages
  mkdir -p "$runs"
  [[ ${#chosen[@]} -gt 0 ]] || chosen=("${scenes[@]}")
  for scene in "${chosen[@]}"; do
    run_to_end "$runs/$scene" "gallery/$scene"
    picture "$scene" "$runs/$scene"
  done
}

main "$@"
