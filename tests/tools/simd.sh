#!/usr/bin/env bash
# PRECIS_SIMD: kernels without SIMD instructions give the picture that those with them give, and the record says which ran.
#   simd.sh BIN
. "$(dirname "$0")/common.sh"

"$bin/vol-phantom" marschner-lobb --dims 17x16x15 -o ml.nrrd --quiet || exit 2
"$bin/vol-fft" ml.nrrd -o spectrum.nrrd --pad 2 --compensate es:6 --quiet || exit 2
# same BOUND COMMAND...: -o's picture by the best code and by the portable, no pixel further apart than BOUND
same() {
  local bound=$1
  shift
  "$@" -o best.exr --stats best.json --quiet || fail "status $?: $*"
  PRECIS_SIMD=portable "$@" -o portable.exr --stats portable.json --quiet || fail "status $?, portable: $*"
  grep -q '"simd": "portable"' portable.json || fail "the record does not say portable: $*"
  "$bin/img-compare" portable.exr best.exr --fail-above max="$bound" >said || fail "not the same picture: $* $(cat said)"
}

# Floats: the order of a sum and its fused products differ in the last bits.
same 1e-5 "$bin/vol-raycast" ml.nrrd --size 32x24 --view 30,20
same 1e-5 "$bin/vol-raycast" ml.nrrd --size 32x24 --view 30,20 --quadrature split
same 2e-5 "$bin/vol-raycast" ml.nrrd --size 32x24 --view 30,20 --model xray
same 2e-5 "$bin/fvr-slice" spectrum.nrrd --size 32x24 --view 30,20

PRECIS_SIMD=portable "$bin/vol-dwt" ml.nrrd -o portable.vdb --wavelet daubechies-4 --quiet || fail "vol-dwt, portable"
"$bin/vol-dwt" portable.vdb -o back.nrrd --inverse --quiet || fail "vol-dwt --inverse"
"$bin/vol-compare" back.nrrd ml.nrrd --fail-above max=1e-5 >said || fail "the transform is another: $(cat said)"

refused_for PRECIS_SIMD=SSE7 env PRECIS_SIMD=SSE7 "$bin/vol-info" ml.nrrd
exit $failed
