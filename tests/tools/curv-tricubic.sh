#!/usr/bin/env bash
# curv-tricubic from outside: pictures, what they follow, and what is refused.
#   curv-tricubic.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

figure() { # FILE NAME: a count of a stats record
  sed -n "s/.*\"$2\": *\([0-9]*\).*/\1/p" "$1" | head -n 1
}

"$bin/vol-phantom" half-torus -o torus.vts
draw() { "$bin/curv-tricubic" torus.vts --size 96x80 --view 15,30 "$@"; }
draw -o a.exr --stats a.json || fail "status $?"
[ "$(figure a.json cells)" = 3 ] || fail "three cells expected"
draw -o b.exr --threads 1 && cmp a.exr b.exr || fail "threads show in the picture"
draw -o holes.exr --throttle 4 --stats holes.json
[ "$(figure holes.json holes)" -gt "$(figure a.json holes)" ] || fail "a throttle of 4 leaves no holes"
for way in "--thickness physical" "--cells trilinear" "--opacity nonlinear --gamma 2" "--throttle 0.5" "--thickness physical --fov 30"; do
  # shellcheck disable=SC2086
  draw -o c.exr $way || fail "status $? of $way"
  cmp -s a.exr c.exr && fail "$way shows no difference"
done
"$bin/vol-phantom" half-torus -o - | "$bin/curv-tricubic" - -o d.exr --size 96x80 --view 15,30 && "$bin/img-compare" a.exr d.exr >/dev/null ||
  fail "standard input differs from the file"

# The reference: sheets of physical thickness come near it, and with a finer throttle nearer. By the default ramp, opaque at its upper end,
# by pixels that are right or wrong; where no value is opaque by far more. They leave no holes.
rms() { "$bin/img-compare" "$1" rays.exr --metric rmse --json | sed -n 's/.*"rmse": *\([0-9.e-]*\).*/\1/p' | head -n 1; }
draw -o rays.exr --method rays --reference-length 1 || fail "status $? of rays"
draw -o coarse.exr --thickness physical --reference-length 1 --throttle 2
draw -o fine.exr --thickness physical --reference-length 1 --throttle 0.5
awk -v c="$(rms coarse.exr)" -v f="$(rms fine.exr)" 'BEGIN { exit !(f < 0.8 * c && f < 0.005) }' || fail "opaque sheets do not come near the rays: $(rms coarse.exr), $(rms fine.exr)"
"$bin/vol-phantom" half-torus --field marschner-lobb --dims 7x4x3 -o field.vts
printf 'colours: [[0, 0, 0, 1], [1, 1, 0.5, 0]]\nopacity: [[0, 0], [1, 0.9]]\n' >soft.yaml
soft() { "$bin/curv-tricubic" field.vts --size 96x80 --view 15,30 --transfer soft.yaml --reference-length 1 "$@"; }
soft -o rays.exr --method rays || fail "status $? of rays"
soft -o coarse.exr --thickness physical --throttle 4
soft -o fine.exr --thickness physical --throttle 0.5 --stats fine.json
awk -v c="$(rms coarse.exr)" -v f="$(rms fine.exr)" 'BEGIN { exit !(f < c / 4 && f < 0.001) }' || fail "sheets do not come near the rays: $(rms coarse.exr), $(rms fine.exr)"
[ "$(figure fine.json holes)" = 0 ] || fail "sheets of physical thickness leave holes"

# Within an error: kept against rays, said in the record, and refused where it cannot be.
for bound in 1e-1 1e-2; do
  soft -o within.exr --max-error $bound --stats within.json || fail "status $? of --max-error $bound"
  "$bin/img-compare" within.exr rays.exr --fail-above max=$bound >/dev/null || fail "over its bound of $bound"
  grep -q '"pixel_maximum_estimate"' within.json || fail "no estimate in the stats of $bound"
  [ "$(figure within.json sheets)" -gt 0 ] && [ "$(figure within.json rays)" -lt $((96 * 80)) ] || fail "rays throughout for $bound"
  [ "$(figure within.json last_checked)" -gt 0 ] && [ "$(figure within.json ray_samples)" -gt 0 ] || fail "no check in the stats of $bound"
done
soft -o missed.exr --max-error 1e-300 2>err
[ $? -eq 2 ] || fail "a bound that cannot be kept must end with 2"
[ "$(wc -l <err)" -eq 1 ] || fail "one line expected: $(cat err)"
grep -q "the estimate reached is" err || fail "what was reached is not said: $(cat err)"
[ ! -e missed.exr ] || fail "a picture over its bound was written"

# PLOT3D: positions alone have nothing to show.
echo "2 2 2  0 1 0 1 0 1 0 1  2*0 2*1 2*0 2*1  4*0 4*1" >cube.xyz
echo "2 2 2  0.5 0 1 0  4*1 4*2 8*1 8*0 8*0 8*4" >cube.q
"$bin/curv-tricubic" cube.xyz --solution cube.q --variable pressure -o cube.png --size 32 || fail "status $? of PLOT3D"
for wrong in "cube.xyz -o x.png" "cube.xyz --solution cube.q --variable none -o x.png" "torus.vts -o x.png --gamma 2" "torus.vts -o x.png --throttle 0" \
  "torus.vts -o x.png --reference-length 2" "torus.vts -o x.jpg" "torus.vts -o x.png --beta -1" "torus.vts -o x.png --method rays --thickness layers" "torus.vts -o x.png --method rays --throttle 2 --tolerance 1e-3" \
  "torus.vts -o x.png --max-error 0.1 --throttle 2" "torus.vts -o x.png --max-error 0.1 --order depth" "torus.vts -o x.png --max-error 0.1 --thickness layers" \
  "torus.vts -o x.png --max-error 0.1 --method rays"; do
  # shellcheck disable=SC2086
  "$bin/curv-tricubic" $wrong >out 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
done
echo "hello 2 3" >letter.txt
"$bin/curv-tricubic" letter.txt -o x.png 2>err
[ $? -eq 2 ] && [ "$(wc -l <err)" -eq 1 ] && grep -q "neither a VTK XML structured grid (.vts) nor PLOT3D" err || fail "a letter is no grid: $(cat err)"
[ -e x.png ] && fail "a refused run leaves a file"
exit $failed
