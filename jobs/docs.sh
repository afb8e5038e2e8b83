#!/usr/bin/env bash
# usage: jobs/docs.sh
#
# Documentation of the library's interface, include/trevi, by Doxygen: build/docs/html/index.html. A warning is an error.
# Installs doxygen where it is missing.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

settings() {
  cat <<SETTINGS
PROJECT_NAME = Trevi
PROJECT_NUMBER = $(sed -n 's/^project(trevi VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
INPUT = include/trevi jobs/docs.md
USE_MDFILE_AS_MAINPAGE = jobs/docs.md
OUTPUT_DIRECTORY = build/docs
GENERATE_LATEX = NO
EXTRACT_ALL = YES
JAVADOC_AUTOBRIEF = YES
WARN_AS_ERROR = FAIL_ON_WARNINGS
QUIET = YES
HAVE_DOT = NO
SETTINGS
}

main() {
  case "${1:-}" in
    "") ;;
    -h | --help) print_help && exit 0 ;;
    *) fail "unknown argument $1; see --help" 2 ;;
  esac
  cd "$trevi_root"
  trevi_packages=(doxygen)
  install_packages
  mkdir -p build/docs
  settings | doxygen -
  echo "$trevi_root/build/docs/html/index.html"
}

main "$@"
