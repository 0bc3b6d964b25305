#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs a configuration with the installed command, and checks that velocities came out of it. Returns 77 (skipped) if it needs recordings and
# WAYMARK_DATA is not set.
#   WAYMARK_PLUGIN_PATH=… ./run_configuration.sh WAYMARK CONFIGURATION OUT [options of waymark run]
set -eu
waymark=$1
configuration=$2
out=$3
shift 3
if [ -z "${WAYMARK_DATA:-}" ] && grep -q WAYMARK_DATA "$configuration"; then
  echo "skipped: WAYMARK_DATA is not set"
  exit 77
fi
"$waymark" run "$configuration" --out "$out" --quiet "$@"
rows=$(wc -l <"$out/poses.csv")
if [ "$rows" -lt 100 ]; then
  echo "$configuration: $rows rows in poses.csv; at least 100 are expected" >&2
  exit 1
fi
