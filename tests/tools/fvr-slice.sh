#!/usr/bin/env bash
# vol-fft and fvr-slice from outside: pictures held against vol-raycast --model xray, the models, what is refused.
#   fvr-slice.sh BIN [fvr-slice-gpu]       with a second name: that tool's pictures held against fvr-slice's as well
set -u
bin=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 2
PATH="$bin:$PATH"
failed=0

fail() {
  echo "$*"
  failed=1
}
refused() { # COMMAND...: status 2 and one line
  "$@" >/dev/null 2>err
  local status=$?
  [ $status -eq 2 ] || fail "status $status, not 2: $*"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected of: $*: $(cat err)"
}
differs() { # A B MEASURE=LIMIT ...: fails unless within
  local a=$1 b=$2 limit
  shift 2
  for limit in "$@"; do
    img-compare "$a" "$b" --fail-above "$limit" >said 2>&1 || fail "$a and $b differ by more than $limit: $(tail -n 1 said)"
  done
}

# The integral against the sum, at any angle. A ray that grazes the box misses what the outermost voxels hold of their
# own half outside it: 0.4 % of the Gaussian's peak of 21, which is exp(-1/(2 0.3^2)) at its faces; elsewhere the two
# ends count half a voxel more each, of the same height.
vol-phantom gaussian --dims 40x48x44 --spacing 1.1,1,1.3 --origin 3,-7,20 -o one.nrrd || exit 2
vol-fft one.nrrd -o one.spectrum.nrrd --compensate es:8 || exit 2
# No symmetry, so that a mirrored or turned picture shows; but this one reaches its faces.
vol-phantom gaussians --dims 33x40x36 --spacing 1.3,1,1.1 --origin -3,5,9 -o cloud.nrrd || exit 2
vol-fft cloud.nrrd -o cloud.spectrum.nrrd --compensate es:8 || exit 2
for view in 0,0 30,20 90,0 0,90 -140,-35; do
  for volume in one cloud; do
    vol-raycast $volume.nrrd -o ray.exr --model xray --size 90x70 --view=$view --reconstruction b-spline --step 0.05v || fail "ray"
    fvr-slice $volume.spectrum.nrrd -o fvr.exr --size 90x70 --view=$view || fail "fvr-slice: status $?"
    if [ $volume = one ]; then differs fvr.exr ray.exr max=0.085 rmse=0.005; else differs fvr.exr ray.exr max=1.5 rmse=0.1; fi
  done
done
fvr-slice cloud.spectrum.nrrd -o mirrored.exr --size 90x70 --view=180,0 || fail "status $?"
fvr-slice cloud.spectrum.nrrd -o front.exr --size 90x70 --view=0,0 || fail "status $?"
img-compare mirrored.exr front.exr --fail-above rmse=1 >/dev/null 2>&1 && fail "a mirrored picture would not be seen"

# There and back.
vol-fft cloud.nrrd -o cloud64.nrrd --type f64 --pad 1.5 --compensate trilinear || fail "status $?"
vol-fft cloud64.nrrd -o back.nrrd --inverse || fail "--inverse: status $?"
vol-compare back.nrrd cloud.nrrd --fail-above max=1e-6 >said 2>&1 || fail "the inverse is not the volume: $(tail -n 1 said)"

# Measured plans are kept, and read again.
for run in first second; do
  vol-fft cloud.nrrd -o $run.nrrd --wisdom plans.fftw || fail "--wisdom: status $?"
  fvr-slice $run.nrrd -o $run.exr --size 32x32 || fail "status $?"
done
[ -s plans.fftw ] || fail "no wisdom was written"
differs first.exr second.exr max=1e-4
echo nonsense >bad.fftw
refused vol-fft cloud.nrrd -o missed.nrrd --wisdom bad.fftw

# Filters, types, algorithms: one picture.
vol-fft cloud.nrrd -o cloud64.nrrd --type f64 --compensate es:8 || fail "status $?"
fvr-slice cloud.spectrum.nrrd -o fast.exr --view 30,20 --size 64x64 || fail "status $?"
fvr-slice cloud.spectrum.nrrd -o plain.exr --view 30,20 --size 64x64 --algorithm plain || fail "status $?"
fvr-slice cloud64.nrrd -o double.exr --view 30,20 --size 64x64 || fail "status $?"
differs fast.exr plain.exr max=2e-4
differs fast.exr double.exr max=2e-4

# Models. With v = f/2 and all control points 2 the plain picture comes out, to the rounding of float.
vol-fft cloud.nrrd -o plain.nrrd || fail "status $?"
fvr-slice plain.nrrd -o plain.exr --view 30,20 --size 64x64 || fail "status $?"
vol-fft cloud.nrrd -o bezier.nrrd --bezier 6 --range 0,2 || fail "status $?"
fvr-slice bezier.nrrd -o ones.exr --view 30,20 --size 64x64 --control-points 2,2,2,2,2,2 || fail "status $?"
differs ones.exr plain.exr max=1e-4
vol-fft cloud.nrrd -o bands.nrrd --bands=-1:0.3,0.3:9 --edges || fail "status $?"
fvr-slice bands.nrrd -o both.exr --view 30,20 --size 64x64 --band-weights 1,1,0 || fail "status $?"
differs both.exr plain.exr max=1e-4
fvr-slice bands.nrrd -o coloured.exr --size 64x64 --band-weights 1,2,1 --band-colours 1,0,0:0,1,0:0,0,1 || fail "status $?"
for shading in depth-cue directional; do
  vol-fft cloud.nrrd -o $shading.nrrd --shading $shading || fail "status $?"
  fvr-slice $shading.nrrd -o $shading.png --size 64x64 || fail "$shading: status $?"
done
fvr-slice depth-cue.nrrd -o cued.exr --depth-cue 0 --size 32x32 || fail "status $?"
fvr-slice directional.nrrd -o lit.exr --light 1,0,0 --size 32x32 || fail "status $?"

# Many views in one run are the same pictures as one by one.
fvr-slice plain.nrrd -o turn.exr --view 30,20 --turntable 3 --size 64x64 --stats stats.json || fail "status $?"
[ "$(echo turn-*.exr)" = "turn-000.exr turn-001.exr turn-002.exr" ] || fail "numbered pictures: $(echo turn*)"
differs turn-000.exr plain.exr max=0
grep -q '"frames_per_second"' stats.json || fail "no frames per second in the stats"
fvr-slice plain.nrrd -o list.exr --view 0,0 --view 150,20 --size 64x64 || fail "status $?"
differs list-001.exr turn-001.exr max=1e-4

fvr-slice plain.nrrd -o stack.nrrd --view 30,20 --turntable 3 --size 64x64 || fail "status $?"
vol-info stack.nrrd | grep -q "dims  *64 64 3" || fail "three views are not three slices: $(vol-info stack.nrrd)"

# What cannot be done.
refused fvr-slice plain.nrrd -o missed.exr --filter es:6
refused fvr-slice plain.nrrd -o missed.exr --filter cubic
refused fvr-slice plain.nrrd -o missed.exr --light 1,0,0
refused fvr-slice bands.nrrd -o missed.nrrd --band-colours 1,0,0:0,1,0:0,0,1
refused fvr-slice bezier.nrrd -o missed.exr --control-points 1,2
refused fvr-slice directional.nrrd -o missed.exr --light 0,0,0
refused fvr-slice plain.nrrd -o - --turntable 3
refused fvr-slice cloud.nrrd -o missed.exr
refused vol-fft plain.nrrd -o missed.nrrd
refused vol-fft cloud.nrrd -o missed.nrrd --compensate es:40
refused vol-fft cloud.nrrd -o missed.nrrd --bands 3:1
refused vol-fft cloud.nrrd -o missed.nrrd --bezier 6 --edges
refused vol-fft cloud.nrrd -o missed.nrrd --inverse
[ ! -e missed.exr ] && [ ! -e missed.nrrd ] || fail "a refused run left its output"
fvr-slice cloud.spectrum.nrrd -o other.exr --filter trilinear --size 16x16 2>err || fail "status $?"
grep -q warning err || fail "no warning of a filter that the spectrum was not compensated for"

other=${2:-}
[ -n "$other" ] || exit $failed
__EGL_VENDOR_LIBRARY_DIRS=/nowhere "$other" plain.nrrd -o missed.exr 2>err
[ $? -eq 3 ] || fail "without EGL: not status 3"
[ "$(wc -l <err)" -eq 1 ] || fail "one line expected without EGL: $(cat err)"
"$other" plain.nrrd -o gpu.exr --size 16x16 2>err
status=$?
if [ $status -eq 3 ]; then
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected of $other without a device: $(cat err)"
  echo "skipped: $(cat err)"
  [ $failed -eq 0 ] && exit 77
  exit 1
fi
for filter in nearest trilinear catmull-rom catmull-rom-fast sinc:5 sinc:8 es:4 es:6 es:8 es:12; do
  case $filter in es:* | *-fast) compensation=$filter ;; *) compensation=none ;; esac
  vol-fft cloud.nrrd -o filtered.nrrd --compensate $compensation || fail "status $?"
  fvr-slice filtered.nrrd -o cpu.exr --view 30,20 --size 90x64 --filter $filter || fail "status $?"
  peak=$(fvr-slice filtered.nrrd -o cpu.png --view 30,20 --size 90x64 --filter $filter --stats - 2>&1 | sed -n 's/.*"exposure": \([0-9][0-9.e-]*\).*/\1/p')
  limit=$(LC_ALL=C awk "BEGIN { print 1e-5 / $peak }")
  for ifft in fftw gpu; do
    "$other" filtered.nrrd -o gpu.exr --view 30,20 --size 90x64 --filter $filter --ifft $ifft 2>err || fail "$filter $ifft: $(cat err)"
    differs gpu.exr cpu.exr max=$limit
  done
done
refused "$other" cloud64.nrrd -o missed.exr
refused "$other" plain.nrrd -o missed.exr --size 11x11 --wrap --ifft gpu
"$other" bands.nrrd -o gpu.exr --size 64x64 --band-weights 1,2,1 --band-colours 1,0,0:0,1,0:0,0,1 || fail "status $?"
differs gpu.exr coloured.exr max=1e-3
exit $failed
