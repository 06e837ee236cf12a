#!/usr/bin/env bash
# isosurf-ray from outside: depth, normals and positions of a ball; what cannot be asked for.
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

for wrong in "--isovalue nan -o a.exr" "-o a.exr" "--isovalue 1 -o a.ply" "--isovalue 0.5 --colour 2 -o a.exr" "--isovalue 0.5 --colour 0.1,-1,0 -o a.exr" "--isovalue 1 --reconstruction nearest -o a.exr"; do
  # shellcheck disable=SC2086
  "$bin/isosurf-ray" ball.nrrd $wrong 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
done
exit $failed
