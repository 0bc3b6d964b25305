# SPDX-License-Identifier: Apache-2.0
# Sourced in the root of a checkout: its objects count as the same as those of another checkout of the same sources.
export CCACHE_BASEDIR="$PWD" CCACHE_NOHASHDIR=1
# Headers that are compiled once for all tests, too.
export CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime CCACHE_PCH_EXTSUM=1
