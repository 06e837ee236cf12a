#!/usr/bin/env bash
# isosurf-ray from outside: depth, normals and positions of a ball; of coefficients; what cannot be asked for.
#   isosurf-ray.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

# A ball of radius 0.6 half edges, 32 samples long: at f = 1/2 it covers pi 19.2^2 / 102.4^2 = 0.1104 of a picture
# 1.6 edges wide, 452 of 64 x 64 pixels, give or take its rim of 76 pixels.
"$bin/vol-phantom" sphere --dims 65 -o ball.nrrd || exit 2
for kernel in trilinear catmull-rom b-spline; do
  "$bin/isosurf-ray" ball.nrrd --isovalue 0.5 -o $kernel.exr --size 64x64 --reconstruction $kernel --stats stats.json || fail "status $? for $kernel"
  hits=$(grep -o '"hits": *[0-9]*' stats.json | grep -o '[0-9]*$')
  [ "$hits" -gt 400 ] && [ "$hits" -lt 500 ] || fail "$kernel: $hits pixels hit"
done
# Trilinear and cubic surfaces of a smooth ball are close: pictures too, but for pixels at the rim.
"$bin/img-compare" trilinear.exr b-spline.exr --fail-above rmse=0.03 >/dev/null || fail "kernels draw different balls"
"$bin/isosurf-ray" ball.nrrd --isovalue 0.5 -o ball.png --size 32x24 --view 30,20 || fail "status $? for PNG"
"$bin/isosurf-ray" ball.nrrd --isovalue 0.5 -o - --size 64x64 | cmp - trilinear.exr || fail "standard output differs from a file"
"$bin/isosurf-ray" ball.nrrd --isovalue -1 --close -o box.exr --size 64x64 --stats stats.json || fail "status $? for --close"
# The box covers (1 / 1.6)^2 of the picture: 40 x 40 pixels.
grep -q '"hits": *1600' stats.json || fail "a closed volume all inside is its box: $(grep hits stats.json)"

# Of coefficients: the picture of the rebuilt volume, but for what lies between samples (a spline of degree 3 there, another
# here) and the rim; the same by every bound, the published one at 10 times the evaluations or more.
"$bin/vol-phantom" gaussian --dims 25x21x23 --type f32 -o field.nrrd || exit 2
"$bin/vol-dwt" field.nrrd -o c.vdb --wavelet battle-lemarie-3 --keep 60 --quiet || exit 2
"$bin/vol-dwt" c.vdb -o back.nrrd --inverse --quiet || exit 2
"$bin/isosurf-ray" back.nrrd --isovalue 0.5 -o rebuilt.exr --size 60x45 --view 30,20 --reconstruction b-spline --quiet || exit 2
figure() { # NAME FILE: a number of a stats record
  sed -n "s/.*\"$1\": *\([-0-9.e+]*\).*/\1/p" "$2"
}
for bound in bernstein local global; do
  "$bin/isosurf-ray" c.vdb --isovalue 0.5 -o $bound.exr --size 60x45 --view 30,20 --bound $bound --tolerance 0.01v --stats $bound.json || fail "status $? for --bound $bound"
  # Depths as floats, of roots to 1e-8 voxels: 1e-5 where the eye is up to 100 voxels away.
  "$bin/img-compare" $bound.exr bernstein.exr --channel depth --channel A --fail-above max=1e-5 >/dev/null || fail "$bound draws another surface"
done
"$bin/img-compare" bernstein.exr rebuilt.exr --fail-above rmse=0.05 >/dev/null || fail "coefficients are far from the volume rebuilt of them"
[ "$(figure hits bernstein.json)" -gt 50 ] || fail "$(figure hits bernstein.json) hits"
for bound in bernstein local; do
  awk "BEGIN { exit !($(figure evaluations_per_ray global.json) >= 10 * $(figure evaluations_per_ray $bound.json)) }" ||
    fail "$bound: $(figure evaluations_per_ray $bound.json) evaluations a ray, global: $(figure evaluations_per_ray global.json)"
done
"$bin/isosurf-ray" - --isovalue 0.5 -o - --bound bernstein --size 60x45 --view 30,20 --tolerance 0.01v <c.vdb | cmp - bernstein.exr || fail "a pipe's picture differs from a file's"
"$bin/vol-dwt" field.nrrd -o none.vdb --wavelet haar --keep 0 --quiet || exit 2
"$bin/isosurf-ray" none.vdb --isovalue 0.5 -o none.exr --size 8x8 --stats none.json || fail "status $? for no coefficients"
[ "$(figure hits none.json)" -eq 0 ] || fail "a surface where there is no coefficient"
"$bin/vol-dwt" field.nrrd -o symmetric.vdb --boundary symmetric --levels 1 --quiet || exit 2
for wrong in "c.vdb --isovalue 1 -o a.exr --reconstruction b-spline" "c.vdb --isovalue 1 -o a.exr --tolerance 0" "c.vdb --isovalue 1 -o a.exr --bound best" "c.vdb --isovalue 1 -o a.exr --depth 15" "ball.nrrd --isovalue 1 -o a.exr --bound local" "ball.nrrd --isovalue 1 -o a.exr --tolerance 0.1v" "ball.nrrd --isovalue 1 -o a.exr --depth 6" "symmetric.vdb --isovalue 1 -o a.exr"; do
  # shellcheck disable=SC2086
  refused "$bin/isosurf-ray" $wrong
done

for wrong in "--isovalue nan -o a.exr" "-o a.exr" "--isovalue 1 -o a.ply" "--isovalue 0.5 --colour 2 -o a.exr" "--isovalue 0.5 --colour 0.1,-1,0 -o a.exr" "--isovalue 1 --reconstruction nearest -o a.exr"; do
  # shellcheck disable=SC2086
  "$bin/isosurf-ray" ball.nrrd $wrong 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
done
exit $failed
