#!/bin/sh
# One part of a sweep: each task of a Slurm job array runs one shard.
#
#     examples/slurm/submit.sh 8        submits this as 8 tasks, and a job that joins what they leave
#
# A task that is requeued goes on where it was interrupted.
#SBATCH --job-name=lines
#SBATCH --cpus-per-task=1
#SBATCH --time=0:10:00
#SBATCH --requeue
#SBATCH --signal=INT@30

set -eu
discreta=${DISCRETA:-discreta}

exec srun "$discreta" sweep circuits/evaluation/line.json \
    --over dx=0..255 --over dy=0..255 --against ef-line \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" \
    --threads "${SLURM_CPUS_PER_TASK:-1}" --resume \
    --output "lines.$SLURM_ARRAY_TASK_ID.csv"
