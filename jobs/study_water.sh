#!/usr/bin/env bash
# usage: jobs/study_water.sh [more arguments of postprocess/study_water.py]
#
# Waves, pools at rest, wells, momentum and viscosity against the marks that water must meet: some 7 minutes on two
# cores.
# Writes postprocess/results/water.csv and its drawing.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study water water "$@"
draw plot_water.py water
