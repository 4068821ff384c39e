#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Runs every fuzz target of the fuzz build for SECONDS each (default 60), from its seeds and what earlier runs kept. `--minimise`
# instead keeps the fewest of all inputs found that reach every branch reached, as fuzz/corpus/NAME.pack, which ./dev test replays.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
for target in build/fuzz/bin/fuzz_*; do
  name=$(basename "$target")
  name=${name#fuzz_}
  corpus=build/fuzz/corpus/$name
  pack=fuzz/corpus/$name.pack
  mkdir -p "$corpus"
  cp -n fuzz/corpus/"$name"/* "$corpus"/ 2>/dev/null || true
  [ ! -f "$pack" ] || python3 tools/corpus.py unpack "$pack" "$corpus" >/dev/null
  if [ "$seconds" = --minimise ]; then
    least=$(mktemp -d)
    "$target" -set_cover_merge=1 -use_counters=0 -timeout=20 -rss_limit_mb=2048 "$least" "$corpus" 2>"$least.log" ||
      { tail "$least.log" >&2; exit 1; }
    echo "$name: $(python3 tools/corpus.py pack "$least" "$pack")" >&2
    rm -r "$least" "$least.log"
    continue
  fi
  dictionary=fuzz/dictionaries/$name.dict
  echo "$name: $seconds s" >&2
  "$target" "$corpus" ${dictionary:+$([ -f "$dictionary" ] && echo -dict="$dictionary")} -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 -print_final_stats=1
done
