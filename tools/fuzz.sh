#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs every fuzz target of the fuzz build for SECONDS each (default 60), on a copy of its corpus.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
for target in build/fuzz/bin/fuzz_*; do
  name=$(basename "$target")
  corpus=build/fuzz/corpus/${name#fuzz_}
  mkdir -p "$corpus"
  cp -n fuzz/corpus/"${name#fuzz_}"/* "$corpus"/ 2>/dev/null || true
  dictionary=fuzz/dictionaries/${name#fuzz_}.dict
  echo "$name: $seconds s" >&2
  "$target" "$corpus" ${dictionary:+$([ -f "$dictionary" ] && echo -dict="$dictionary")} -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -print_final_stats=1
done
