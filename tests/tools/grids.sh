#!/usr/bin/env bash
# Curvilinear grids from outside: what vol-phantom writes and vol-info says of it; what cannot be asked for.
#   grids.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

says() { # FILE WORDS: vol-info says the words, in one line
  "$bin/vol-info" "$1" | tr -s ' ' | grep -q "$2" || fail "vol-info $1 does not say '$2': $("$bin/vol-info" "$1")"
}

for name in half-torus spherical-shell twisted-box sheared-box c-grid delta-wing; do
  "$bin/vol-phantom" $name --dims 5x7x9 --field ramp -o $name.vts || fail "status $? for $name"
  says $name.vts "cells 192"
  says $name.vts "inverted_cells 0"
  "$bin/vol-phantom" $name --dims 5x7x9 --field ramp -o - | cmp - $name.vts || fail "standard output differs from $name.vts"
done
"$bin/vol-phantom" half-torus -o paper.vts && says paper.vts "cells 3"
says spherical-shell.vts "collapsed_cells 64" # two poles, 4 layers, 8 round
says twisted-box.vts "collapsed_cells 0"

# PLOT3D has no magic bytes: by its extension, or by an option that only it has.
echo "2 2 2  0 1 0 1 0 1 0 1  2*0 2*1 2*0 2*1  4*0 4*1" >cube.xyz
says cube.xyz "volume 1.0"
echo "2 2 2  0.5 0 1 0  8*1 8*2 8*0 8*0 8*4" >cube.q
# p = 0.4 (4 - 2^2 / 2) = 0.8, but for rounding: 1.4 - 1 is not 0.4
"$bin/vol-info" cube.xyz --solution cube.q --variable pressure | tr -s ' ' | grep -qE "max 0\.(8|79999999999)" || fail "pressure of a uniform flow"
cp cube.xyz cube.bin && "$bin/vol-info" cube.bin --plot3d auto >/dev/null || fail "--plot3d asks for a grid"

echo "2 2 2  0.5 0 1 0  8*1 8*2 8*0 8*0 8*0" >cold.q
for wrong in "cube.xyz --solution cold.q --variable pressure" "cube.xyz --solution cube.q --variable helicity" "cube.xyz --plot3d big" \
  "cube.xyz --plot3d huge" "cube.xyz --solution none.q" "cube.xyz --solution cube.xyz" "half-torus.vts --solution cube.q"; do
  # shellcheck disable=SC2086
  "$bin/vol-info" $wrong >out 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
done
"$bin/vol-phantom" c-grid -o c.nrrd 2>err && fail "a grid is no NRRD"
"$bin/vol-phantom" c-grid --dims 1 -o c.vts 2>err && fail "a grid of one point encloses nothing"
[ -e c.vts ] && fail "a refused grid leaves a file"
exit $failed
