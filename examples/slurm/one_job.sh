#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# One large sequence, compressed by many machines together: sbatch one_job.sh SEQUENCE OUT.volute
# 8 ranks a machine with 16 threads each, of machines with 128 cores; each rank may hold 24 GB.
#SBATCH --job-name=volute
#SBATCH --nodes=8
#SBATCH --ntasks-per-node=8
#SBATCH --cpus-per-task=16
#SBATCH --mem-per-cpu=2G
#SBATCH --time=12:00:00
set -eu
exec srun --mpi=pmix --cpu-bind=cores volute compress "$1" -o "$2" --rms 0.003 \
  --threads "$SLURM_CPUS_PER_TASK" --max-memory 24G --stats "${2%.volute}.json"
