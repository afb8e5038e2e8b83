#!/usr/bin/env bash
# usage: jobs/study_vessels.sh [more arguments of postprocess/study_vessels.py]
#
# Water at rest in boxes, a sphere, cylinders, a cone, a torus and over a hill, beside the plain box: some 15 minutes on
# two cores. Writes postprocess/results/vessels.csv.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study vessels vessels "$@"
