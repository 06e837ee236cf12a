#!/usr/bin/env bash
# vol-raycast --max-error from outside: a bound kept, one that cannot be, and what does not go with it.
#   max-error.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

"$bin/vol-phantom" marschner-lobb --dims 20x17x23 --type u8 -o ml.nrrd || exit 2
"$bin/vol-raycast" ml.nrrd -o truth.exr --size 40x30 --quadrature reference --tolerance 1e-8 || exit 2
for bound in 1e-1 1e-2 1e-3 1e-4; do
  "$bin/vol-raycast" ml.nrrd -o picture.exr --size 40x30 --max-error $bound --stats stats.json || fail "status $? for $bound"
  "$bin/img-compare" picture.exr truth.exr --fail-above max=$bound >/dev/null || fail "over its bound of $bound"
  grep -q '"pixel_maximum_estimate"' stats.json || fail "no estimate in the stats of $bound"
done
for model in xray mip; do
  "$bin/vol-raycast" ml.nrrd -o picture.exr --size 9x8 --model $model --max-error 1e-3 || fail "status $? for $model"
done

"$bin/vol-raycast" ml.nrrd -o missed.exr --size 9x8 --max-error 1e-300 2>err
[ $? -eq 2 ] || fail "a bound that cannot be kept must end with 2"
[ "$(wc -l <err)" -eq 1 ] || fail "one line expected: $(cat err)"
[ ! -e missed.exr ] || fail "a picture over its bound was written"

for other in "--quadrature trapezoid" "--step 1v" "--index auto" "--image-step 2" "--termination 0.1" "--algorithm plain"; do
  # shellcheck disable=SC2086
  "$bin/vol-raycast" ml.nrrd -o missed.exr --size 9x8 --max-error 1e-2 $other 2>/dev/null
  [ $? -eq 2 ] || fail "--max-error and $other exclude each other"
done
exit $failed
