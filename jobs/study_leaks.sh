#!/usr/bin/env bash
# usage: jobs/study_leaks.sh [more arguments of postprocess/study_leaks.py]
#
# A ball, a torus and a jug that are filled and shaken at 10 m/s and 20 g for 10 s, and 100 m/s against a sheet one
# spacing thick: some minutes. Writes postprocess/results/leaks.csv; fails where a particle got out.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study leaks leaks "$@"
