#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A study, each run by one process, without MPI. As many runs as `volute sweep STUDY.json --list` has lines:
#   job=$(sbatch --parsable --array=1-$(volute sweep STUDY.json --list | wc -l)%50 study.sh STUDY.json RESULTS)
# and when all have ended the table of all of them:
#   sbatch --dependency=afterany:$job --wrap "volute sweep STUDY.json -o RESULTS"
# That also does runs again whose job was killed. What is done and unchanged is kept, so all of it can be submitted again.
#SBATCH --job-name=volute-study
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4
#SBATCH --mem=8G
#SBATCH --time=02:00:00
set -eu
exec volute sweep "$1" -o "$2" --only "$SLURM_ARRAY_TASK_ID" --threads "$SLURM_CPUS_PER_TASK" --max-memory 6G
