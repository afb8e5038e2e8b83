#!/usr/bin/env bash
# usage: jobs/test.sh [--quick] [--preset PRESET] [--label REGEX] [--instruction-set NAME] [more arguments of ctest]
#
# Installs what is missing, builds PRESET (default release) and runs all tests, or those with a matching label; with
# the instruction set of the pair loops that is named (SSE4, AVX2 or AVX-512, say) in place of the best.
#
# --quick: unit tests, MPI tests on one rank and the bits of three scenes, one minute on two cores once it is built.
#
#   jobs/test.sh
#   jobs/test.sh --quick
#   jobs/test.sh --preset asan --label unit
#   jobs/test.sh --preset tsan --label '^unit$|^mpi$'
#   jobs/test.sh -R halo --verbose
#   jobs/test.sh --instruction-set AVX2
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

main() {
  local preset=release arguments=()
  while [[ $# -gt 0 ]]; do
    case "$1" in
      -h | --help) print_help && exit 0 ;;
      --preset) preset="${2:?--preset needs a name}" && shift 2 ;;
      --preset=*) preset="${1#*=}" && shift ;;
      --quick) arguments+=(-L '^quick$') && shift ;;
      --label) arguments+=(-L "${2:?--label needs a pattern}") && shift 2 ;;
      --label=*) arguments+=(-L "${1#*=}") && shift ;;
      --instruction-set) export TREVI_TEST_INSTRUCTION_SET="${2:?--instruction-set needs a name}" && shift 2 ;;
      *) arguments+=("$1") && shift ;;
    esac
  done
  # All of its runs are among those of `golden`.
  [[ ${#arguments[@]} -gt 0 ]] || arguments=(-E '^golden_quick$')
  setup "$preset"
  # Several mpiruns at a time would all bind to the first cores and starve each other.
  export OMPI_MCA_hwloc_base_binding_policy=none
  # MPI keeps memory until the process ends; that is not a leak of ours. The names in the list are found on whole stacks.
  export ASAN_OPTIONS="${ASAN_OPTIONS:-fast_unwind_on_malloc=0}"
  export LSAN_OPTIONS="${LSAN_OPTIONS:-suppressions=$trevi_root/tests/lsan.supp:print_suppressions=0}"
  # Each test sets PROCESSORS, so that ctest does not start more ranks than -j at a time; two a core, as many tests wait.
  ctest --test-dir "$trevi_root/build/$preset" --output-on-failure --no-tests=error -j "$(($(nproc) * 2))" "${arguments[@]}"
}

main "$@"
