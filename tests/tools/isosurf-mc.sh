#!/usr/bin/env bash
# isosurf-mc from outside: the three formats hold the same mesh, several isovalues, world coordinates, the record.
#   isosurf-mc.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

"$bin/vol-phantom" sphere --dims 33x37x41 --spacing 0.5,1,0.75 --origin 10,-20,30 -o sphere.nrrd || exit 2
for name in ball.ply ball.obj ball.stl; do
  "$bin/isosurf-mc" sphere.nrrd --isovalue 0.5 -o $name --quiet --stats $name.json || fail "status $? for $name"
done
"$bin/isosurf-mc" sphere.nrrd --isovalue 0.5 -o - --quiet | cmp - ball.ply || fail "standard output differs from a file"
"$bin/isosurf-mc" sphere.nrrd --isovalue 0.25,0.5,0.75 -o three.ply --stats three.json || fail "status $? for three isovalues"
"$bin/vol-phantom" noise --dims 20x17x23 --type u8 -o noise.nrrd || exit 2
"$bin/isosurf-mc" noise.nrrd --isovalue 128 --close -o closed.ply --stats closed.json || fail "status $? for --close"
"$bin/isosurf-mc" noise.nrrd --isovalue 128 --close --no-weld -o closed.ply --stats manifold.json || fail "status $? for --no-weld"

python=/usr/bin/python3
[ -x $python ] || python=python3
$python - <<'PYTHON' || failed=1
import json
import math
import struct
import sys

broken = []


def expect(promise, holds, *details):
    if not holds:
        broken.append(" ".join(map(str, (promise, *details))))


def read_ply(name):
    data = open(name, "rb").read()
    head, body = data.split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")]
    reals = sum(line.startswith("property float") for line in head.decode().splitlines())
    extra = 8 * (b"property double isovalue" in head)
    size = 4 * reals + extra
    vertices = [struct.unpack_from("<3f", body, size * i) for i in range(counts[0])]
    faces = [struct.unpack_from("<B3i", body, size * counts[0] + 13 * i)[1:] for i in range(counts[1])]
    expect("the PLY file is as long as its header says", len(body) == size * counts[0] + 13 * counts[1])
    return [tuple(vertices[v] for v in face) for face in faces], len(vertices)


def read_obj(name):
    vertices, faces = [], []
    for line in open(name):
        word, *rest = line.split()
        if word == "v":
            vertices.append(struct.unpack("<3f", struct.pack("<3f", *map(float, rest))))
        elif word == "f":
            faces.append(tuple(vertices[int(v.split("/")[0]) - 1] for v in rest))
    return faces


def read_stl(name):
    data = open(name, "rb").read()
    (count,) = struct.unpack_from("<I", data, 80)
    faces = []
    for i in range(count):
        numbers = struct.unpack_from("<12f", data, 84 + 50 * i)
        faces.append((numbers[3:6], numbers[6:9], numbers[9:12]))
    return faces


ply, vertices = read_ply("ball.ply")
expect("OBJ holds the triangles of PLY", read_obj("ball.obj") == ply)
expect("STL holds the triangles of PLY", read_stl("ball.stl") == ply)

# The phantom: a ball of radius 0.6 in [-1, 1]^3 stretched to the box of the outermost samples.
half = (8.0, 18.0, 15.0)
centre = (10 + 8.0, -20 + 18.0, 30 + 15.0)
for face in ply:
    for p in face:
        r = math.sqrt(sum(((p[a] - centre[a]) / half[a]) ** 2 for a in range(3)))
        expect("vertices are at their world place", abs(r - 0.6) < 0.01, p, r)

record = json.load(open("ball.ply.json"))
surface = record["result"]["surfaces"][0]
ellipsoid = 4 / 3 * math.pi * 0.6**3 * half[0] * half[1] * half[2]
expect("the record's volume is the ellipsoid's", abs(surface["volume"] / ellipsoid - 1) < 0.01, surface["volume"], ellipsoid)
expect("a ball's Euler characteristic is 2", surface["euler_characteristic"] == 2 and surface["components"] == 1, surface)
expect("a ball has no faults", surface["boundary_edges"] == 0 and surface["non_manifold_edges"] == 0, surface)
expect("the record counts the file's mesh", (surface["vertices"], surface["triangles"]) == (vertices, len(ply)), surface)
expect("the record counts vertices and triangles",
       (record["counts"]["vertices"], record["counts"]["triangles"]) == (vertices, len(ply)), record["counts"])

three, _ = read_ply("three.ply")
surfaces = json.load(open("three.json"))["result"]["surfaces"]
expect("three isovalues are three surfaces", [s["isovalue"] for s in surfaces] == [0.25, 0.5, 0.75], surfaces)
expect("three surfaces are in the file", sum(s["triangles"] for s in surfaces) == len(three))
expect("the second of three is the one alone", surfaces[1] == surface, surfaces[1], surface)
expect("a lower isovalue encloses more", surfaces[0]["volume"] > surfaces[1]["volume"] > surfaces[2]["volume"])

closed = json.load(open("closed.json"))["result"]["surfaces"][0]
expect("a closed surface has no boundary", closed["boundary_edges"] == 0, closed)
before = closed["before_welding"]
expect("before welding the mesh is a closed manifold", before["non_manifold_edges"] == before["boundary_edges"] == 0, before)
expect("welding touches sheets of these integers", closed["non_manifold_edges"] > 0 and closed["volume"] is None, closed)
alone = json.load(open("manifold.json"))["result"]["surfaces"][0]
expect("--no-weld is the manifold", alone["non_manifold_edges"] == 0 and "before_welding" not in alone and alone["volume"] > 0, alone)
for line in broken[:10]:
    print(line)
sys.exit(bool(broken))
PYTHON

# Coordinates that floats are too coarse for are refused, and are right as doubles.
"$bin/vol-phantom" sphere --dims 16 --spacing 0.01 --origin 500000,5000000,100 -o utm.nrrd || exit 2
"$bin/isosurf-mc" utm.nrrd --isovalue 0.5 -o utm.ply 2>err
[ $? -eq 2 ] && grep -q -e "--type f64" err && [ "$(wc -l <err)" -eq 1 ] || fail "f32 at 5e6 with spacing 0.01: $(cat err)"
[ ! -e utm.ply ] || fail "a mesh was written after all"
"$bin/isosurf-mc" utm.nrrd --isovalue 0.5 --type f64 -o utm.ply --quiet --stats utm.json || fail "status $? for f64"
grep -q '"euler_characteristic": *2' utm.json && grep -q '"non_manifold_edges": *0' utm.json || fail "the ball at 5e6 is broken"

[ -z "$("$bin/isosurf-mc" sphere.nrrd --isovalue 0.5 -o ball.stl 2>&1 >/dev/null | grep normals)" ] || fail "nobody asked STL for normals"

for wrong in "--isovalue nan -o a.ply" "--isovalue 1,,2 -o a.ply" "--isovalue ,0.5 -o a.ply" "--isovalue 0.5, -o a.ply" "--isovalue 1 -o a.xyz" "-o a.ply" "--isovalue 1 --type f64 -o a.stl"; do
  # shellcheck disable=SC2086
  "$bin/isosurf-mc" sphere.nrrd $wrong 2>err
  [ $? -eq 2 ] || fail "$wrong must end with 2"
  [ "$(wc -l <err)" -eq 1 ] || fail "one line expected for $wrong: $(cat err)"
done
"$bin/isosurf-mc" sphere.nrrd --isovalue 7 -o none.ply || fail "an empty surface is a file too"
exit $failed
