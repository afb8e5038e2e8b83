#!/usr/bin/env bash
# usage: jobs/study_waves.sh [more arguments of postprocess/study_waves.py]
#
# Regular, irregular and solitary waves by paddles in a thin tank: some half an hour on two cores. Writes
# postprocess/results/waves.csv.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study waves waves "$@"
