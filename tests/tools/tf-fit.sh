#!/usr/bin/env bash
# tf-fit from outside: curves that come back, what the other tools make of them, what is refused.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"
PATH="$bin:$PATH"
figure() { # FILE KEY: a number of a stats record
  sed -n "s/.*\"$2\": \(-\{0,1\}[0-9][0-9.e+-]*\).*/\1/p" "$1" | head -n 1
}
below() { # VALUE LIMIT WHAT
  LC_ALL=C awk -v a="$1" -v b="$2" 'BEGIN { exit !(a != "" && a + 0 <= b + 0) }' || fail "$3: $1, not at most $2"
}
differs() { # A B MEASURE=LIMIT ...: fails unless within
  local a=$1 b=$2 limit
  shift 2
  for limit in "$@"; do
    img-compare "$a" "$b" --fail-above "$limit" >said 2>&1 || fail "$a and $b differ by more than $limit: $(tail -n 1 said)"
  done
}

# A curve that is itself Bezier comes back, and the fewest points that do are found.
cat >own.yaml <<'YAML'
range: [0, 2]
bezier:
  - {name: low, colour: [1, 0.5, 0.25], points: [0.1, 0, 2, 0.5, 1, 0.7]}
  - {name: high, colour: [0, 1, 0.5], points: [0, 0.2, 1.9]}
YAML
tf-fit own.yaml -o again.yaml --points 6 --stats fit.json --quiet || fail "tf-fit: status $?"
below "$(figure fit.json residual_largest)" 1e-12 "the largest residual of its own curve"
tf-fit own.yaml -o fewest.yaml --error-below 1e-9 --stats fewest.json --quiet || fail "--error-below: status $?"
[ "$(figure fewest.json points)" = 6 ] || fail "$(figure fewest.json points) points, not 6"
tf-fit again.yaml -o - --points 6 --quiet | grep -q "name: \"low\", colour: \[1, 0.5, 0.25\]" || fail "name and colour got lost"

# One file for all tools: the picture by spectra is the X-ray of the weighted voxels. The Gaussian ends at its faces with
# exp(-1/(2 0.3^2)) of its peak, and the weight takes v B(v) of that: what the sum has more of than the integral is small.
vol-phantom gaussian --dims 40x48x44 --spacing 1.1,1,1.3 --origin 3,-7,20 -o one.nrrd || exit 2
tf-fit --band soft=0.2:0.6=0.8 --band hard=0.5:1=1 --band-colours 1,0.4,0:0,0.5,1 --volume one.nrrd -o tissue.yaml --points 6 --quiet ||
  fail "bands: status $?"
vol-fft one.nrrd -o tissue.nrrd --bezier tissue.yaml --compensate es:8 || fail "vol-fft: status $?"
vol-fft one.nrrd -o more.nrrd --bezier 9 --range "$(sed -n 's/^range: \[\(.*\), \(.*\)\]/\1,\2/p' tissue.yaml)" --compensate es:8 ||
  fail "vol-fft: status $?"
for view in 0,0 30,20; do
  vol-raycast one.nrrd -o ray.exr --model xray --transfer tissue.yaml --size 90x70 --view=$view --reconstruction b-spline --step 0.05v ||
    fail "vol-raycast: status $?"
  fvr-slice tissue.nrrd -o fvr.exr --transfer tissue.yaml --size 90x70 --view=$view || fail "fvr-slice: status $?"
  # Pixels go up to about 10; the B-spline through the weighted voxels is no band-limited field, but close.
  differs fvr.exr ray.exr max=0.1 rmse=0.01
  # More spectra than points: the same curve at a higher degree.
  fvr-slice more.nrrd -o same.exr --transfer tissue.yaml --size 90x70 --view=$view || fail "fvr-slice: status $?"
  differs same.exr fvr.exr max=1e-4
done
# The curves' file is an input of the spectra; spectra without the curves' range are taken at their word, which is said.
vol-fft one.nrrd -o tissue.nrrd --bezier tissue.yaml --compensate es:8 --stats spectra.json || fail "vol-fft: status $?"
[ "$(grep -c '"path": "tissue.yaml"' spectra.json)" = 1 ] || fail "tissue.yaml is no input: $(grep path spectra.json)"
LC_ALL=C sed '/^precis.bezier_range/d' tissue.nrrd >unsaid.nrrd
fvr-slice unsaid.nrrd -o unsaid.exr --transfer tissue.yaml --size 9x7 --quiet 2>err || fail "spectra without a range: status $?"
grep -q "warning: .* do not say" err || fail "no word of spectra without a range: $(cat err)"
fvr-slice tissue.nrrd -o said.exr --transfer tissue.yaml --size 9x7 --quiet 2>err && [ ! -s err ] || fail "spectra with their range: $(cat err)"
# Three channels are one picture: timed together as often as asked for, their samples added up.
samples_of() { # TRANSFER: of a picture whose every ray takes all samples
  vol-raycast one.nrrd -o counted.exr --model xray --transfer "$1" --size 24x18 --repeat 2 --no-skip --stats counted.json --quiet \
    --samples-output counted.png || fail "vol-raycast: status $?"
  [ "$(sed -n '/"render": \[/,/\]/p' counted.json | grep -c '[0-9]')" = 2 ] || fail "times of $1: $(sed -n '/"phases"/,/}/p' counted.json)"
}
printf 'range: [0, 1]\nbezier: [0, 1]\n' >plain.yaml
samples_of plain.yaml
once=$(figure counted.json samples) most=$(figure counted.json samples_largest)
samples_of tissue.yaml
[ "$(figure counted.json samples)" = $((3 * once)) ] || fail "$(figure counted.json samples) samples, not three times $once"
LC_ALL=C awk -v a="$(figure counted.json samples_largest)" -v b="$most" 'BEGIN { exit !(a == 3 * b) }' || fail "samples of the picture: not three times $most"
# From voxels in blocks the same.
vol-raycast one.nrrd -o rows.exr --model xray --transfer tissue.yaml --size 24x18 || fail "vol-raycast: status $?"
vol-raycast one.nrrd -o blocks.exr --model xray --transfer tissue.yaml --size 24x18 --layout blocks --stats blocks.json || fail "vol-raycast: status $?"
grep -q '"layout": "blocks"' blocks.json || fail "drawn from rows, not from blocks"
differs blocks.exr rows.exr max=0
# Refused, not passed over.
refused_for "--transfer" vol-raycast one.nrrd -o missed.exr --model mip --transfer tissue.yaml
printf 'colours: [[0, 0, 0, 0], [1, 1, 1, 1]]\nopacity: [[0, 0], [1, 1]]\n' >opacity.yaml
refused_for "--transfer" vol-raycast one.nrrd -o missed.exr --model xray --transfer opacity.yaml
vol-dwt one.nrrd -o one.vdb --levels 1 --quiet && vol-index one.vdb -o index.nrrd --quiet || fail "vol-index: status $?"
refused_for "--index" vol-raycast one.nrrd -o missed.exr --model xray --transfer tissue.yaml --index index.nrrd
img-compare fvr.exr ray.exr --channel R --json --metric max >/dev/null || fail "no channel R"
# The same as by hand.
tf-fit --band 0.2:0.6=0.8 --volume one.nrrd -o grey.yaml --points 4 --quiet || fail "status $?"
vol-fft one.nrrd -o four.nrrd --bezier grey.yaml || fail "status $?"
fvr-slice four.nrrd -o by-file.exr --transfer grey.yaml --size 64x64 || fail "status $?"
fvr-slice four.nrrd -o by-hand.exr --size 64x64 --control-points "$(sed -n 's/.*points: \[\(.*\)\].*/\1/p' grey.yaml | tr -d ' ')" || fail "status $?"
differs by-file.exr by-hand.exr max=1e-6
# As opacity.
vol-raycast one.nrrd -o opaque.exr --transfer tissue.yaml --size 32x32 || fail "composite: status $?"
printf 'transfer: tissue.yaml\n' >scene.yaml
vol-raycast one.nrrd -o scene.exr --scene scene.yaml --size 32x32 || fail "scene: status $?"
differs scene.exr opaque.exr max=0

# Every way to fit ends with a file that is read again.
printf 'value,opacity\n0,0\n0.4,0\n0.4,1\n0.7,1\n0.8,0.2\n1,0.2\n' >step.csv
last=9
for n in 1 2 4 8 16 21; do
  tf-fit step.csv -o step.yaml --points $n --stats step.json --quiet || fail "$n points: status $?"
  rms=$(figure step.json residual_rms)
  below "$rms" "$last" "RMS with $n points"
  last=$rms
done
for options in "--fit emission" "--bounds-on none" "--bounds-on curve" "--loss huber" "--loss cauchy --loss-scale 0.01" "--smoothness 1e-3" \
  --free-range "--curve parametric" "--volume one.nrrd" "--volume one.nrrd --weight uniform" "--volume one.nrrd --weight log-histogram" \
  "--range=-1,3"; do
  tf-fit step.csv -o way.yaml --points 7 --quiet $options 2>err || fail "$options: status $?: $(cat err)"
  vol-raycast one.nrrd -o way.exr --model xray --transfer way.yaml --size 8x8 || fail "$options: its file is not read"
done
tf-fit step.csv -o even.yaml --points 5 --stats even.json --quiet && tf-fit step.csv -o free.yaml --points 5 --curve parametric --stats free.json --quiet
below "$(figure free.json residual_rms)" "$(figure even.json residual_rms)" "free abscissae"

# Right, or one clear line.
printf '0.5,0.7\n' >one.csv
tf-fit one.csv --range 0,1 -o constant.yaml --points 1 --quiet && grep -q "points: \[0.7" constant.yaml || fail "one point: $(cat constant.yaml)"
refused_for "--range" tf-fit one.csv -o missed.yaml
printf '0,0\n1,nan\n' >nan.csv
refused_for "nan.csv: line 2" tf-fit nan.csv -o missed.yaml
printf 'nan,0\n1,1\n' >nan.csv
refused_for "nan.csv: line 1" tf-fit nan.csv -o missed.yaml
printf '1,0\n0,1\n' >back.csv
refused_for "order" tf-fit back.csv -o missed.yaml
printf 'bezier: [[0, 1], [2, 1], [1, 1]]\n' >beyond.yaml
refused_for "beyond.yaml: line 1" tf-fit beyond.yaml -o missed.yaml
vol-phantom ramp --dims 4x4x4 -o - | vol-convert - -o constant.nrrd --scale 0,7 || exit 2
refused_for "constant.nrrd" tf-fit step.csv --volume constant.nrrd -o missed.yaml
tf-fit step.csv --volume constant.nrrd --range 0,10 -o deficient.yaml --points 4 --quiet 2>err || fail "one value: status $?"
grep -q "rank 1 of 4" err || fail "no word of the rank: $(cat err)"
refused_for "--band 5:6=1: none of the" tf-fit --band 5:6=1 --range 0,1 -o missed.yaml
refused_for "5:6=1" tf-fit --band 1:2=1 --band 5:6=1 --range 0,10 --samples 4 -o missed.yaml
# A band of one value of a volume of integers has it, also where (k - min)/(max - min) is rounded.
vol-phantom ramp --dims 101x2x2 -o - | vol-convert - -o hundred.nrrd --scale 100,0 --type u8 || exit 2
vol-info hundred.nrrd --json | grep -q . || exit 2
for value in 7 14 28 29 55 56 57 58; do
  tf-fit --band $value:$value=1 --volume hundred.nrrd -o one-value.yaml --quiet || fail "band of the value $value: status $?"
done
# Of points at their bounds no other solution is told.
tf-fit --band 0:10=9 --volume constant.nrrd --range 0,10 -o deficient.yaml --points 4 --stats held.json --quiet 2>err || fail "status $?"
grep -q '"method": "active-set"' held.json || fail "not at bounds: $(grep method held.json)"
! grep -q rank err || fail "a word of shortest solutions at bounds: $(cat err)"
refused_for "21" tf-fit step.csv -o missed.yaml --points 22
refused_for "RMS" tf-fit step.csv -o missed.yaml --error-below 1e-9
refused_for "target" tf-fit -o missed.yaml
refused_for "target" tf-fit step.csv --band 0:1=1 -o missed.yaml
refused_for "LO:HI" tf-fit --band 1:0=1 -o missed.yaml
refused_for "LO:HI" tf-fit --band 0:1=nan -o missed.yaml
refused_for "colours" tf-fit --band 0:1=1 --band-colours 1,1,1:0,0,0 -o missed.yaml
refused_for "--volume" tf-fit step.csv --weight histogram -o missed.yaml
refused_for "--bounds" tf-fit step.csv --bounds 2,0 -o missed.yaml
refused_for "--bounds" tf-fit step.csv --bounds 0,1 --bounds-on none -o missed.yaml
refused_for "--loss-scale" tf-fit step.csv --loss-scale 0.2 -o missed.yaml
refused_for "scale of the loss" tf-fit step.csv --loss cauchy --loss-scale 1e-200 -o missed.yaml
refused_for "--smoothness" tf-fit step.csv --smoothness nan -o missed.yaml
refused_for "64 curves" tf-fit $(for i in $(seq 65); do echo "--band 0:0.$((100 + i))=1"; done) -o missed.yaml
refused_for "1e30" tf-fit --band 0:1=1 --band-colours 1e31,0,0 -o missed.yaml
refused_for "UTF-8" tf-fit --band $'Z\xe4hne=0:1=1' -o missed.yaml
printf 'bezier: [{name: "Z\xe4hne", points: [1]}]\n' >latin.yaml
refused_for "latin.yaml: line 1" tf-fit latin.yaml -o missed.yaml
refused_for "latin.yaml: line 1" vol-fft one.nrrd -o missed.nrrd --bezier latin.yaml
# What Ceres could not solve is refused before, in one line.
refused_for "scale of the loss" tf-fit --band 0.477:0.833=1e20 --points 6 --samples 7 --free-range --loss huber --loss-scale 1e-9 \
  --smoothness 1e6 -o missed.yaml
refused_for "exclude" tf-fit step.csv --free-range --curve parametric -o missed.yaml
refused_for "missed.txt" tf-fit step.csv -o missed.txt
tf-fit step.csv -o curved.yaml --points 5 --curve parametric --quiet || fail "status $?"
refused_for "curved.yaml" vol-fft one.nrrd -o missed.nrrd --bezier curved.yaml
refused_for "curved.yaml" fvr-slice tissue.nrrd -o missed.exr --transfer curved.yaml
refused_for "values" fvr-slice tissue.nrrd -o missed.exr --transfer own.yaml
refused_for "step.csv" fvr-slice tissue.nrrd -o missed.exr --transfer step.csv
tf-fit tissue.yaml -o eight.yaml --points 8 --quiet || fail "status $?"
refused_for "8 control points" fvr-slice tissue.nrrd -o missed.exr --transfer eight.yaml
refused_for "--bezier 22" vol-fft one.nrrd -o missed.nrrd --bezier 22
refused_for "--range" vol-fft one.nrrd -o missed.nrrd --bezier tissue.yaml --range 0,1
[ ! -e missed.yaml ] && [ ! -e missed.exr ] && [ ! -e missed.nrrd ] || fail "a refused_for run left its output"
exit $failed
