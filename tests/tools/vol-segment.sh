#!/usr/bin/env bash
# vol-segment from outside: labels against the truth, codebooks, features, threads, refusals.
#   vol-segment.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"

"$bin/vol-phantom" texture --dims 64x60x72 --spacing 0.5,1,0.75 -o texture.nrrd --labels-output truth.nrrd --quiet || exit 2
"$bin/vol-dwt" texture.nrrd -o texture.vdb --wavelet haar --levels 2 --quiet || exit 2
"$bin/vol-segment" texture.vdb -o labels.nrrd --truth truth.nrrd --codebook-output book.yaml --features-output features.nrrd \
  --stats stats.json --quiet || fail "status $?"
"$bin/vol-segment" texture.vdb -o - --threads 1 --quiet | "$bin/vol-compare" - labels.nrrd --quiet >/dev/null ||
  fail "one thread gives other labels"
"$bin/vol-segment" texture.vdb -o again.nrrd --codebook book.yaml --truth labels.nrrd --stats again.json --quiet || fail "status $? with --codebook"
"$bin/vol-convert" truth.nrrd -o wide.mha --type i16 --quiet || exit 2
"$bin/vol-segment" texture.vdb -o same.nrrd --codebook book.yaml --truth wide.mha --stats wide.json --quiet || fail "status $? for labels in i16"
"$bin/vol-segment" - -o hexagonal.nrrd --map-grid hexagonal --map 5x4 --normalise components --stats hexagonal.json --quiet <texture.vdb ||
  fail "status $? for a hexagonal map"
"$bin/vol-segment" texture.vdb -o means.mha --method k-means --classes 3 --no-approximation --components 2 --stats means.json --quiet ||
  fail "status $? for k-means"
"$bin/vol-segment" texture.vdb -o same.mha --method k-means --labels 3 --no-approximation --components 2 --quiet && cmp -s means.mha same.mha ||
  fail "--labels is not --classes any more"
"$bin/vol-dwt" texture.nrrd -o values.vdb --levels 0 --quiet || exit 2
"$bin/vol-segment" values.vdb -o values.nrrd --method k-means --window 0 --truth truth.nrrd --stats values.json --quiet ||
  fail "status $? for intensities"

python=/usr/bin/python3
[ -x $python ] || python=python3
$python - <<'PYTHON' || failed=1
import json
import struct
import sys

broken = []


def expect(promise, holds, *details):
    if not holds:
        broken.append(" ".join(map(str, (promise, *details))))


def header_and_data(name):
    data = open(name, "rb").read()
    end = data.index(b"\n\n") + 2
    return dict(line.split(": ", 1) for line in data[:end].decode().splitlines() if ": " in line), data[end:]


stats = {name: json.load(open(name + ".json")) for name in ("stats", "again", "wide", "hexagonal", "means", "values")}
found, values = (stats[name]["result"]["adjusted_rand_index"] for name in ("stats", "values"))
expect("textures are told apart where values are not", found > 0.5 > 0.1 > values, found, values)
expect("a codebook gives the labels it was made from", stats["again"]["result"]["adjusted_rand_index"] == 1)
expect("labels of any type are a truth", stats["wide"]["result"]["adjusted_rand_index"] == found)
counts = stats["stats"]["counts"]
expect("counts", counts["features"] == 15 and counts["voxels"] == 64 * 60 * 72, counts)
result = stats["stats"]["result"]
expect("every sample has a unit", sum(result["unit_hits"]) == counts["samples"], result)
expect("shares", 0.95 <= result["variance_share"] <= 1 and abs(sum(result["component_shares"]) - 1) < 1e-9, result)
expect("a label for each unit", len(result["unit_labels"]) == 24 and set(result["unit_labels"]) == {0, 1, 2, 3}, result)
expect("the map asked for", len(stats["hexagonal"]["result"]["unit_hits"]) == 20)
expect("components asked for", stats["means"]["counts"]["components"] == 2 and stats["means"]["counts"]["features"] == 14)
expect("a seed", stats["stats"]["seed"] == 1)

labels, voxels = header_and_data("labels.nrrd")
expect("labels are u8 of the volume's dims", labels["type"] == "uint8" and labels["sizes"] == "64 60 72", labels)
expect("labels have the volume's geometry", labels["space directions"].startswith("(0.5,0,0)"), labels)
frequency = [voxels.count(l) for l in range(4)]
expect("no label but four", sum(frequency) == len(voxels), frequency)
learnt = [sum(h for h, l in zip(result["unit_hits"], result["unit_labels"]) if l == label) for label in range(4)]
expect("labels are numbered by frequency among the samples", learnt == sorted(learnt, reverse=True), learnt)
features, numbers = header_and_data("features.nrrd")
expect("features come first", features["sizes"] == "15 64 60 72" and features["type"] == "float", features)
expect("features are as long as their header says", len(numbers) == 4 * 15 * 64 * 60 * 72)
first = struct.unpack_from("<15f", numbers)
expect("the mean near 1/2, amplitudes of a signal of deviation 1/8", 0.2 < first[0] < 0.8 and all(0 <= a < 0.3 for a in first[1:]), first)
for line in broken[:10]:
    print(line)
sys.exit(bool(broken))
PYTHON

# Ten per cent of the coefficients, as they are.
"$bin/vol-dwt" texture.nrrd -o sparse.vdb --wavelet haar --levels 2 --keep 27648 --quiet || exit 2
"$bin/vol-segment" sparse.vdb -o sparse.nrrd --quiet || fail "status $? for sparse coefficients"

# A constant volume has one label, and says so.
"$bin/vol-phantom" constant --dims 16 -o constant.nrrd && "$bin/vol-dwt" constant.nrrd -o constant.vdb --quiet || exit 2
"$bin/vol-segment" constant.vdb -o constant.nrrd 2>err || fail "status $? for a constant volume"
grep -q "found 1 of 4 labels" err || fail "nothing said of a constant volume: $(cat err)"

sed 's/levels: 2/levels: 3/' book.yaml >other.yaml
head -c 300 book.yaml >cut.yaml
refused "$bin/vol-segment" texture.nrrd -o a.nrrd
refused "$bin/vol-segment" texture.vdb -o a.nrrd --classes 25
refused "$bin/vol-segment" texture.vdb -o a.nrrd --classes 0
refused "$bin/vol-segment" texture.vdb -o a.nrrd --map 0x3
refused_for "at most 4096" "$bin/vol-segment" texture.vdb -o a.nrrd --map 65x64
refused_for "at most 4096" "$bin/vol-segment" texture.vdb -o a.nrrd --map 70000x70000
refused "$bin/vol-segment" texture.vdb -o a.nrrd --share 0
refused "$bin/vol-segment" texture.vdb -o a.nrrd --codebook other.yaml
refused "$bin/vol-segment" texture.vdb -o a.nrrd --codebook cut.yaml
refused "$bin/vol-segment" texture.vdb -o a.nrrd --codebook book.yaml --classes 3
refused_for "texture.nrrd: labels are whole numbers" "$bin/vol-segment" texture.vdb -o a.nrrd --truth texture.nrrd
refused_for "same dims" "$bin/vol-segment" texture.vdb -o a.nrrd --truth constant.nrrd
refused "$bin/vol-segment" texture.vdb -o a.nrrd --features-output a.txt
refused "$bin/vol-segment" values.vdb -o a.nrrd --no-approximation
[ ! -e a.nrrd ] || fail "labels were written after all"
exit $failed
