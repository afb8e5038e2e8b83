#!/usr/bin/env bash
# usage: jobs/study_bodies.sh [more arguments of postprocess/study_bodies.py]
#
# Bodies that float, against theory: heave, roll, draught, a light ball, free fall, a raft: some 5 minutes on one core.
# Writes postprocess/results/bodies.csv and bodies.png.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study bodies bodies "$@"
