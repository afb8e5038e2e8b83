#!/usr/bin/env bash
# usage: jobs/bare_root.sh COMMAND...
#
# Runs COMMAND in a bare Debian 12 (mmdebstrap, minbase) of its own in a temporary folder, where a copy of what is committed
# is the working folder, and removes it. As root; needs the network. Sourced, it only defines the functions below.
#   jobs/bare_root.sh jobs/run.sh inputs/falling_cube_small.toml
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

mirror="${TREVI_MIRROR:-http://deb.debian.org/debian}"

# What was mounted goes first, or the removal would reach into it.
take_down_root() {
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

# Sets root, which goes when the script ends.
make_root() {
  [[ $(id -u) -eq 0 ]] || fail "a root file system of its own needs root"
  command -v mmdebstrap >/dev/null || apt-get install -y --no-install-recommends mmdebstrap
  root="$(mktemp -d -p "${TMPDIR:-/tmp}" trevi_debian.XXXXXX)"
  trap take_down_root EXIT
  mmdebstrap --mode=root --variant=minbase bookworm "$root" "$mirror"
  mkdir -p "$root/proc" "$root/sys" "$root/dev/shm"
  cp /etc/hosts "$root/etc/hosts" # mpirun looks its own machine up, and would wait for a name server
  mount -t proc proc "$root/proc"
  mount -t sysfs -o ro sysfs "$root/sys" 2>/dev/null || echo "without /sys: Open MPI then counts cores otherwise" >&2
  mount -t tmpfs tmpfs "$root/dev/shm"
}

copy_project() {
  mkdir -p "$root/trevi"
  git -C "$trevi_root" archive HEAD | tar -x -C "$root/trevi"
}

bare_root_main() {
  case "${1:-}" in
    -h | --help) print_help && exit 0 ;;
    "" | -*) fail "COMMAND is missing; see --help" 2 ;;
  esac
  make_root
  copy_project
  inside env --chdir=/trevi "$@"
}

if [[ ${BASH_SOURCE[0]} == "$0" ]]; then
  bare_root_main "$@"
fi
