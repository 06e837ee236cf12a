#!/usr/bin/env bash
# A sweep with a shell alone: what wavelet and error bound of an index cost and bring. Pictures that are there stay, so that a
# run that was stopped goes on.
#
#   pipelines/examples/sweep.sh [FOLDER]            sweep.csv in FOLDER/64-256x256 (out/examples/64-256x256)
#   BIN=..., DIMS=64, SIZE=256x256, WAVELETS="haar daubechies-4", EPSILONS="0.5 1 2" change what is swept
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin=${BIN:-$here/../../build/release/bin}
scene=$here/../../configs/scenes/protein.yaml
size=${SIZE:-256x256}
dims=${DIMS:-64}
out=${1:-$here/../../out/examples}/$dims-$size  # what another volume or size was drawn with lies in another folder
mkdir -p "$out"

# The tools write a file beside its place and rename it when it is whole: what is there is right.
volume=$out/sweep-volume.nrrd
[ -e "$volume" ] || "$bin/vol-phantom" protein --dims "$dims" --type u8 -o "$volume" --quiet
truth=$out/sweep-truth.exr
[ -e "$truth" ] || "$bin/vol-raycast" "$volume" -o "$truth" --scene "$scene" --size "$size" --quadrature reference --quiet

errors=()
for wavelet in ${WAVELETS:-haar daubechies-4}; do
  coefficients=$out/$wavelet.vdb
  [ -e "$coefficients" ] || "$bin/vol-dwt" "$volume" -o "$coefficients" --wavelet "$wavelet" --quiet
  for epsilon in ${EPSILONS:-0.5 1 2}; do
    picture=$out/$wavelet-$epsilon
    if [ ! -e "$picture.error.json" ]; then
      "$bin/vol-index" "$coefficients" -o "$picture.nrrd" --epsilon "$epsilon" --quiet
      "$bin/vol-raycast" "$volume" -o "$picture.exr" --scene "$scene" --size "$size" --index "$picture.nrrd" --repeat 3 \
        --stats "$picture.json" --quiet
      "$bin/img-compare" "$picture.exr" "$truth" --json >"$picture.new"
      mv "$picture.new" "$picture.error.json"
    fi
    errors+=("$picture.error.json")
  done
done
python3 "$here/rows.py" "${errors[@]}" | tee "$out/sweep.csv"
