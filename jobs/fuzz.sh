#!/usr/bin/env bash
# usage: jobs/fuzz.sh [SECONDS]
#
# Feeds the readers of scenes, HDF5 files, viewer messages and music with random changes of the files in
# tests/regression/corpus, SECONDS each (default 60), under the address and undefined-behaviour sanitizers. Needs clang
# with libFuzzer (apt: clang). Exits 1 when a reader crashes or hangs, or the scene reader leaks; the input that did it is
# then in build/fuzz/findings. What it learns stays in build/fuzz/corpus for the next time.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

build_targets() {
  cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_COMPILER=clang++ \
    -DCMAKE_C_COMPILER=clang -DTREVI_FUZZ=ON -DTREVI_WITH_VTK=OFF >/dev/null
  cmake --build build/fuzz -j "$(build_jobs)" --target fuzz_scene fuzz_checkpoint fuzz_messages fuzz_music
}

# fuzz SUBJECT SECONDS: ends with the coverage (cov: edges of our code) and libFuzzer's figures.
fuzz() {
  local log="build/fuzz/$1.log"
  mkdir -p "build/fuzz/corpus/$1" build/fuzz/findings
  echo "== $1, $2 s"
  "build/fuzz/tests/fuzz_$1" "build/fuzz/corpus/$1" "tests/regression/corpus/$1" -max_total_time="$2" -max_len=32768 \
    -timeout=20 -rss_limit_mb=4096 -artifact_prefix="build/fuzz/findings/$1-" -print_final_stats=1 -print_funcs=0 \
    >"$log" 2>&1 || fail "found something; the end of $log:
$(tail -n 60 "$log")"
  grep -E '\bDONE\b|^stat::' "$log"
}

main() {
  case "${1:-60}" in
    -h | --help) print_help && exit 0 ;;
    *[!0-9]*) fail "SECONDS must be a number, not '$1'; see --help" 2 ;;
  esac
  cd "$trevi_root"
  command -v clang++ >/dev/null || fail "clang++ is missing: apt-get install -y --no-install-recommends clang"
  mpi_environment
  build_targets
  fuzz scene "${1:-60}"
  # HDF5 itself forgets a few kilobytes when it gives up on a damaged object.
  ASAN_OPTIONS=detect_leaks=0 fuzz checkpoint "${1:-60}"
  fuzz messages "${1:-60}"
  fuzz music "${1:-60}"
  echo "nothing found"
}

main "$@"
