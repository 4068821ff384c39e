#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Many cases, each by one process, without MPI: sbatch --array=1-1000%50 array_of_cases.sh CASES.txt SIGNS.json RESULTS [OPTION..]
# CASES.txt has a case a line (.smv, .pvd, .foam, a scene). A case that is there already is left out, so the array can be submitted again.
# Options are those of `volute visibility` for all cases; meshes need what their values are: --quantity soot-density --field soot
#SBATCH --job-name=volute-cases
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4
#SBATCH --mem=8G
#SBATCH --time=02:00:00
set -eu
case=$(sed -n "${SLURM_ARRAY_TASK_ID}p" "$1")
[ -n "$case" ] || { echo "$1 has no line $SLURM_ARRAY_TASK_ID" >&2; exit 1; }
out="$3/$(printf '%04d' "$SLURM_ARRAY_TASK_ID")"
[ -e "$out/visibility.json" ] && exit 0
mkdir -p "$3"
signs=$2
shift 3
exec volute visibility "$case" --signs "$signs" -o "$out" --threads "$SLURM_CPUS_PER_TASK" --max-memory 6G "$@"
