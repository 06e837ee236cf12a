#!/bin/sh
# State of one Slurm job in Snakemake's words. Without it a job that Slurm cancels is waited for for ever; scontrol
# is asked, not sacct, because that needs accounting. scontrol forgets a job after MinJobAge: raise it for long sweeps.
state=$(scontrol show job "$1" 2>/dev/null | sed -n 's/.*JobState=\([A-Z_]*\).*/\1/p')
case "$state" in
  COMPLETED) echo success ;;
  PENDING | CONFIGURING | RUNNING | COMPLETING | SUSPENDED | REQUEUED) echo running ;;
  *) echo failed ;;
esac
