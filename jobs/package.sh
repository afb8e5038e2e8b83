#!/usr/bin/env bash
# usage: jobs/package.sh [--try]
#
# Builds Trevi in build/package (Release, without tests) and makes the Debian packages trevi and trevi-dev of it, in
# build/package/packages. With --try (as root; needs the network) it then makes a bare Debian 12 in a temporary folder,
# installs the package there with what it depends on and nothing else, and runs a small scene in it on 1 and 2 ranks.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

build_dir="$trevi_root/build/package"
mirror="${TREVI_MIRROR:-http://deb.debian.org/debian}"

make_packages() {
  cmake -S "$trevi_root" -B "$build_dir" -G Ninja -DCMAKE_BUILD_TYPE=Release -DTREVI_TESTS=OFF
  cmake --build "$build_dir" -j "$(build_jobs)"
  rm -rf "$build_dir/packages"
  (cd "$build_dir" && cpack -G DEB)
}

# What was mounted goes first, or the removal would reach into it.
take_down() {
  local place
  for place in dev/shm sys proc; do
    if mountpoint -q "$root/$place"; then umount "$root/$place" || umount -l "$root/$place"; fi
  done
  if grep -q " $root/" /proc/mounts; then
    echo "still mounted below $root; not removed" >&2
  else
    rm -rf "$root"
  fi
}

inside() {
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LC_ALL=C DEBIAN_FRONTEND=noninteractive \
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 "$@"
}

make_root() {
  mmdebstrap --mode=root --variant=minbase bookworm "$root" "$mirror"
  mkdir -p "$root/proc" "$root/sys" "$root/dev/shm"
  mount -t proc proc "$root/proc"
  mount -t sysfs -o ro sysfs "$root/sys" 2>/dev/null || echo "without /sys: Open MPI then counts cores otherwise" >&2
  mount -t tmpfs tmpfs "$root/dev/shm"
}

try_package() {
  [[ $(id -u) -eq 0 ]] || fail "--try needs root, for a root file system of its own"
  command -v mmdebstrap >/dev/null || apt-get install -y --no-install-recommends mmdebstrap
  root="$(mktemp -d -p "${TMPDIR:-/tmp}" trevi_debian.XXXXXX)"
  trap take_down EXIT
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
  install_packages
  make_packages
  ls -l "$build_dir"/packages/*.deb
  [[ $try == no ]] || try_package
}

main "$@"
