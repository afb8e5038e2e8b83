#!/usr/bin/env bash
# usage: jobs/package.sh [--try]
#
# Builds Trevi in build/package (Release, without tests) and makes the Debian packages trevi, trevi-dev and
# python3-trevi of it, in build/package/packages. With --try (as root; needs the network) it then makes a bare Debian 12 in
# a temporary folder, installs the packages there with what they depend on and nothing else, and runs a small scene on 1 and
# 2 ranks by the program and in Python, and the example of a program that uses the library.
set -euo pipefail
# shellcheck source=jobs/bare_root.sh
source "$(dirname "${BASH_SOURCE[0]}")/bare_root.sh"

build_dir="$trevi_root/build/package"

make_packages() {
  cmake -S "$trevi_root" -B "$build_dir" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTREVI_TESTS=OFF
  cmake --build "$build_dir" -j "$(build_jobs)"
  rm -rf "$build_dir/packages"
  (cd "$build_dir" && cpack -G DEB)
}

try_package() {
  make_root
  cp "$build_dir"/packages/trevi_*.deb "$root/tmp/"
  inside sh -c 'apt-get update -q && apt-get install -qy --no-install-recommends /tmp/trevi_*.deb'
  local ranks
  for ranks in 1 2; do
    inside mpirun -np "$ranks" trevi /usr/share/trevi/inputs/falling_cube_small.toml --steps 5 --progress none \
      --output "/tmp/on_$ranks"
    inside grep -E '"(exit_reason|ranks|last_step)"' "/tmp/on_$ranks/run.json"
  done
  # All columns but the last two, imbalance and wall_seconds, are the same on any rank count.
  [[ $(inside sh -c 'cut -d, -f1-25 /tmp/on_1/series.csv | md5sum') == \
    $(inside sh -c 'cut -d, -f1-25 /tmp/on_2/series.csv | md5sum') ]] || fail "1 and 2 ranks differ"
  try_python
  try_library
  echo "The packages run in a bare Debian 12 on 1 and 2 ranks, with the same results."
}

# The module on 1 and 2 ranks: momentum to the last bit, as the series of the program has it.
try_python() {
  local script='
import trevi
solver = trevi.make_solver(trevi.read_scene("/usr/share/trevi/inputs/falling_cube_small.toml"), rows=1)
solver.run(steps=5)
if solver.rank == 0:
    print(*(solver.series["momentum_" + axis][-1].hex() for axis in "xyz"), len(solver.positions) > 0)
'
  cp "$build_dir"/packages/python3-trevi_*.deb "$root/tmp/"
  inside sh -c 'apt-get install -qy --no-install-recommends /tmp/python3-trevi_*.deb'
  [[ $(inside mpirun -np 1 python3 -c "$script") == "$(inside mpirun -np 2 python3 -c "$script")" ]] ||
    fail "1 and 2 ranks differ in Python"
  inside python3 -c "$script"
}

# A program that is built against the library.
try_library() {
  cp "$build_dir"/packages/trevi-dev_*.deb "$root/tmp/"
  inside sh -c 'apt-get install -qy --no-install-recommends /tmp/trevi-dev_*.deb g++ cmake make'
  inside sh -c 'cmake -S /usr/share/trevi/examples/embed -B /tmp/embed >/dev/null && cmake --build /tmp/embed'
  inside mpirun -np 2 /tmp/embed/embed
}

main() {
  local try=no
  while [[ $# -gt 0 ]]; do
    case "$1" in
      -h | --help) print_help && exit 0 ;;
      --try) try=yes && shift ;;
      *) fail "unknown argument $1; see --help" 2 ;;
    esac
  done
  trevi_packages+=(pybind11-dev python3-dev)
  install_packages
  make_packages
  ls -l "$build_dir"/packages/*.deb
  [[ $try == no ]] || try_package
}

main "$@"
