#!/bin/sh
# A Slurm array that indexes $FOLDER in as many shards as the array has tasks, and a job that joins them:
#
#     export FOLDER=/shared/videos DB=/shared/db VOCABULARY=/shared/first
#     array=$(sbatch --parsable --array=1-1000 cluster/slurm.sh)
#     sbatch --dependency=afterok:"$array" --wrap "yurameki-fluid merge $DB.part* --db $DB"
#
# VOCABULARY is a database of a few thousand of the videos, indexed first; the shards then need no more work when they are joined.
#SBATCH --job-name=yurameki-fluid
#SBATCH --cpus-per-task=2
#SBATCH --mem=1G
#SBATCH --time=12:00:00
#SBATCH --requeue
set -eu
exec yurameki-fluid index "$FOLDER" --db "$DB.part$SLURM_ARRAY_TASK_ID" --jobs 2 \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_MAX" --vocabulary "$VOCABULARY"
