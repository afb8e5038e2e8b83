#!/usr/bin/env bash
# usage: jobs/paraview_modules.sh
#
# Makes ParaView ready for the test `paraview` (tests/regression/test_paraview.py) on Debian or Ubuntu: it installs paraview
# where that is missing, and unpacks its Python modules into build/paraview_modules.
# They are not installed, as python3-paraview cannot be beside the Python modules that libvtk9-dev brings.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  case "${1:-}" in
    "") ;;
    -h | --help) print_help && exit 0 ;;
    *) fail "unknown argument $1; see --help" 2 ;;
  esac
  trevi_packages=(paraview xvfb)
  install_packages
  local target="$trevi_root/build/paraview_modules"
  mkdir -p "$target"
  cd "$target"
  apt-get download python3-paraview
  dpkg-deb -x python3-paraview_*.deb .
  rm python3-paraview_*.deb
  echo "$target"
}

main "$@"
