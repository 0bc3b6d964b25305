#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs a configuration with the installed command, and checks that it drew a map. Returns 77 (skipped) if it needs what is not there: recordings
# and WAYMARK_DATA, or the source of extensions/radar in the folder of its build: RADAR_PLUGINS, or radar below EXTENSION_BUILDS.
#   WAYMARK_PLUGIN_PATH=… ./run_configuration.sh WAYMARK CONFIGURATION MAP OUT
set -eu
waymark=$1
configuration=$2
map=$3
out=$4
if [ -z "${WAYMARK_DATA:-}" ] && grep -q WAYMARK_DATA "$configuration"; then
  echo "skipped: WAYMARK_DATA is not set"
  exit 77
fi
if grep -q "plugin: radar_log" "$configuration"; then
  radar=${RADAR_PLUGINS:-${EXTENSION_BUILDS:-}/radar}
  if [ ! -e "$radar/waymark_radar_log.so" ]; then
    echo "skipped: RADAR_PLUGINS does not name a folder with waymark_radar_log.so"
    exit 77
  fi
  export WAYMARK_PLUGIN_PATH="$WAYMARK_PLUGIN_PATH:$radar"
fi
"$waymark" run "$configuration" --out "$out" --quiet
bytes=$(wc -c <"$out/$map.pgm")
if [ "$bytes" -lt 10000 ]; then
  echo "$configuration: $map.pgm has $bytes bytes; at least 10000 are expected" >&2
  exit 1
fi
