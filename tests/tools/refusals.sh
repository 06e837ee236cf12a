#!/usr/bin/env bash
# What every tool refuses alike, in one line that names the file and says what to do: outputs in one place, index volumes
# as fields, values of scenes and of files of options, sizes that memory does not hold.
#   refusals.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

"$bin/vol-phantom" marschner-lobb --dims 16 --type f32 -o field.nrrd || exit 2
"$bin/vol-dwt" field.nrrd -o coefficients.vdb --quiet || exit 2
"$bin/vol-phantom" gaussian --dims 16 -o ball.nrrd && "$bin/vol-dwt" ball.nrrd -o ball.vdb --quiet && "$bin/vol-index" ball.vdb --epsilon 0.1 -o index.nrrd --quiet || exit 2

# Two outputs in one place: the second would take the first's.
mkdir folder && touch there.nrrd && ln -s there.nrrd link.nrrd
cast="$bin/vol-raycast field.nrrd --size 8x8"
texture="$bin/vol-phantom texture --dims 8"
for shared in "$cast -o a.exr --stats a.exr" "$cast -o a.png --samples-output ./a.png" "$cast -o folder/../a.png --samples-output a.png" \
  "$cast -o a.exr --stats $PWD/a.exr" "$texture -o one.nrrd --labels-output one.nrrd" "$texture -o there.nrrd --labels-output link.nrrd" "$texture -o - --labels-output -"; do
  # shellcheck disable=SC2086
  refused_for "different names" $shared
done
[ "$(echo *.exr *.png one.nrrd)" = "*.exr *.png one.nrrd" ] || fail "a refused run leaves $(echo *.exr *.png one.nrrd)"
# shellcheck disable=SC2086
$cast -o - --stats - >picture.exr 2>stats.json || fail "status $?: a record goes to standard error, beside a picture"
# shellcheck disable=SC2086
$cast -o /dev/null --format exr --stats /dev/null || fail "status $?: a device takes everything"
# shellcheck disable=SC2086
$texture -o one.nrrd --labels-output two.nrrd || fail "status $? for two outputs"

# The packed bytes of an index volume are no field; vol-convert has its entries.
for tool in "vol-raycast index.nrrd -o a.exr" "vol-dwt index.nrrd -o a.vdb" "vol-fft index.nrrd -o a.nrrd" "isosurf-mc index.nrrd -o a.ply --isovalue 1" \
  "isosurf-ray index.nrrd -o a.exr --isovalue 1" "vol-compare field.nrrd index.nrrd"; do
  # shellcheck disable=SC2086
  refused_for vol-convert "$bin/"$tool
  grep -q index.nrrd err || fail "$tool: not named: $(cat err)"
done
"$bin/vol-convert" index.nrrd -o entries.nrrd || fail "status $? for an index volume"
"$bin/vol-info" entries.nrrd | grep -q "dims *16 16 16" || fail "the entries are not as many as the voxels: $("$bin/vol-info" entries.nrrd)"
"$bin/vol-convert" entries.nrrd --subtract index.nrrd -o nothing.nrrd || fail "status $? for --subtract"
"$bin/vol-info" entries.nrrd | grep -q "max *[1-3]" || fail "an index of zeros: $("$bin/vol-info" entries.nrrd)"
"$bin/vol-info" nothing.nrrd | grep -q "zeros *4096" || fail "an index less its entries is not nothing: $("$bin/vol-info" nothing.nrrd)"
refused_for vol-dwt "$bin/wavelet-raycast" field.nrrd -o a.exr
refused_for --missing "$bin/vol-convert" field.nrrd -o a.nrrd --missing nan
refused_for --missing "$bin/vol-raycast" field.nrrd -o a.exr --missing inf
for other in "--algorithm plain" "--isovalue 0.5" "--quadrature reference" "--quadrature split --model mip" "--reconstruction b-spline" "--max-error 0.1"; do
  refused_for "--layout blocks" $cast -o a.exr --layout blocks $other
done

# A scene's values: the file, the line and the key.
while IFS='|' read -r key text; do
  printf '%b\n' "$text" >scene.yaml
  # shellcheck disable=SC2086
  refused_for "scene.yaml: line 2: $key" $cast -o a.exr --scene scene.yaml
done <<'EOF'
azimuth|background: [0, 0, 0]\ncamera: {azimuth: .nan}
elevation|background: [0, 0, 0]\ncamera: {elevation: 91}
width|background: [0, 0, 0]\ncamera: {width: 0}
width|background: [0, 0, 0]\ncamera: {width: .inf}
fov|background: [0, 0, 0]\ncamera: {fov: 180}
distance|background: [0, 0, 0]\ncamera: {distance: -1}
up|background: [0, 0, 0]\ncamera: {up: [0, 0, 0]}
diffuse|background: [0, 0, 0]\nshading: {diffuse: -1}
exponent|background: [0, 0, 0]\nshading: {exponent: .inf}
light|background: [0, 0, 0]\nshading: {light: [0, 0, 0]}
reference_length|background: [0, 0, 0]\nreference_length: 0
EOF
for tolerance in -1 inf nan; do
  # shellcheck disable=SC2086
  refused_for "--step-tolerance" $cast -o a.exr --step-tolerance $tolerance
done
# shellcheck disable=SC2086
refused_for "--index" $cast -o a.exr --index auto --step-tolerance 0.1
# shellcheck disable=SC2086
refused_for "trapezoid" $cast -o a.exr --quadrature split --step-tolerance 0.1
for step in -1 abc 0v; do
  echo "step: $step" >scene.yaml
  # shellcheck disable=SC2086
  refused_for "scene.yaml: step" $cast -o a.exr --scene scene.yaml
done
printf 'camera: {azimuth: -400, elevation: 90, fov: 179, distance: 1e-3, up: [0, 0, 1e-100]}\nshading: {exponent: 0}\n' >scene.yaml
# shellcheck disable=SC2086
$cast -o a.exr --scene scene.yaml || fail "status $? for a scene of extreme values"

# Files of options: which one, and nothing on the terminal that is no text.
echo 'thraeds = 1' >typing.toml
# shellcheck disable=SC2086
refused_for "typing.toml: unknown option 'thraeds'" $cast -o a.exr --config typing.toml
# shellcheck disable=SC2086
refused_for coefficients.vdb $cast -o a.exr --config coefficients.vdb
LC_ALL=C grep -q '[^[:print:]]' err && fail "an error with what does not print: $(od -c err | head)"

# More than memory holds, which is 4 GiB here whatever the machine has. Sanitizers end a program that asks for so much, and take
# terabytes of addresses.
if ! grep -q __asan_init "$bin/vol-phantom"; then
  (
    ulimit -v 4194304 || fail "no limit of memory"
    for dims in 100000x100000x100000 1500000x1500000x1500000 2000x2000x2000; do
      refused_for "$dims voxels of type f32 take" "$bin/vol-phantom" ramp --dims $dims --type f32 -o a.nrrd
      refused_for "$dims voxels" "$bin/vol-convert" field.nrrd --resample $dims -o a.nrrd
    done
    for tool in "vol-raycast field.nrrd" "isosurf-ray field.nrrd --isovalue 0.5" "wavelet-raycast coefficients.vdb" \
      "wavelet-raycast coefficients.vdb --algorithm footprint"; do
      # shellcheck disable=SC2086
      refused_for "65536x65536 pixels" "$bin/"$tool -o a.exr --size 65536x65536
    done
    ulimit -v 1048576  # the image fits, the rays of its pixels do not
    refused_for "6000x6000 pixels" "$bin/wavelet-raycast" coefficients.vdb --algorithm footprint -o a.exr --size 6000x6000 --threads 1
    exit $failed
  ) || failed=1
fi
exit $failed
