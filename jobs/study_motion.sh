#!/usr/bin/env bash
# usage: jobs/study_motion.sh [more arguments of postprocess/study_motion.py]
#
# Water that moves as a whole, of which the answer is known: flight, jets, rotation, tanks at any angle, shear, vortices,
# large waves, full boxes, and volume by count: six minutes on two quiet cores. Writes postprocess/results/motion.csv.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study motion motion "$@"
