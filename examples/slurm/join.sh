#!/bin/sh
# Joins the parts of a sweep once every task of the array has ended; tells which rows are missing if one has not done
# its own.
#SBATCH --job-name=lines-join
#SBATCH --time=0:05:00

set -eu
discreta=${DISCRETA:-discreta}

"$discreta" sweep --join lines.*.csv --output lines.csv
rm lines.*.csv
