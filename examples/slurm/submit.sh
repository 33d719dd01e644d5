#!/bin/sh
# Submits a sweep as a job array of so many tasks, and the job that joins the parts. To be run from the repository's
# root, on a machine that shares it with the nodes; DISCRETA is the program if it is not on the path there.
#
#     examples/slurm/submit.sh 8
set -eu
tasks=${1:?how many tasks?}
here=$(dirname "$0")

array=$(sbatch --parsable --array="1-$tasks" "$here/sweep.sh")
join=$(sbatch --parsable --dependency="afterany:$array" "$here/join.sh")
echo "array $array, join $join: squeue --me; then look at lines.csv and slurm-*.out"
