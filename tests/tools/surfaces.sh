#!/usr/bin/env bash
# vol-raycast --isovalue and --mesh from outside: the isosurface's own picture, a mesh in its place, what cannot be asked for.
#   surfaces.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

cat >clear.yaml <<END
camera: {azimuth: 30, elevation: 20}
transfer: {colours: [[0, 1, 1, 1]], opacity: [[0, 0]]}
shading: true
END
cat >fog.yaml <<END
camera: {azimuth: 30, elevation: 20}
transfer: {colours: [[0, 0.2, 0.4, 1]], opacity: [[0, 0.02]]}
reference_length: 1
END
"$bin/vol-phantom" sphere --dims 65 -o ball.nrrd || exit 2
# Without a medium the picture is isosurf-ray's, and half as bright where half transparent and one sheet deep.
"$bin/isosurf-ray" ball.nrrd --isovalue 0.5 -o own.exr --size 64x64 --scene clear.yaml || fail "isosurf-ray: status $?"
"$bin/vol-raycast" ball.nrrd --isovalue 0.5 -o in.exr --size 64x64 --scene clear.yaml --stats stats.json || fail "status $? for --isovalue"
grep -q '"caster": *"plain"' stats.json || fail "the stats must tell the plain caster"
# Every phase is timed once, and compute is their sum: the surfaces' phase has a name of its own.
/usr/bin/python3 - <<'END' || fail "time_s.compute is not the sum of the phases"
import json
times = json.load(open("stats.json"))["time_s"]
assert all(len(each) == 1 for each in times["phases"].values()) and "surfaces" in times["phases"], times
assert abs(times["compute"] - sum(sum(each) for each in times["phases"].values())) < 1e-9, times
END
hits=$(grep -o '"surface_hits": *[0-9]*' stats.json | grep -o '[0-9]*$')
[ "${hits:-0}" -gt 400 ] || fail "a ball has ${hits:-no} hits"
"$bin/img-compare" own.exr in.exr --fail-above max=0 >/dev/null || fail "--isovalue without a medium is not isosurf-ray's picture"
# A mesh of the surface in its place, in a medium; a ball that is missing is an RMSE of 0.056.
"$bin/isosurf-mc" ball.nrrd --isovalue 0.5 -o ball.ply && "$bin/isosurf-mc" ball.nrrd --isovalue 0.5 -o ball.obj && "$bin/isosurf-mc" ball.nrrd --isovalue 0.5 -o ball.stl || exit 2
"$bin/vol-raycast" ball.nrrd --isovalue 0.5 --surface-opacity 0.5 --surface-colour 0.9,0.2,0.1 -o surface.exr --size 64x64 --scene fog.yaml || fail "status $? for a translucent surface"
for format in ply obj; do
  "$bin/vol-raycast" ball.nrrd --mesh ball.$format --mesh-opacity 0.5 --mesh-colour 0.9,0.2,0.1 -o mesh-$format.exr --size 64x64 --scene fog.yaml || fail "status $? for --mesh .$format"
  "$bin/img-compare" surface.exr mesh-$format.exr --fail-above rmse=0.02 >/dev/null || fail "a mesh in place of its surface: $("$bin/img-compare" surface.exr mesh-$format.exr)"
done
"$bin/img-compare" mesh-ply.exr mesh-obj.exr --fail-above max=1e-5 >/dev/null || fail "PLY and OBJ of one mesh differ"
# STL has the triangles' normals alone: the light differs by an RMSE of 0.0016; a mesh that is missing is one of 0.068.
"$bin/vol-raycast" ball.nrrd --mesh ball.stl -o stl.exr --size 64x64 --scene fog.yaml || fail "status $? for STL"
"$bin/vol-raycast" ball.nrrd --mesh ball.ply -o opaque.exr --size 64x64 --scene fog.yaml || fail "status $? for an opaque mesh"
"$bin/img-compare" stl.exr opaque.exr --fail-above rmse=0.005 >/dev/null || fail "STL and PLY of one mesh: $("$bin/img-compare" stl.exr opaque.exr)"
"$bin/vol-raycast" ball.nrrd -o none.exr --size 64x64 --scene fog.yaml || fail "status $? without surfaces"
"$bin/img-compare" none.exr surface.exr --fail-above rmse=0.04 >/dev/null 2>&1
[ $? -eq 1 ] || fail "the surface is not in the picture"
# Two meshes, each with a look of its own: as the two isosurfaces that they were made of, and all triangles counted.
"$bin/isosurf-mc" ball.nrrd --isovalue 0.2 -o outer.ply --quiet --stats outer.json && "$bin/isosurf-mc" ball.nrrd --isovalue 0.8 -o inner.ply --quiet --stats inner.json || exit 2
look="opacity 0.3 --surface-opacity 1 --surface-colour 0.1,0.9,0.2 --surface-colour 0.9,0.2,0.1"
# shellcheck disable=SC2086
"$bin/vol-raycast" ball.nrrd --isovalue 0.2,0.8 --surface-$look -o two-surfaces.exr --size 64x64 --scene fog.yaml || fail "status $? for two surfaces"
# shellcheck disable=SC2086
"$bin/vol-raycast" ball.nrrd --mesh outer.ply --mesh inner.ply --mesh-${look//--surface/--mesh} -o two-meshes.exr --size 64x64 --scene fog.yaml --stats two.json || fail "status $? for two meshes"
"$bin/img-compare" two-surfaces.exr two-meshes.exr --fail-above rmse=0.02 >/dev/null || fail "two meshes in place of their surfaces: $("$bin/img-compare" two-surfaces.exr two-meshes.exr)"
"$bin/img-compare" two-meshes.exr opaque.exr --fail-above rmse=0.02 >/dev/null 2>&1
[ $? -eq 1 ] || fail "two meshes are not one"
/usr/bin/python3 - <<'END' || fail "mesh_triangles is not the sum of both"
import json
counts = [json.load(open(f"{name}.json"))["counts"] for name in ("outer", "inner", "two")]
assert counts[2]["mesh_triangles"] == counts[0]["triangles"] + counts[1]["triangles"], counts
END
# Where a mesh lies is not in the picture: the same bytes by another path.
mkdir other && cp ball.ply other/name.ply || exit 2
"$bin/vol-raycast" ball.nrrd --mesh other/name.ply -o elsewhere.exr --size 64x64 --scene fog.yaml || fail "status $? for a mesh elsewhere"
cmp -s opaque.exr elsewhere.exr || fail "the same mesh by another path makes another file"
# An isosurface that is nowhere: no triangle, a warning, the picture without it.
for format in ply obj stl; do
  "$bin/isosurf-mc" ball.nrrd --isovalue 7 -o nowhere.$format --quiet || exit 2
  "$bin/vol-raycast" ball.nrrd --mesh nowhere.$format -o nowhere.exr --size 64x64 --scene fog.yaml 2>err || fail "status $? for an empty .$format"
  grep -q "warning: nowhere.$format: no triangles" err || fail "no warning of an empty .$format: $(cat err)"
  "$bin/img-compare" none.exr nowhere.exr --fail-above max=1e-6 >/dev/null || fail "an empty .$format is in the picture"
done
# The truth of a hybrid picture, several surfaces at once, and steps against it.
"$bin/vol-raycast" ball.nrrd --isovalue 0.2,0.5 --isovalue 0.8 --surface-opacity 0.3 --surface-opacity 0.4 --surface-opacity 1 -o truth.exr --size 64x64 --scene fog.yaml --quadrature reference || fail "status $? for reference"
"$bin/vol-raycast" ball.nrrd --isovalue 0.2,0.5,0.8 --surface-opacity 0.3 --surface-opacity 0.4 --surface-opacity 1 -o steps.exr --size 64x64 --scene fog.yaml || fail "status $? for steps"
"$bin/img-compare" truth.exr steps.exr --fail-above max=1e-6 >/dev/null || fail "a constant medium needs no small steps"

printf 'ply\nformat ascii 1.0\nelement vertex 99999999999\nproperty float x\nproperty float y\nproperty float z\nend_header\n' >bad.ply
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >cloud.obj
printf 'v 1e200 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >huge.obj
for wrong in "--isovalue nan" "--isovalue 1,,2" "--isovalue 1 --surface-colour 2" "--isovalue 1 --surface-opacity 1.5" "--surface-opacity 0.5" "--isovalue 1,2,3 --surface-opacity 1 --surface-opacity 0.5" "--mesh none.ply" "--mesh bad.ply" "--mesh cloud.obj" "--mesh ball.ply --mesh huge.obj" "--mesh ball.nrrd" "--isovalue 1 --model xray" "--isovalue 1 --max-error 0.01" "--isovalue 1 --reconstruction nearest"; do
  # shellcheck disable=SC2086
  "$bin/vol-raycast" ball.nrrd $wrong -o a.exr --size 16x16 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
  [ ! -e a.exr ] || fail "$wrong left a picture"
  case $wrong in *--mesh*) grep -q "${wrong##* }: " err || fail "the file is not named: $(cat err)" ;; esac
done
exit $failed
