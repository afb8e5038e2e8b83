#!/usr/bin/env bash
# usage: jobs/cluster/try_definition.sh
#
# Does without Apptainer what trevi.def says: copies its %files into a bare Debian 12 (jobs/bare_root.sh; as root, needs
# the network), and runs its %post and %test there.
set -euo pipefail
# shellcheck source=jobs/bare_root.sh
source "$(dirname "${BASH_SOURCE[0]}")/../bare_root.sh"

section() { sed -n "/^%$1/,/^%/{/^%/d;p}" "$trevi_root/jobs/cluster/trevi.def"; }

main() {
  case "${1:-}" in
    "") ;;
    -h | --help) print_help && exit 0 ;;
    *) fail "unknown argument $1; see --help" 2 ;;
  esac
  local from to part
  make_root
  mkdir -p "$root/opt/trevi"
  while read -r from to; do
    [[ -z $from ]] || cp -r "$trevi_root/$from" "$root$to"
  done < <(section files)
  for part in post test; do
    section "$part" >"$root/tmp/$part"
    inside sh -e "/tmp/$part"
    echo "%$part went well"
  done
}

main "$@"
