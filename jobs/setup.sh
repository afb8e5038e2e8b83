#!/usr/bin/env bash
# Makes a Debian 12 or Ubuntu machine ready for Trevi and builds it.
# Called by itself it does all of it; sourced, it only defines the functions below, for the other scripts in jobs/.
set -euo pipefail

trevi_root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

# What a run and its plot need. Scripts that need more add it before they call install_packages or setup_program.
trevi_packages=(
  g++ cmake ninja-build pkg-config openmpi-bin libeigen3-dev libpetsc-real-dev libvtk9-dev
  libcli11-dev libfmt-dev libtomlplusplus-dev nlohmann-json3-dev libhwy-dev librandom123-dev libmuparser-dev libpng-dev
  libsndfile1-dev libzmq3-dev cppzmq-dev python3 python3-numpy python3-matplotlib python3-h5py
)
test_packages=(pybind11-dev python3-dev python3-mpi4py libgtest-dev libgmock-dev xvfb xdotool python3-pil python3-scipy)

fail() {
  echo "$(basename "$0"): $1" >&2
  exit "${2:-1}"
}

# The comment at the head of the calling script is its help text.
print_help() {
  sed -n '2,/^[^#]/{/^#/s/^# \{0,1\}//p}' "$0"
}

missing_packages() {
  local installed package
  installed=" $(dpkg-query -W -f='${db:Status-Status}:${Package} ' "${trevi_packages[@]}" 2>/dev/null || true)"
  for package in "${trevi_packages[@]}"; do
    [[ $installed == *" installed:$package "* ]] || echo "$package"
  done
}

install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    echo "No apt on this machine; taking it that these are there by other means: ${trevi_packages[*]}" >&2
    return
  fi
  local missing as_root=()
  mapfile -t missing < <(missing_packages)
  [[ ${#missing[@]} -gt 0 ]] || return 0
  echo "Installing ${missing[*]}"
  if [[ $(id -u) -ne 0 ]]; then
    # Without a terminal nobody can type a password, so sudo must not ask.
    [[ -t 0 ]] && as_root=(sudo) || as_root=(sudo -n)
    if ! command -v sudo >/dev/null || ! "${as_root[@]}" true; then
      fail "packages are missing and neither root nor sudo is at hand; ask an administrator for
  apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
    fi
  fi
  "${as_root[@]}" apt-get update </dev/null
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y --no-install-recommends "${missing[@]}" </dev/null
}

# More ranks than cores are fine for a trial; Open MPI refuses them, and root, unless told.
mpi_environment() {
  export OMPI_MCA_rmaps_base_oversubscribe=1
  # Halo messages between ranks of one machine are then copied out at once and fly while the interior is computed, also
  # when nobody polls (4 kB otherwise): a step of 96,000 particles on 2 ranks took 27.7 ms for 31.2 (medians of 4).
  export OMPI_MCA_btl_vader_eager_limit="${OMPI_MCA_btl_vader_eager_limit:-65536}"
  # Threads that wait then leave their core to other work of the machine. Where there was some, a step of 96,000 particles
  # on two threads took 59 to 73 ms for 120 to 370; where there was none, as long as with spinning.
  export OMP_WAIT_POLICY="${OMP_WAIT_POLICY:-passive}"
  if [[ $(id -u) -eq 0 ]]; then
    export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  fi
}

# Compilers at a time: one per core, but 1.5 GiB of free memory for each (VTK, Eigen), in a container's limit, too.
build_jobs() {
  local cores free_mib limit jobs
  cores="$(nproc)"
  free_mib="$(awk '/^MemAvailable:/ {print int($2 / 1024)}' /proc/meminfo)"
  limit="$(cat /sys/fs/cgroup/memory.max 2>/dev/null || echo max)"
  if [[ $limit =~ ^[0-9]+$ ]] && ((limit / 1048576 < free_mib)); then
    free_mib=$((limit / 1048576))
  fi
  jobs=$((free_mib / 1536))
  ((jobs < cores)) || jobs=$cores
  ((jobs > 0)) || jobs=1
  echo "$jobs"
}

# configure PRESET ON|OFF: with tests or without, where that is not how build/PRESET stands. A folder that has tests keeps
# them, and ninja itself sees to changed CMakeLists.txt, so that nothing is done twice.
configure() {
  local cache="build/$1/CMakeCache.txt" tests="$2"
  if grep -qs '^TREVI_TESTS:BOOL=ON' "$cache"; then tests=ON; fi
  if [[ -e build/$1/build.ninja && ! CMakePresets.json -nt build/$1/build.ninja ]] &&
    grep -qs "^TREVI_TESTS:BOOL=$tests" "$cache"; then
    return
  fi
  cmake --preset "$1" -DTREVI_TESTS="$tests"
}

# setup PRESET: packages, program, viewer and tests.
setup() {
  trevi_packages+=("${test_packages[@]}")
  install_packages
  mpi_environment
  (
    cd "$trevi_root"
    configure "$1" ON
    cmake --build --preset "$1" -j "$(build_jobs)"
  )
}

# setup_program TARGET...: what a run needs and no more; trevi, and trevi-view to look at it.
setup_program() {
  install_packages
  mpi_environment
  (
    cd "$trevi_root"
    configure release OFF
    # Nothing is said where nothing is to be done.
    cmake --build --preset release --target "$@" -- -n | grep -q "no work to do" ||
      cmake --build --preset release -j "$(build_jobs)" --target "$@"
  )
}

# run_to_end DIR SCENE ...: runs a scene of inputs/ into DIR, or goes on with what a stop or a crash left there.
run_to_end() {
  local output="$1" scene="$2" more=()
  if grep -qs '"exit_code": 0' "$output/run.json"; then return; fi
  [[ ! -e $output ]] || more=(--restart latest)
  "$trevi_root/jobs/run.sh" "inputs/$scene.toml" -- --output "$output" "${more[@]}" "${@:3}"
}

# study SCRIPT RESULTS ...: postprocess/study_SCRIPT.py, whose rows go to postprocess/results/RESULTS.csv; more arguments are
# its own.
study() {
  case "${3:-}" in -h | --help) print_help && exit 0 ;; esac
  trevi_packages+=(python3-h5py)
  setup_program trevi
  "$trevi_root/postprocess/study_$1.py" "$trevi_root/postprocess/results/$2.csv" "${@:3}"
}

# draw SCRIPT RESULTS: their drawing, by a script of postprocess/.
draw() {
  local results="$trevi_root/postprocess/results/$2"
  "$trevi_root/postprocess/$1" "$results.csv" "$results.png"
}

setup_main() {
  case "${1:-release}" in
    -h | --help)
      cat <<HELP
usage: jobs/setup.sh [PRESET]
       jobs/setup.sh --program

Installs with apt what is missing on Debian 12 or Ubuntu (as root or through sudo), then configures and builds
PRESET (release, debug, asan, tsan or profile; default release) in build/PRESET. --program: only what a run needs, and
only the program, in build/release.
HELP
      ;;
    --program) setup_program trevi ;;
    -*) fail "unknown option $1; see --help" 2 ;;
    *) setup "${1:-release}" ;;
  esac
}

if [[ ${BASH_SOURCE[0]} == "$0" ]]; then
  setup_main "$@"
fi
