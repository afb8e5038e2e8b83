#!/usr/bin/env bash
# usage: jobs/neon.sh [CASE...]
#
# Whether Trevi computes the same bits on 64-bit Arm, with the pair loops on NEON: compiles it across, runs it in qemu
# and compares with the hashes of tests/regression/golden.txt, which were written on x86; all cases of that file, or only
# those named, on a few numbers of ranks x threads (TREVI_GOLDEN_SHAPES), after the test of the pair sums. Needs no Arm processor.
# Exits 1 on a difference.
#
# Installs g++-aarch64-linux-gnu, qemu-user-static and mmdebstrap where they are missing. Debian 12's libraries for Arm
# are unpacked in build/neon/root (0.9 GB) and nowhere else: the machine's own packages stay as they are. Ranks are
# started by the machine's own mpirun, which is to be Debian 12's, too. Without VTK, viewer, sound files and live
# viewing. Takes 13 minutes on 2 cores, later 7; to begin anew remove build/neon.
#
#   jobs/neon.sh
#   jobs/neon.sh dam_break_small everything_double_jacobi
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

mirror="${TREVI_MIRROR:-http://deb.debian.org/debian}"
build_dir="$trevi_root/build/neon"
root="$build_dir/root"
triplet=aarch64-linux-gnu
libraries="$root/usr/lib/$triplet"
packages_of_root=(
  libopenmpi-dev libeigen3-dev libpetsc-real-dev libhdf5-openmpi-dev libcli11-dev libfmt-dev libtomlplusplus-dev
  nlohmann-json3-dev libhwy-dev librandom123-dev libmuparser-dev libpng-dev libgtest-dev libgmock-dev libgomp1
)

# Packages are unpacked, not installed: nothing of them has to run. What their scripts would have done for us follows.
make_root() {
  echo "Unpacking Debian 12's arm64 libraries in $root"
  rm -rf "$root" "$root.new"
  mkdir -p "$root.new"
  mmdebstrap --quiet --variant=extract --architectures=arm64 --components=main --format=tar \
    --hook-dir=/usr/share/mmdebstrap/hooks/merged-usr --aptopt='APT::Install-Recommends "false"' \
    --include="${packages_of_root[*]}" bookworm - "$mirror" |
    tar --extract --directory "$root.new" --exclude ./dev --no-same-owner
  make_links "$root.new"
  mv "$root.new" "$root"
}

make_links() { # ROOT
  local link target name
  find "$1" -type l -lname '/*' -printf '%P\n' | while read -r link; do
    target="$(readlink "$1/$link")"
    [[ ! -e $1$target ]] || ln -sfnr "$1$target" "$1/$link"
  done
  for name in blas lapack; do
    ln -sr "$1/usr/lib/$triplet/$name/lib$name.so.3" "$1/usr/lib/$triplet/"
  done
}

write_toolchain() {
  local petsc=("$root"/usr/lib/petscdir/*/"$triplet-real")
  cat >"$build_dir/toolchain.cmake" <<TOOLCHAIN
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER $triplet-gcc)
set(CMAKE_CXX_COMPILER $triplet-g++)
set(CMAKE_SYSROOT "$root")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(ENV{PKG_CONFIG_SYSROOT_DIR} "$root")
set(ENV{PKG_CONFIG_LIBDIR} "$libraries/pkgconfig:$root/usr/share/pkgconfig:${petsc[0]}/lib/pkgconfig")
# The machine's own mpicxx would tell where its own Open MPI is.
set(MPI_SKIP_COMPILER_WRAPPER ON)
set(MPI_CXX_SKIP_MPICXX ON)
set(MPI_mpi_LIBRARY "$libraries/openmpi/lib/libmpi.so")
foreach(language C CXX)
  set(MPI_\${language}_LIB_NAMES mpi)
  set(MPI_\${language}_HEADER_DIR "$libraries/openmpi/include")
endforeach()
TOOLCHAIN
}

compile() {
  write_toolchain
  cmake -S "$trevi_root" -B "$build_dir" -G Ninja -DCMAKE_BUILD_TYPE=Release \
    -DCMAKE_TOOLCHAIN_FILE="$build_dir/toolchain.cmake" -DTREVI_WITH_VTK=OFF -DTREVI_WITH_VIEW=OFF \
    -DTREVI_WITH_SOUND=OFF -DTREVI_WITH_LIVE=OFF
  cmake --build "$build_dir" -j "$(build_jobs)" --target trevi test_pair_sums
}

# A program of the same name that runs the one for Arm in qemu, so that tests and mpirun need not know.
stand_in() { # PROGRAM
  local script="$build_dir/in_qemu/${1##*/}"
  mkdir -p "$build_dir/in_qemu"
  printf '#!/bin/sh\nexec qemu-aarch64-static -L "%s" "%s" "$@"\n' "$root" "$1" >"$script"
  chmod +x "$script"
  echo "$script"
}

main() {
  [[ ${1:-} != -h && ${1:-} != --help ]] || { print_help && exit 0; }
  [[ ${1:-} != -* ]] || fail "unknown option $1; see --help" 2
  trevi_packages+=(g++-aarch64-linux-gnu qemu-user-static mmdebstrap)
  install_packages
  mpi_environment
  mkdir -p "$build_dir"
  [[ -d $root ]] || make_root
  compile
  local failed=0
  timeout 1200 "$(stand_in "$build_dir/tests/test_pair_sums")" || failed=1
  TREVI_WITHOUT="VTK SOUND LIVE" TREVI_TEST_TIME_LIMIT=1800 TREVI_GOLDEN_CASES="$*" \
    TREVI_GOLDEN_SHAPES="${TREVI_GOLDEN_SHAPES:-1x2 5x1 3x2 2x1}" \
    "$trevi_root/tests/regression/test_golden.py" "$(stand_in "$build_dir/trevi")" mpirun Golden.test_bits || failed=1
  [[ $failed -eq 0 ]] || fail "NEON gives other bits, or fails"
  echo "NEON gives the bits of golden.txt."
}

main "$@"
