#!/bin/bash
# A dataset by a Slurm array: `./slurm.sh URL TASKS --recipe wood --n 10000 ...`, for instance
#
#     ./slurm.sh /lustre/me/planks 100 --recipe wood --n 10000
#     ./slurm.sh s3://bucket/planks 100 --recipe mine.yaml --n 10000 --samples-per-shard 20
#
# begins the dataset here, then submits an array of TASKS tasks, each of which makes every TASKS-th shard, and a job that
# finishes the dataset when all have ended well. Run it again with the same arguments to go on: what is finished is kept.
#
# Tasks are requeued when their node fails or they are preempted. A task should have minutes of work or more: Slurm starts
# tasks every few seconds. TASKS is at most MaxArraySize of the cluster, by default 1000. SHEETLIGHT_PYTHON names the Python
# that has sheetlight, CPUS the cores of a task, SBATCH_* what sbatch takes (SBATCH_PARTITION, SBATCH_ACCOUNT, SBATCH_TIMELIMIT ...).
set -euo pipefail

if ! [[ ${2:-} =~ ^[1-9][0-9]*$ ]]; then
    echo "slurm.sh URL TASKS --recipe RECIPE --n N ...: TASKS is the number of tasks of the array, for instance 100" >&2
    exit 2
fi
url=$1 tasks=$2
shift 2
export SHEETLIGHT_PYTHON=${SHEETLIGHT_PYTHON:-python3}
cpus=${CPUS:-4}
case $url in *://*) ;; *) url=$(realpath -m "$url") ;; esac
export SHEETLIGHT_URL=$url

"$SHEETLIGHT_PYTHON" -m sheetlight.scale begin "$url" "$@"

# The scripts are given as text: a job may start on a node that does not see this folder. Jobs get the environment of this
# script: in a list of --export a comma of the URL would part it.
array=$(sbatch --parsable --job-name=sheetlight --array="0-$((tasks - 1))" --cpus-per-task="$cpus" --requeue \
    --export=ALL --output="sheetlight-%A_%a.log" <<'TASK'
#!/bin/bash
exec "$SHEETLIGHT_PYTHON" -m sheetlight.scale task "$SHEETLIGHT_URL" --part "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --threads "$SLURM_CPUS_PER_TASK"
TASK
)
finish=$(sbatch --parsable --job-name=sheetlight-finish --dependency="afterok:${array%%;*}" --kill-on-invalid-dep=yes --requeue \
    --export=ALL --output="sheetlight-%j.log" <<'FINISH'
#!/bin/bash
exec "$SHEETLIGHT_PYTHON" -m sheetlight.scale finish "$SHEETLIGHT_URL"
FINISH
)
echo "array ${array%%;*}, then job ${finish%%;*} finishes; $SHEETLIGHT_PYTHON -m sheetlight.scale status $url says how far it is"
