#!/usr/bin/env bash
# wavelet-raycast from outside: beside vol-raycast on the rebuilt volume; what cannot be asked for.
#   wavelet-raycast.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

# Haar's expansion takes each voxel's value on the box around its centre: nearest neighbours, which quadrature rectangle
# integrates to a step's share of the picture. Kept are 5 % of the coefficients.
"$bin/vol-phantom" gaussian --dims 24x20x17 --type f32 -o field.nrrd || exit 2
"$bin/vol-dwt" field.nrrd -o haar.vdb --wavelet haar --keep 400 --quiet || exit 2
"$bin/vol-dwt" haar.vdb -o back.nrrd --inverse --quiet || exit 2
"$bin/vol-raycast" back.nrrd -o nearest.exr --model xray --reconstruction nearest --step 0.002 --size 32x24 --view 30,20 --quiet || exit 2
"$bin/wavelet-raycast" haar.vdb -o haar.exr --size 32x24 --view 30,20 --stats stats.json || fail "status $? for haar"
"$bin/img-compare" haar.exr nearest.exr --fail-above rmse=0.002 >/dev/null || fail "haar is not what nearest neighbours give"
grep -q '"coefficients": *400' stats.json || fail "not 400 coefficients: $(grep coefficients stats.json)"

# Smooth wavelets on a smooth field come near its trilinear picture; the view is a perspective one, too.
for wavelet in daubechies-8 battle-lemarie-3; do
  "$bin/vol-dwt" field.nrrd -o $wavelet.vdb --wavelet $wavelet --keep 400 --quiet || exit 2
  for camera in "--view 30,20" "--view 90,0 --fov 30"; do
    # shellcheck disable=SC2086
    "$bin/vol-raycast" field.nrrd -o trilinear.exr --model xray --size 20x16 $camera --quiet || exit 2
    # shellcheck disable=SC2086
    "$bin/wavelet-raycast" $wavelet.vdb -o a.exr --size 20x16 $camera || fail "status $? for $wavelet $camera"
    "$bin/img-compare" a.exr trilinear.exr --fail-above rmse=0.03 >/dev/null || fail "$wavelet $camera is far from the volume"
  done
done
"$bin/wavelet-raycast" haar.vdb -o - --size 32x24 --view 30,20 | cmp - haar.exr || fail "standard output differs from a file"
"$bin/wavelet-raycast" haar.vdb -o haar.png --size 32x24 || fail "status $? for PNG"

# Level of detail: as if vol-dwt had kept no more.
"$bin/vol-dwt" field.nrrd -o all.vdb --wavelet haar --quiet || exit 2
"$bin/wavelet-raycast" all.vdb -o budget.exr --size 32x24 --view 30,20 --budget 400 || fail "status $? for --budget"
"$bin/img-compare" haar.exr budget.exr --fail-above max=0 >/dev/null || fail "--budget 400 is not vol-dwt --keep 400"
"$bin/vol-dwt" field.nrrd -o region.vdb --wavelet haar --region 3,4,5:9,9,9 --quiet || exit 2
"$bin/wavelet-raycast" region.vdb -o a.exr --size 32x24 || fail "status $? for a region's coefficients"
"$bin/wavelet-raycast" all.vdb -o b.exr --size 32x24 --region 3,4,5:9,9,9 || fail "status $? for --region"
"$bin/img-compare" a.exr b.exr --fail-above max=0 >/dev/null || fail "--region is not that of vol-dwt"
"$bin/wavelet-raycast" all.vdb -o coarse.exr --size 32x24 --levels 3:3 --stats stats.json || fail "status $? for --levels"
# 24 x 20 x 17 is extended to 24 x 24 x 24: 3^3 places of level 3, 8 orientations.
[ "$(grep -o '"coefficients": *[0-9]*' stats.json | grep -o '[0-9]*$')" -le 216 ] || fail "level 3 has at most 216 coefficients"

"$bin/vol-dwt" field.nrrd -o symmetric.vdb --boundary symmetric --levels 1 --quiet || exit 2
for wrong in "field.nrrd -o a.exr" "symmetric.vdb -o a.exr" "haar.vdb -o a.exr --depth 15" "haar.vdb -o a.exr --depth 0" "haar.vdb -o a.exr --model mip" "haar.vdb -o a.exr --levels 3:1" "haar.vdb -o a.exr --levels 4:5" "haar.vdb -o a.exr --levels 1" "haar.vdb -o a.exr --budget -1" "haar.vdb -o a.exr --region 1,1,1:0,2,2" "haar.vdb -o a.ply" "none.vdb -o a.exr"; do
  # shellcheck disable=SC2086
  "$bin/wavelet-raycast" $wrong 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
done
exit $failed
