#!/usr/bin/env bash
# wavelet-raycast --model composite from outside: beside vol-raycast's reference on the same field; what does not go together;
# pictures on the way (--every) and what an interruption leaves.
#   wavelet-composite.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

"$bin/vol-phantom" gaussian --dims 24x20x17 --type f32 -o field.nrrd || exit 2
cat >scene.yaml <<'YAML'
camera: {azimuth: 30, elevation: 20}
transfer:
  colours: [[0, 0.1, 0.3, 1], [1, 1, 0.7, 0.2]]
  opacity: [[0, 0], [0.2, 0], [0.4, 0.3], [1, 0.8]]
background: [0.1, 0.2, 0.1]
YAML

# Haar's field is that of nearest neighbours, whose integral through a transfer function the reference knows. Pictures are
# float; the tolerances are 1e-10 and 1e-8.
"$bin/vol-dwt" field.nrrd -o haar.vdb --wavelet haar --keep 400 --quiet || exit 2
"$bin/vol-dwt" haar.vdb -o back.nrrd --inverse --quiet || exit 2
"$bin/vol-raycast" back.nrrd -o nearest.exr --scene scene.yaml --reconstruction nearest --quadrature reference --size 32x24 --quiet || exit 2
"$bin/wavelet-raycast" haar.vdb -o haar.exr --model composite --scene scene.yaml --tolerance 1e-8 --size 32x24 --stats stats.json || fail "status $? for a scene"
"$bin/img-compare" haar.exr nearest.exr --fail-above max=1e-6 >/dev/null || fail "haar is not what nearest neighbours give: $("$bin/img-compare" haar.exr nearest.exr)"
grep -q '"evaluations": *[1-9]' stats.json || fail "what was evaluated is not counted"

# A smooth wavelet that interpolates, shaded, is near the cubic spline through the same voxels.
sed 's/^background/shading: true\nbackground/' scene.yaml >shaded.yaml
"$bin/vol-dwt" field.nrrd -o spline.vdb --wavelet battle-lemarie-3 --initialise interpolate --quiet || exit 2
"$bin/vol-raycast" field.nrrd -o cubic.exr --scene shaded.yaml --reconstruction b-spline --quadrature reference --tolerance 1e-6 --size 20x16 --quiet || exit 2
"$bin/wavelet-raycast" spline.vdb -o spline.exr --model composite --scene shaded.yaml --size 20x16 || fail "status $? for a shaded scene"
# Both are cubic splines through the voxels, but for what lies beyond the border: mirrored here, a period there.
"$bin/img-compare" spline.exr cubic.exr --fail-above rmse=2e-3 >/dev/null || fail "the shaded spline is far from the cubic one: $("$bin/img-compare" spline.exr cubic.exr)"

# The field itself as extinction: alpha is the radiance, more of it is more opaque, and what is below 0 is counted.
"$bin/vol-dwt" field.nrrd -o d4.vdb --wavelet daubechies-4 --keep 400 --quiet || exit 2
white() { # OUTPUT OPTION...
  local to=$1
  shift
  "$bin/wavelet-raycast" d4.vdb -o "$to" --model composite --size 32x24 --view 30,20 --depth 4 --stats stats.json "$@" || fail "status $? for $*"
}
white clamp.exr --extinction 0.3
grep -q '"clamped_pieces": *[1-9]' stats.json || fail "nothing below 0 was counted"
oiiotool clamp.exr --ch R -o r.exr && oiiotool clamp.exr --ch A --chnames R -o a.exr || fail "oiiotool: status $?"
"$bin/img-compare" r.exr a.exr --channel R --fail-above max=0 >/dev/null || fail "the radiance of a white medium is not its alpha"
white keep.exr --extinction 0.3 --negative keep
grep -q '"clamped_pieces": *0' stats.json || fail "what is kept was clamped"
"$bin/img-compare" keep.exr clamp.exr --fail-above max=0 >/dev/null 2>&1 && fail "--negative keep changes nothing"
"$bin/wavelet-raycast" d4.vdb -o - --model composite --extinction 0.3 --size 32x24 --view 30,20 --depth 4 | cmp - clamp.exr || fail "standard output differs from a file"

# Linearised: nearer between the knots than by whole functions.
rmse() { # OPTION...
  white linearised.exr --extinction 0.3 "$@"
  "$bin/img-compare" linearised.exr keep.exr --json --metric rmse | sed -n 's/.*"rmse": *\([-0-9.e+]*\).*/\1/p' | tail -1
}
python3 -c 'import sys; interval, basis = map(float, sys.argv[1:]); sys.exit(not 0 < 4 * interval < basis)' "$(rmse --linearised interval)" "$(rmse --linearised basis)" ||
  fail "whole functions linearised are as good as intervals"

for word in --extinction --negative --linearised --transfer; do
  value=1
  [ $word = --negative ] && value=keep
  [ $word = --linearised ] && value=basis
  refused_for "$word" "$bin/wavelet-raycast" d4.vdb -o x.exr $word $value
  [ $word = --transfer ] || refused_for "$word" "$bin/wavelet-raycast" d4.vdb -o x.exr --model composite --scene scene.yaml $word $value
done
refused_for --negative "$bin/wavelet-raycast" d4.vdb -o x.exr --model composite --linearised basis --negative clamp
grep -v "^ \|transfer" shaded.yaml >lit.yaml
refused_for shading "$bin/wavelet-raycast" d4.vdb -o x.exr --model composite --linearised basis --scene lit.yaml
white lit.exr --scene lit.yaml --extinction 0.3
refused_for --extinction "$bin/wavelet-raycast" d4.vdb -o x.exr --model composite --extinction -1
refused_for none.yaml "$bin/wavelet-raycast" d4.vdb -o x.exr --model composite --transfer none.yaml
"$bin/wavelet-raycast" spline.vdb -o x.exr --size 4x4 --depth 2 2>err && grep -q "go through the voxels" err || fail "no warning that the depth is below the levels"

# Pictures on the way: the last is the one without, byte for byte.
for model in "--model composite --extinction 0.3" "--model xray"; do
  # shellcheck disable=SC2086
  "$bin/wavelet-raycast" d4.vdb -o plain.exr $model --size 32x24 --depth 4 || fail "status $? for $model"
  # shellcheck disable=SC2086
  "$bin/wavelet-raycast" d4.vdb -o every.exr $model --size 32x24 --depth 4 --every 0.0001 --stats stats.json || fail "status $? for --every"
  cmp plain.exr every.exr || fail "--every changes the last picture of $model"
  grep -q '"pictures_on_the_way": *2' stats.json || fail "three levels make two pictures on the way"
done
refused_for "standard output" "$bin/wavelet-raycast" d4.vdb --output=- --every 1
refused_for --every "$bin/wavelet-raycast" d4.vdb -o x.exr --every 0

# Interrupted while the finest level is drawn: the last whole picture stays, and nothing else.
"$bin/vol-phantom" noise --dims 40 -o noise.nrrd || exit 2
"$bin/vol-dwt" noise.nrrd -o noise.vdb --wavelet daubechies-4 --quiet || exit 2
mkdir pictures
"$bin/wavelet-raycast" noise.vdb -o pictures/out.exr --model composite --extinction 0.01 --size 64x64 --depth 8 --every 0.01 --quiet &
tool=$!
for ((n = 0; n < 1200; ++n)); do
  [ -e pictures/out.exr ] && break
  sleep 0.1
done
kill -INT $tool
wait $tool
status=$?
[ $status -eq 130 ] || fail "status $status, not 130, of an interrupted run"
[ "$(ls -A pictures)" = out.exr ] || fail "an interruption leaves $(ls -A pictures)"
"$bin/img-compare" pictures/out.exr pictures/out.exr >/dev/null || fail "the picture left by an interruption is not whole"
levels=$(oiiotool --info -v pictures/out.exr | sed -n 's/.*precis.levels_drawn: "\([23]:3\)".*/\1/p')
[ -n "$levels" ] || fail "the picture does not say which levels it has"
"$bin/wavelet-raycast" noise.vdb -o levels.exr --model composite --extinction 0.01 --size 64x64 --depth 8 --levels "$levels" --quiet || fail "status $? for --levels $levels"
"$bin/img-compare" pictures/out.exr levels.exr --fail-above max=0 >/dev/null || fail "a picture on the way is not that of its levels"
exit $failed
