#!/usr/bin/env bash
# img-compare and vol-compare from outside: figures, files, exit statuses.
#   img-compare.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

# expect STATUS COMMAND...: runs it, its output in out and err
expect() {
  local status=$1
  shift
  "$@" >out 2>err
  local got=$?
  if [ "$got" -ne "$status" ]; then
    echo "expected status $status, got $got: $*"
    sed 's/^/    /' err
    failed=1
  fi
}
# one_line PATTERN: what went wrong is said in one line that matches
one_line() {
  if [ "$(wc -l <err)" -ne 1 ] || ! grep -q -- "$1" err; then
    echo "expected one line with '$1', got:"
    sed 's/^/    /' err
    failed=1
  fi
}
has() { grep -q -- "$2" "$1" || { echo "expected '$2' in:"; sed 's/^/    /' "$1"; failed=1; }; }

# Plain PPM and PGM go through OpenImageIO; 188 is 0.50289 in linear light.
ppm() { printf 'P3\n16 12\n255\n' >"$1"; for _ in $(seq 192); do echo "$2 $2 $2"; done >>"$1"; }
ppm grey.ppm 188
ppm same.ppm 188
ppm black.ppm 0
ppm brighter.ppm 189
printf 'P3\n16 11\n255\n' >other.ppm
for _ in $(seq 176); do echo 0 0 0; done >>other.ppm

expect 0 "$bin/img-compare" grey.ppm same.ppm --fail-above max=0 --fail-below ssim=1 --fail-below psnr=inf
expect 0 "$bin/img-compare" grey.ppm black.ppm --metric max,mse,rmse_byte --json
has out '"max": 0.502886'
has out '"mse": 0.252894'
expect 0 "$bin/img-compare" grey.ppm black.ppm --raw-values --metric max --json
has out '"max": 0.737254'
expect 0 "$bin/img-compare" brighter.ppm grey.ppm --peak truth --metric rmse_byte --json
has out '"rmse_byte": 3.039'
expect 1 "$bin/img-compare" grey.ppm black.ppm --fail-above rmse=0.5
has err 'rmse 0.502886 is not at most 0.5'
expect 0 "$bin/img-compare" grey.ppm black.ppm --fail-above rmse=0.503 --quiet
expect 1 "$bin/img-compare" grey.ppm black.ppm --fail-below ssim=0.99

expect 2 "$bin/img-compare" grey.ppm other.ppm
one_line 'grey.ppm is 16x12, other.ppm is 16x11'
expect 2 "$bin/img-compare" grey.ppm black.ppm --fail-above rmse=nan
one_line 'NaN'
expect 2 "$bin/img-compare" grey.ppm black.ppm --fail-above rmse
one_line 'expected a number'
expect 2 "$bin/img-compare" grey.ppm black.ppm --fail-above psnr=30
one_line 'expected METRIC=VALUE'
expect 2 "$bin/img-compare" grey.ppm black.ppm --peak 0
one_line 'peak'
expect 2 "$bin/img-compare" black.ppm black.ppm --peak truth
one_line 'no positive value'
expect 2 "$bin/img-compare" grey.ppm black.ppm --channel depth
one_line 'grey.ppm: has no channel depth'
expect 2 "$bin/img-compare" grey.ppm absent.exr
one_line 'absent.exr'
expect 2 "$bin/img-compare" - -
one_line 'standard input'
expect 2 "$bin/img-compare" grey.ppm black.ppm --difference difference.jpg
one_line 'difference.jpg'
echo hello >text.exr
expect 2 "$bin/img-compare" text.exr grey.ppm
one_line 'text.exr'
: >empty.png
expect 2 "$bin/img-compare" empty.png grey.ppm
one_line 'empty.png: empty'

# The difference picture: 0.50289 everywhere, held against itself; over a pipe too.
expect 0 "$bin/img-compare" black.ppm grey.ppm --difference absolute.exr
expect 0 "$bin/img-compare" black.ppm grey.ppm --difference signed.exr --signed
expect 0 "$bin/img-compare" absolute.exr grey.ppm --fail-above max=0
expect 0 "$bin/img-compare" signed.exr grey.ppm --fail-above max=1.00578 --fail-below psnr=-1
expect 0 "$bin/img-compare" - grey.ppm --fail-above max=0 <absolute.exr
expect 0 "$bin/img-compare" absolute.exr signed.exr --channel G --metric mse
expect 0 "$bin/img-compare" grey.ppm black.ppm --difference false.png --difference-scale 1 --stats stats.json
has err 'light yellow 1$'
has stats.json '"pass"\|"error"'
cp absolute.exr first.exr
expect 0 "$bin/img-compare" black.ppm grey.ppm --difference absolute.exr --threads 1
cmp -s absolute.exr first.exr || { echo "the difference picture differs from run to run"; failed=1; }
head -c 300 first.exr >cut.exr
expect 2 "$bin/img-compare" cut.exr first.exr
one_line 'cut.exr'

# Volumes: raw bytes 0..5, and the same plus 1 at one place.
[ -x "$bin/vol-compare" ] || exit "$failed"
printf '\000\001\002\003\004\005' >a.raw
printf '\000\001\002\003\004\007' >b.raw
raw=(--raw-dims 3x2x1 --raw-type u8)
expect 0 "$bin/vol-compare" a.raw a.raw "${raw[@]}" --fail-above max=0 --fail-below psnr=inf
expect 0 "$bin/vol-compare" b.raw a.raw "${raw[@]}" --json
has out '"max": 2'
has out '"mse": 0.6666'
has out '"differing": 1'
expect 1 "$bin/vol-compare" b.raw a.raw "${raw[@]}" --fail-above max=1
has err 'max 2 is not at most 1'
expect 2 "$bin/vol-compare" b.raw a.raw "${raw[@]}" --fail-above max=nan
one_line 'NaN'
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 2 1\nspacings: 1 1 2\nencoding: raw\n\n\000\001\002\003\004\005' >a.nrrd
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 2 1\nspacings: 1 1 1\nencoding: raw\n\n\000\001\002\003\004\005' >b.nrrd
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 1\nspacings: 1 1 1\nencoding: raw\n\n\000\001\002\003\004\005' >c.nrrd
expect 0 "$bin/vol-compare" a.nrrd b.nrrd --fail-above max=0
has out 'spacing 1,1,2 against 1,1,1'
expect 1 "$bin/vol-compare" a.nrrd b.nrrd --same-geometry
expect 2 "$bin/vol-compare" c.nrrd b.nrrd
one_line 'c.nrrd is 2x3x1, b.nrrd is 3x2x1'
exit "$failed"
