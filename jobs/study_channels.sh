#!/usr/bin/env bash
# usage: jobs/study_channels.sh [more arguments of postprocess/study_channels.py]
#
# Flows through channels with open ends: some minutes on two cores. Writes postprocess/results/channels.csv.
set -euo pipefail
# shellcheck source=jobs/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

study channels channels "$@"
