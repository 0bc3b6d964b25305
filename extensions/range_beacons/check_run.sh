#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs a configuration and fails if the error against its reference is larger than a bound. Skipped (77) without the recording.
#   check_run.sh WAYMARK CONFIG OUT rms|mean BOUND_M [OPTION of run …]
set -eu
waymark=$1 config=$2 out=$3 figure=$4 bound=$5
shift 5
if grep -q WAYMARK_DATA "$config" && [ -z "${WAYMARK_DATA:-}" ]; then
  echo "skipped: WAYMARK_DATA is not set"
  exit 77
fi
"$waymark" run "$config" --out "$out" --quiet "$@"
"$waymark" evaluate "$out" --align se2 | tee "$out/evaluation.txt"
awk -v figure="$figure" -v bound="$bound" '
  /position error/ && value == "" { for (i = 1; i < NF; ++i) if ($i == figure) value = $(i + 1) }
  END { if (value == "" || value + 0 > bound + 0) { print figure " " value " m; expected at most " bound; exit 1 } }' "$out/evaluation.txt"
