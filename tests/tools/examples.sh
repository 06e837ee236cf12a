#!/usr/bin/env bash
# The sweeps without Snakemake, small: rows for every setting, finer steps err less, a second run draws nothing anew.
examples=$(cd "$(dirname "$0")/../../pipelines/examples" && pwd)
. "$(dirname "$0")/common.sh"

run_make() {
  make -s -C "$examples" BIN="$bin" OUT="$folder/out" DIMS=32 SIZE=48x48 STEPS="2v 1v 0.5v" REPEAT=1 "$@"
}
run_make >first 2>err || fail "make: $(cat err)"
[ "$(wc -l <out/32-48x48/table.csv)" -eq 4 ] || fail "three rows expected: $(cat out/32-48x48/table.csv)"
python3 - out/32-48x48/table.csv <<'PY' || fail "samples do not grow, or errors do not fall: $(cat out/32-48x48/table.csv)"
import csv, sys
rows = list(csv.DictReader(open(sys.argv[1])))
samples, errors = ([float(row[key]) for row in rows] for key in ("samples", "rmse_byte"))
sys.exit(not (samples == sorted(samples) and errors == sorted(errors, reverse=True) and errors[-1] > 0))
PY
touch -r out/32-48x48/step-1v.exr before
run_make >/dev/null || fail "make, a second time"
[ out/32-48x48/step-1v.exr -nt before ] && fail "a second make draws anew"
rm out/32-48x48/step-1v.exr
run_make >/dev/null || fail "make after a file has gone"
[ -e out/32-48x48/step-1v.exr ] || fail "what is missing is not made again"

run_make STEPS="2v 1v" >fewer || fail "make with fewer steps"
[ "$(wc -l <fewer)" -eq 3 ] || fail "two rows expected: $(cat fewer)"
run_make SIZE=40x40 STEPS="2v 0.5v" >other || fail "make with another size"
[ "$(wc -l <other)" -eq 3 ] || fail "two rows expected: $(cat other)"

sweep() {
  BIN=$bin DIMS=32 SIZE=48x48 WAVELETS=haar EPSILONS="0.5 4" "$examples/sweep.sh" "$folder/shell"
}
sweep >/dev/null 2>err || fail "sweep.sh: $(cat err)"
[ "$(wc -l <shell/32-48x48/sweep.csv)" -eq 3 ] || fail "two rows expected: $(cat shell/32-48x48/sweep.csv)"
rm shell/32-48x48/haar-4.error.json
touch -r shell/32-48x48/haar-0.5.exr before
sweep >/dev/null || fail "sweep.sh, a second time"
[ shell/32-48x48/haar-0.5.exr -nt before ] && fail "a second sweep draws anew"
[ -e shell/32-48x48/haar-4.error.json ] || fail "what is missing is not made again"
exit $failed
