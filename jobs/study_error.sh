#!/usr/bin/env bash
# usage: jobs/study_error.sh [more arguments of postprocess/study_error.py]
#
# Errors against run time of all density methods: some 8 minutes on one core, which should have nothing else to do.
# Writes postprocess/results/error_against_run_time.csv and its drawing.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study error error_against_run_time "$@"
draw work_precision.py error_against_run_time
