#!/usr/bin/env bash
# usage: jobs/lint.sh [--no-tidy] [C++ FILE ...]
#
# Checks the house rules: clang-format, clang-tidy, shellcheck (when present) the layers and the words. All C++ files of the
# project, or only those named; --no-tidy leaves out the slow part. Exits 1 when any check fails, after doing all.
#   apt-get install -y --no-install-recommends clang-format clang-tidy shellcheck
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

# Tracked files, and new ones that git does not ignore, that are still there.
project_files() {
  git ls-files --cached --others --exclude-standard -- "$@" | while read -r file; do
    [[ ! -e $file ]] || echo "$file"
  done
}

# tidy FILE...: the sources among the files; headers are checked through the sources that include them.
tidy() {
  local sources
  cmake --preset release -B build/tidy -DCMAKE_UNITY_BUILD=OFF >/dev/null || return 1
  mapfile -t sources < <(printf '%s\n' "$@" | grep '\.cpp$' | while read -r file; do
    if grep -q "\"file\": \".*/$file\"" build/tidy/compile_commands.json; then
      echo "$file"
    else
      echo "not built by preset release, so not checked by clang-tidy: $file" >&2
    fi
  done)
  [[ ${#sources[@]} -gt 0 ]] || return 0
  printf '%s\0' "${sources[@]}" |
    xargs -0 -n 1 -P "$(build_jobs)" clang-tidy --quiet -p build/tidy --extra-arg=-Wno-unknown-warning-option \
      --extra-arg=-Wno-ignored-optimization-argument \
      2> >(grep -v 'warnings\? generated\|warnings\? and [0-9]* errors\? generated' >&2)
}

main() {
  local with_tidy=yes failed=0 files=() scripts tool
  cd "$trevi_root"
  while [[ $# -gt 0 ]]; do
    case "$1" in
      -h | --help) print_help && exit 0 ;;
      --no-tidy) with_tidy=no ;;
      -*) fail "unknown option $1; see --help" 2 ;;
      *) files+=("$1") ;;
    esac
    shift
  done
  [[ ${#files[@]} -gt 0 ]] || mapfile -t files < <(project_files '*.hpp' '*.cpp')
  for tool in clang-format clang-tidy; do
    command -v "$tool" >/dev/null || fail "$tool is missing: apt-get install -y --no-install-recommends $tool"
  done
  echo "== clang-format"
  clang-format --dry-run -Werror "${files[@]}" || failed=1
  echo "== layering"
  /usr/bin/python3 tests/layering.py || failed=1
  if command -v shellcheck >/dev/null; then
    echo "== shellcheck"
    mapfile -t scripts < <(project_files 'jobs/*.sh' .ci/run)
    shellcheck -x "${scripts[@]}" || failed=1
  fi
  if [[ $with_tidy == yes ]]; then
    echo "== clang-tidy"
    tidy "${files[@]}" || failed=1
  fi
  if [[ $failed -eq 0 ]]; then
    echo "all checks passed"
  else
    fail "some checks failed"
  fi
}

main "$@"
