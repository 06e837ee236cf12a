#!/usr/bin/env bash
# vol-fft and fvr-slice from outside: pictures held against vol-raycast --model xray, the models, what is refused.
#   fvr-slice.sh BIN [fvr-slice-gpu]       with a second name: that tool's pictures held against fvr-slice's as well
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"
PATH="$bin:$PATH"
answers_no() { # COMMAND...: status 1, which is neither success nor failure to answer
  "$@" >/dev/null 2>err
  local status=$?
  [ $status -eq 1 ] || fail "status $status, not 1: $*: $(cat err)"
}
warns() { # WORD COMMAND...: done, with a warning that has the word
  local word=$1
  shift
  "$@" 2>err || fail "status $?: $*"
  grep -q "warning.*$word" err || fail "no warning of $word: $*: $(cat err)"
}
adds_up() { # A B SUM [mirrored]: stacks of one picture; A + B, mirrored left to right, is SUM to 1e-6 of its largest
  python3 - "$@" <<'PYTHON' || fail "$1 and $2 do not add up to $3"
import array, sys
def rows(path):
    head, data = open(path, "rb").read().split(b"\n\n", 1)
    width = next(int(line.split()[1]) for line in head.decode().split("\n") if line.startswith("sizes:"))
    values = array.array("f", data)
    return [values[i:i + width] for i in range(0, len(values), width)]
a, b, total = (rows(path) for path in sys.argv[1:4])
if len(sys.argv) > 4: b = [row[::-1] for row in b]
peak = max(map(max, total))
worst = max(abs(x + y - z) for p, q, r in zip(a, b, total) for x, y, z in zip(p, q, r))
print("adds up to", worst / peak)
sys.exit(not (peak > 0 and worst <= 1e-6 * peak))
PYTHON
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
# No symmetry, so that a mirrored or turned picture shows; but this one reaches its faces, where a ray along one misses
# half a voxel's breadth of it, all along: a tenth of the largest pixel, 15, in few pixels.
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
answers_no img-compare mirrored.exr front.exr --fail-above rmse=1  # or a mirrored picture would not be seen

# There and back.
vol-fft cloud.nrrd -o cloud64.nrrd --type f64 --pad 1.5 --compensate trilinear || fail "status $?"
vol-fft cloud64.nrrd -o back.nrrd --inverse || fail "--inverse: status $?"
vol-compare back.nrrd cloud.nrrd --fail-above max=1e-6 >said 2>&1 || fail "the inverse is not the volume: $(tail -n 1 said)"

# Measured plans are kept, and read again.
vol-fft cloud.nrrd -o plain.nrrd --stats estimated.json || fail "status $?"
for run in first second; do
  vol-fft cloud.nrrd -o $run.nrrd --wisdom plans.fftw --stats measured.json || fail "--wisdom: status $?"
  fvr-slice $run.nrrd -o $run.exr --size 32x32 || fail "status $?"
done
[ -s plans.fftw ] || fail "no wisdom was written"
# Plans are tried on a line, which takes no memory to speak of.
[ "$(grep planned_bytes estimated.json)" = "$(grep planned_bytes measured.json)" ] || fail "--wisdom plans for other memory"
# The cloud's pictures go up to 15; they are the same to some roundings of float, 6e-8 each: 1e-6 of that.
differs first.exr second.exr max=1.5e-5
echo nonsense >bad.fftw
refused vol-fft cloud.nrrd -o missed.nrrd --wisdom bad.fftw

# Filters, types, algorithms: one picture.
vol-fft cloud.nrrd -o cloud64.nrrd --type f64 --compensate es:8 || fail "status $?"
fvr-slice cloud.spectrum.nrrd -o fast.exr --view 30,20 --size 64x64 || fail "status $?"
fvr-slice cloud.spectrum.nrrd -o plain.exr --view 30,20 --size 64x64 --algorithm plain || fail "status $?"
fvr-slice cloud64.nrrd -o double.exr --view 30,20 --size 64x64 || fail "status $?"
differs fast.exr plain.exr max=1.5e-5
differs fast.exr double.exr max=1.5e-5

# Models. With v = f/2 and all control points 2 the plain picture comes out, to the rounding of float.
vol-fft cloud.nrrd -o plain.nrrd || fail "status $?"
fvr-slice plain.nrrd -o plain.exr --view 30,20 --size 64x64 || fail "status $?"
vol-fft cloud.nrrd -o bezier.nrrd --bezier 6 --range 0,2 || fail "status $?"
fvr-slice bezier.nrrd -o ones.exr --view 30,20 --size 64x64 --control-points 2,2,2,2,2,2 || fail "status $?"
differs ones.exr plain.exr max=1.5e-5
vol-fft cloud.nrrd -o bands.nrrd --bands=-1:0.3,0.3:9 --edges || fail "status $?"
fvr-slice bands.nrrd -o both.exr --view 30,20 --size 64x64 --band-weights 1,1,0 || fail "status $?"
differs both.exr plain.exr max=1.5e-5
fvr-slice bands.nrrd -o coloured.exr --size 64x64 --band-weights 1,2,1 --band-colours 1,0,0:0,1,0:0,0,1 || fail "status $?"
for shading in depth-cue directional; do
  vol-fft cloud.nrrd -o $shading.nrrd --shading $shading || fail "status $?"
  fvr-slice $shading.nrrd -o $shading.png --size 64x64 || fail "$shading: status $?"
done
# t/2 (1 + V.D): black for t = 0; V and -V add up to f, mirrored as both are seen from their own side.
fvr-slice depth-cue.nrrd -o cued.exr --depth-cue 0 --size 64x64 || fail "status $?"
fvr-slice bezier.nrrd -o black.exr --control-points 0,0,0,0,0,0 --size 64x64 || fail "status $?"
differs cued.exr black.exr max=0
answers_no img-compare ones.exr black.exr --fail-above max=1
fvr-slice depth-cue.nrrd -o near.nrrd --size 65x64 || fail "status $?"
fvr-slice depth-cue.nrrd -o far.nrrd --size 65x64 --view 180,0 || fail "status $?"
fvr-slice plain.nrrd -o sum.nrrd --size 65x64 || fail "status $?"
adds_up near.nrrd far.nrrd sum.nrrd mirrored
# f (1 + L.N)/2: opposite lights add up to f, of any length; the light of a view is its viewer's.
for view in 0,0 30,20; do
  fvr-slice directional.nrrd -o left.nrrd --light 1,2,3 --view $view --size 64x64 || fail "status $?"
  fvr-slice directional.nrrd -o right.nrrd --light=-1e200,-2e200,-3e200 --view $view --size 64x64 || fail "status $?"
  fvr-slice plain.nrrd -o sum.nrrd --view $view --size 64x64 || fail "status $?"
  adds_up left.nrrd right.nrrd sum.nrrd
done
fvr-slice directional.nrrd -o lit.exr --light 0,0,1e-200 --size 64x64 || fail "status $?"
fvr-slice directional.nrrd -o viewer.exr --size 64x64 || fail "status $?"
differs lit.exr viewer.exr max=0
for shading in depth-cue directional; do # PNG: the picture at 8 bits, its largest value white
  fvr-slice $shading.nrrd -o $shading.exr --size 64x64 || fail "$shading: status $?"
  answers_no img-compare $shading.exr black.exr --fail-above max=1
  [ "$(head -c 4 $shading.png | tail -c 3)" = PNG ] || fail "$shading.png is no PNG"
done

# Many views in one run are the same pictures as one by one.
fvr-slice plain.nrrd -o turn.exr --view 30,20 --turntable 3 --size 64x64 --stats stats.json || fail "status $?"
[ "$(echo turn-*.exr)" = "turn-000.exr turn-001.exr turn-002.exr" ] || fail "numbered pictures: $(echo turn*)"
differs turn-000.exr plain.exr max=0
grep -q '"frames_per_second"' stats.json || fail "no frames per second in the stats"
fvr-slice plain.nrrd -o list.exr --view 0,0 --view 150,20 --size 64x64 || fail "status $?"
differs list-001.exr turn-001.exr max=1.5e-5

fvr-slice plain.nrrd -o stack.nrrd --view 30,20 --turntable 3 --size 64x64 || fail "status $?"
vol-info stack.nrrd | grep -q "dims  *64 64 3" || fail "three views are not three slices: $(vol-info stack.nrrd)"

# vol-info describes a spectrum, and says so of none that lies.
vol-info plain.nrrd >info || fail "status $?: vol-info"
for line in "holds  *spectrum" "padding  *2" "model  *plain" "compensation  *none" "spectra  *.f." "type  *complex f32"; do
  grep -Eq "^  $line" info || fail "vol-info of a spectrum without $line: $(cat info)"
done
vol-info - <plain.nrrd | grep -q "holds  *spectrum" || fail "vol-info of a spectrum in a pipe"
# shellcheck disable=SC2002
cat plain.nrrd | vol-info - | grep -q "holds  *spectrum" || fail "vol-info of a spectrum in a pipe of unknown size"
head -c -3 plain.nrrd >short.nrrd
refused vol-info short.nrrd
refused vol-info - < <(cat short.nrrd)
grep -q "ends after" err || fail "a spectrum that is cut off: $(cat err)"
warns "--checksum, --histogram, --missing" vol-info plain.nrrd --checksum --histogram 4 --missing 0
vol-dwt cloud.nrrd -o cloud.vdb --wavelet haar --quiet || exit 2
warns "--histogram, --volume" vol-info cloud.vdb --histogram 4 --volume 0
vol-info plain.nrrd cloud.vdb >/dev/null 2>err || fail "status $?: vol-info"
[ ! -s err ] || fail "a warning of nothing: $(cat err)"

# A spectrum that holds what no spectrum does, or says what it is not.
python3 - <<'PYTHON' || exit 2
import struct
head, data = open("plain.nrrd", "rb").read().split(b"\n\n", 1)
middle = len(data) // 8 * 4
def write(name, head, data): open(name, "wb").write(head + b"\n\n" + data)
lines = head.split(b"\n")
kind = lines.index(b"precis.kind:=spectrum")
write("late.nrrd", b"\n".join(lines[:1] + [b"# " + b"x" * 1000] + lines[1:]), data)
open("crlf.nrrd", "wb").write(head.replace(b"\n", b"\r\n") + b"\r\n\r\n" + data)
write("none.nrrd", b"\n".join(lines[:kind] + [b"other:=precis.kind:=spectrum"] + lines[kind + 1:]), data)
write("nan.nrrd", head, data[:middle] + struct.pack("<f", float("nan")) + data[middle + 4:])
write("infinite.nrrd", head, data[:middle] + struct.pack("<f", float("inf")) + data[middle + 4:])
for name, is_so, lie in (("padding", b"padding:=2", b"padding:=4"), ("model", b"model:=plain", b"model:=other"),
                         ("count", b"model:=plain", b"model:=depth-cue"), ("space", b"space:=", b"space:=zzz")):
    assert is_so in head, is_so
    write("lie-" + name + ".nrrd", head.replace(is_so, lie), data)
PYTHON
for good in late crlf; do vol-info $good.nrrd | grep -q "holds  *spectrum" || fail "$good.nrrd is a spectrum"; done
vol-info none.nrrd 2>err | grep -q "holds  *spectrum" && fail "none.nrrd is no spectrum"
for bad in lie-padding lie-model lie-count lie-space; do refused vol-info $bad.nrrd; done
for bad in nan infinite lie-padding lie-model lie-count lie-space; do
  refused_for $bad.nrrd fvr-slice $bad.nrrd -o missed.exr --size 16x16
  refused_for $bad.nrrd vol-fft $bad.nrrd -o missed.nrrd --inverse
done
refused_for plain.nrrd vol-fft plain.nrrd -o missed.nrrd --inverse --spectrum other
refused_for plain.nrrd fvr-slice plain.nrrd -o missed.exr --control-points 1
refused_for plain.nrrd fvr-slice plain.nrrd -o missed.nrrd --size 20000x20000 --turntable 64  # a stack is held as a whole
refused_for missing/plans vol-fft cloud.nrrd -o missed.nrrd --wisdom missing/plans
refused_for "a file of their own" vol-fft cloud.nrrd -o missed.nrrd --type f64 --wisdom plans.fftw

# Options that contradict each other.
for option in "--pad 2" "--compensate es:6" "--type f64" "--shading directional" "--bezier 3" "--bands 0:1" --edges; do
  refused vol-fft plain.nrrd -o missed.nrrd --inverse $option
done
refused vol-fft cloud.nrrd -o missed.nrrd --spectrum f
refused fvr-slice plain.nrrd -o missed.nrrd --format png
refused fvr-slice plain.nrrd -o missed.exr --exposure 5

# What is likely to be wrong.
vol-fft cloud.nrrd -o unpadded.nrrd --pad 1 || fail "status $?"
warns padding fvr-slice unpadded.nrrd -o other.exr --size 16x16
warns compensation vol-fft cloud.nrrd -o other.nrrd --pad 1 --compensate catmull-rom-fast

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
# Finer than the volume, with points on the spectrum's faces, which count half.
fvr-slice plain.nrrd -o cpu.exr --wrap --size 60x120 --width 20 || fail "status $?"
"$other" plain.nrrd -o gpu.exr --wrap --size 60x120 --width 20 || fail "status $?"
differs gpu.exr cpu.exr max=1.5e-4 # 1e-5 of 15
refused "$other" cloud64.nrrd -o missed.exr
refused "$other" plain.nrrd -o missed.exr --size 11x11 --wrap --ifft gpu
"$other" bands.nrrd -o gpu.exr --size 64x64 --band-weights 1,2,1 --band-colours 1,0,0:0,1,0:0,0,1 || fail "status $?"
differs gpu.exr coloured.exr max=3e-4  # 1e-5 of 30, twice what the cloud goes up to
exit $failed
