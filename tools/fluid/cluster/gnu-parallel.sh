#!/bin/sh
# Indexes a folder of videos with GNU parallel, on this machine or, with --sshloginfile, on many; then joins the parts.
#
#     cluster/gnu-parallel.sh FOLDER DIR SHARDS [OPTIONS OF parallel...]
#
# FOLDER and DIR are on a disk that all machines share. Started again after a breakdown it goes on where it was.
set -eu
folder=$1 db=$2 shards=$3
shift 3
seq "$shards" | parallel "$@" --joblog "$db.jobs" \
    yurameki-fluid index "$folder" --db "$db.part{}" --shard "{}/$shards" --jobs 1
set --
for shard in $(seq "$shards"); do
    # A shard without a video makes no database.
    [ ! -e "$db.part$shard" ] || set -- "$@" "$db.part$shard"
done
yurameki-fluid merge "$@" --db "$db"
