#!/usr/bin/env bash
# usage: jobs/study_stability.sh [more arguments of postprocess/study_stability.py]
#
# The stress cases of inputs/stress with the report's preset, with the default (20 s of simulated time each) and with
# densities from Poly6: some 10 minutes on two cores.
# Writes postprocess/results/stability.csv and its drawing.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study stability stability "$@"
draw stability_matrix.py stability
