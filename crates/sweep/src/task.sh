#!/bin/bash
# One task of an array: a line of the list of tasks, $1 lines further than its number in the array says.
# A minute before the time limit USR1 comes: the training is saved, and the task goes back into the queue.
read -r first count < <(sed -n "$((SLURM_ARRAY_TASK_ID + $1 + 1))p" @TASKS@)
@TAXEL@ sweep run-one @SWEEP@ --index "$first" --count "$count" --threads "${SLURM_CPUS_PER_TASK:-1}" &
child=$!
limit=
trap 'limit=yes; kill -USR1 "$child"' USR1
trap 'kill -TERM "$child"' TERM
wait "$child"
code=$?
# A signal ends the waiting, not the child.
while kill -0 "$child" 2> /dev/null; do
  wait "$child"
  code=$?
done
# It may have ended between the signal and the look at it: its own code is kept for one who asks again.
if [ "$code" -gt 128 ]; then
  wait "$child" 2> /dev/null
  last=$?
  [ "$last" = 127 ] || code=$last
fi
if [ -n "$limit" ] && [ "$code" = 75 ]; then
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
