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
grep -q '"planned_bytes": *[1-9]' stats.json || fail "what it would take was not counted"
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
figure() { # NAME FILE: a number of a stats record
  sed -n "s/.*\"$1\": *\([-0-9.e+]*\).*/\1/p" "$2"
}
for levels in 1:2 3:3 1:3; do
  "$bin/wavelet-raycast" all.vdb -o "${levels/:/}.exr" --size 32x24 --view 30,20 --levels $levels --stats "${levels/:/}.json" || fail "status $? for --levels $levels"
done
# 24 x 20 x 17 is extended to 24 x 24 x 24: 3^3 places of level 3, 8 orientations.
coarse=$(figure coefficients 33.json)
[ "$coarse" -gt 0 ] && [ "$coarse" -le 216 ] || fail "level 3 has 1 to 216 coefficients, not $coarse"
[ $(($(figure coefficients 12.json) + coarse)) -eq "$(figure coefficients 13.json)" ] || fail "the levels' coefficients are not all of them"
# Pictures are sums over the coefficients, rounded to float (6e-8): the largest pixel is below 10.
"$bin/wavelet-raycast" all.vdb -o whole.exr --size 32x24 --view 30,20 || fail "status $?"
"$bin/img-compare" 13.exr whole.exr --fail-above max=0 >/dev/null || fail "--levels 1:3 is not all"
oiiotool 12.exr --ch R,G,B 33.exr --ch R,G,B --add -o sum.exr || fail "oiiotool: status $?"
"$bin/img-compare" sum.exr whole.exr --channel R --channel G --channel B --fail-above max=3e-6 >/dev/null || fail "the levels do not add up to the picture"
"$bin/img-compare" 33.exr whole.exr --fail-above max=1e-3 >/dev/null 2>&1 && fail "the detail shows nowhere"
# What --levels leaves out is not drawn: of orthonormal coefficients, with what is drawn, the whole norm.
python3 - "$(figure norm_not_drawn 12.json)" "$(figure norm_not_drawn 33.json)" "$(figure norm_not_drawn 13.json)" field.nrrd <<'PYTHON' || fail "norm_not_drawn is not that of what --levels leaves out"
import array, math, sys
level3, levels12, none = map(float, sys.argv[1:4])
v = array.array("f", open(sys.argv[4], "rb").read().split(b"\n\n", 1)[1])
at = lambda x, y, z: v[(min(z, 16) * 20 + min(y, 19)) * 24 + x]  # extended by its last samples
norm = math.sqrt(sum(at(x, y, z) ** 2 for z in range(24) for y in range(24) for x in range(24)))
print(level3, levels12, none, norm)
sys.exit(not (none == 0 < levels12 < level3 and abs(math.hypot(level3, levels12) / norm - 1) < 1e-6))  # float
PYTHON

# Coefficients that interpolate: the file says so, the inverse gives the voxels.
"$bin/vol-phantom" gaussian --dims 24x20x17 --type u8 -o bytes.nrrd || exit 2
"$bin/vol-dwt" bytes.nrrd -o through.vdb --wavelet coiflet-6 --initialise interpolate --quiet || fail "status $? for --initialise"
"$bin/vol-info" through.vdb | grep -q "initialisation *interpolate" || fail "vol-info does not say that the field interpolates"
"$bin/vol-info" haar.vdb | grep -q "initialisation *samples" || fail "vol-info does not say that c0 are the samples"
"$bin/vol-dwt" through.vdb -o bytes_back.nrrd --inverse --quiet || fail "status $? for --inverse"
"$bin/vol-compare" bytes_back.nrrd bytes.nrrd --fail-above max=0 >/dev/null || fail "the inverse is not the voxels"
refused_for battle-lemarie-3 "$bin/vol-dwt" field.nrrd -o a.vdb --wavelet battle-lemarie-3:29 --initialise interpolate
refused_for 0.0308 "$bin/vol-dwt" field.nrrd -o a.vdb --wavelet daubechies-10 --initialise interpolate
refused_for periodic "$bin/vol-dwt" field.nrrd -o a.vdb --boundary symmetric --initialise interpolate
refused_for samples "$bin/vol-index" through.vdb -o a.nrrd --epsilon 1
refused_for samples "$bin/vol-segment" through.vdb -o a.nrrd

# Footprints: haar's in closed form, others' within the share of the range (the field is positive: the largest pixel) asked for.
"$bin/wavelet-raycast" all.vdb -o rays.exr --size 32x24 --view 30,20 || fail "status $?"
"$bin/wavelet-raycast" all.vdb -o footprint.exr --size 32x24 --view 30,20 --algorithm footprint --stats footprint.json || fail "status $? for footprints of haar"
"$bin/img-compare" footprint.exr rays.exr --channel R --fail-above max=1e-6 >/dev/null || fail "haar's footprints are not exact"
[ "$(figure terms_by_boxes footprint.json)" -gt 0 ] || fail "haar's footprints are boxes"
"$bin/vol-dwt" field.nrrd -o rough.vdb --wavelet daubechies-4 --levels 1 --keep 400 --quiet || exit 2
"$bin/wavelet-raycast" rough.vdb -o rays.exr --size 32x24 --view 30,20 || fail "status $?"
for error in 1e-2 1e-4; do
  "$bin/wavelet-raycast" rough.vdb -o - --size 32x24 --view 30,20 --algorithm footprint --footprint-error $error --stats footprint.json >footprint.exr || fail "status $? for footprints"
  "$bin/img-compare" footprint.exr rays.exr --channel R --fail-above max="$(figure footprint_error_allowed footprint.json)" >/dev/null || fail "--footprint-error $error is not kept"
  grep -q '"tables": *\[' footprint.json || fail "the time of the tables is not told apart"
done
"$bin/wavelet-raycast" rough.vdb -o a.exr --algorithm footprint --fov 30 2>err
[ $? -eq 2 ] || fail "footprints of a perspective view must end with 2"
[ "$(wc -l <err)" -eq 1 ] && grep -q -e "--algorithm rays" err || fail "one line that says what to do: $(cat err)"

"$bin/vol-dwt" field.nrrd -o symmetric.vdb --boundary symmetric --levels 1 --quiet || exit 2
for wrong in "field.nrrd -o a.exr" "symmetric.vdb -o a.exr" "haar.vdb -o a.exr --depth 15" "haar.vdb -o a.exr --depth 0" "haar.vdb -o a.exr --model mip" "haar.vdb -o a.exr --algorithm splat" "haar.vdb -o a.exr --footprint-error 0" "haar.vdb -o a.exr --levels 3:1" "haar.vdb -o a.exr --levels 4:5" "haar.vdb -o a.exr --levels 1:4" "haar.vdb -o a.exr --levels 0:2" "haar.vdb -o a.exr --levels 1" "haar.vdb -o a.exr --budget -1" "haar.vdb -o a.exr --region 1,1,1:0,2,2" "haar.vdb -o a.ply" "none.vdb -o a.exr"; do
  # shellcheck disable=SC2086
  "$bin/wavelet-raycast" $wrong 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
done
exit $failed
