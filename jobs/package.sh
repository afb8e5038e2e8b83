#!/usr/bin/env bash
# usage: jobs/package.sh [--try]
#
# Builds Trevi in build/package (Release, without tests) and makes the Debian packages trevi, trevi-dev and
# python3-trevi of it, in build/package/packages. With --try (as root; needs the network) it then makes a bare Debian 12 in a temporary folder,
# installs the package there with what it depends on and nothing else, and runs a small scene in it on 1 and 2 ranks.
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
  cp "$build_dir"/packages/python3-trevi_*.deb "$root/tmp/"
  inside sh -c 'apt-get install -qy --no-install-recommends /tmp/python3-trevi_*.deb'
  inside python3 -c 'import trevi; s = trevi.make_solver(trevi.read_scene("/usr/share/trevi/inputs/falling_cube_small.toml")); s.run(steps=5); print(s.time)'
  echo "The package runs in a bare Debian 12 on 1 and 2 ranks, with the same results."
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
