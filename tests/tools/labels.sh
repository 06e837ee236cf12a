#!/usr/bin/env bash
# Labels in pictures and meshes from outside: vol-raycast --labels and --splat, isosurf-mc --label.
#   labels.sh BIN
looks=$(realpath "$(dirname "${BASH_SOURCE[0]}")/../../configs/transfer/labels.yaml")
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

"$bin/vol-phantom" texture --dims 24x20x28 --spacing 0.5,1,0.75 -o values.nrrd --labels-output labels.nrrd --quiet || exit 2
cast() { # OUTPUT OPTION...: a small picture
  "$bin/vol-raycast" values.nrrd -o "$1" --size 40x40 --view 30,20 --quiet "${@:2}"
}
differ() { # A B: the pictures are not the same by far
  "$bin/img-compare" "$1" "$2" --fail-above max=0.02 >/dev/null 2>&1
  [ $? -eq 1 ]
}
cast alone.exr --labels labels.nrrd --label-transfer "$looks" --stats alone.json || fail "status $? for --labels"
grep -q '"caster": *"plain"' alone.json || fail "the stats must tell the plain caster"
grep -q '"label_looks"' alone.exr || fail "the picture does not say how labels look"
cast one.exr --labels labels.nrrd --label-transfer "$looks" --threads 1 && cmp -s alone.exr one.exr || fail "one thread gives another picture"
cast nearest.exr --labels labels.nrrd --label-transfer "$looks" --label-membership nearest || fail "status $? for nearest"
cast multiply.exr --labels labels.nrrd --label-transfer "$looks" --label-use multiply || fail "status $? for multiply"
cast default.exr --labels labels.nrrd || fail "status $? without --label-transfer"
for other in nearest multiply default; do
  differ alone.exr $other.exr || fail "$other makes no difference"
done
# A white opaque label for every voxel, times the transfer function, leaves the value's own picture.
printf 'labels: [[0,1,1,1,1], [1,1,1,1,1], [2,1,1,1,1], [3,1,1,1,1]]\n' >white.yaml
cast white.exr --labels labels.nrrd --label-transfer white.yaml --label-use multiply && cast own.exr --algorithm plain || exit 2
"$bin/img-compare" white.exr own.exr --fail-above max=1e-6 >/dev/null || fail "white labels: $("$bin/img-compare" white.exr own.exr)"

# Splats: one voxel is a ball, larger with a lower threshold; what is splatted is no medium.
cast splats.exr --labels labels.nrrd --label-transfer "$looks" --splat 1,2 --splat-support 1.2v --stats splats.json || fail "status $? for --splat"
count=$(grep -o '"splats": *[0-9]*' splats.json | grep -o '[0-9]*$')
[ "${count:-0}" -gt 1000 ] || fail "two regions have ${count:-no} splats"
cast all.exr --labels labels.nrrd --splat all --splat-support 0.4 --splat-threshold 0.2 || fail "status $? for --splat all"
differ alone.exr splats.exr || fail "--splat makes no difference"
hits() {
  cast ball.exr --labels labels.nrrd --splat 3 --splat-support 0.4 --splat-threshold "$1" --stats ball.json || fail "status $? for threshold $1"
  grep -o '"surface_hits": *[0-9]*' ball.json | grep -o '[0-9]*$'
}
[ "$(hits 0.1)" -gt "$(hits 0.5)" ] && [ "$(hits 0.5)" -gt "$(hits 0.95)" ] || fail "a lower threshold must show more"

# Meshes: one file with a property, or a file a label; together they are the labels' voxels and half of what is between.
"$bin/isosurf-mc" labels.nrrd --label all --close -o regions.ply --stats regions.json --quiet || fail "status $? for regions"
"$bin/isosurf-mc" labels.nrrd --labels all --close -o same.ply --quiet && cmp -s regions.ply same.ply || fail "--labels is not --label any more"
grep -aq "property double label" regions.ply || fail "the mesh does not tell labels apart"
"$bin/isosurf-mc" labels.nrrd --label all --close -o 'region-{label}.obj' --quiet --stats each.json || fail "status $? for a file a label"
for label in 0 1 2 3; do
  grep -q '^f ' region-$label.obj || fail "label $label has no triangles"
done
/usr/bin/python3 - <<'END' || fail "regions"
import json
surfaces, each = (json.load(open(f"{name}.json")) for name in ("regions", "each"))
assert [s["label"] for s in surfaces["result"]["surfaces"]] == [0, 1, 2, 3], surfaces["result"]
assert surfaces["counts"]["triangles"] == each["counts"]["triangles"] and len(each["outputs"]) == 4
# Disjoint regions that fill the box, closed: their volumes are at most the box, and lack a border of half a voxel's wedges.
box, volume = 23 * 0.5 * 19 * 1 * 27 * 0.75, sum(s["volume"] for s in surfaces["result"]["surfaces"])
assert 0.9 * box < volume < 1.0001 * box, (volume, box)
END
"$bin/isosurf-mc" labels.nrrd --isovalue 0.5,1.5 -o values.obj --quiet && grep -q '^g isovalue_0.5' values.obj || fail "isovalues keep their groups"

refused "$bin/vol-raycast" values.nrrd -o a.exr --labels values.nrrd
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --model mip
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --quadrature preintegrated
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --max-error 0.01
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --index auto
refused "$bin/vol-raycast" values.nrrd -o a.exr --splat 1
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --splat 300
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --splat 0
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --splat 1 --splat-threshold 0
refused "$bin/vol-raycast" values.nrrd -o a.exr --labels labels.nrrd --splat 1 --splat-support 100
refused "$bin/isosurf-mc" values.nrrd --label all -o a.ply
refused "$bin/isosurf-mc" labels.nrrd --label 1,x -o a.ply
refused_for once "$bin/isosurf-mc" labels.nrrd --label 1,2,1 -o a.ply
refused "$bin/isosurf-mc" labels.nrrd --label 1 --isovalue 0.5 -o a.ply
refused "$bin/isosurf-mc" labels.nrrd -o a.ply
refused "$bin/isosurf-mc" labels.nrrd --isovalue 0.5 -o 'a-{label}.ply'
"$bin/vol-convert" labels.nrrd --pad 1 -o larger.nrrd --quiet || exit 2
refused_for "the volume is" "$bin/vol-raycast" values.nrrd -o a.exr --labels larger.nrrd
[ ! -e a.exr ] && [ ! -e a.ply ] || fail "something was written after all"
exit $failed
