#!/usr/bin/env bash
# Peak memory of vol-raycast on a volume of 512^3 bytes, in volumes: 1.3 for uniform casting, 0.5 / r^3 more with an index that is
# built for the scene at reduction r, slab by slab.
#   raycast-memory.sh BIN
source "$(dirname "${BASH_SOURCE[0]}")/common.sh" "$1"
if grep -qa __asan_init "$bin/vol-raycast"; then
  echo "skipped: the sanitizers' shadow memory counts too"
  exit 77
fi

# Noise: no box of it is left out of the index's transforms.
/usr/bin/python3 -c 'import random, sys; sys.stdout.buffer.write(random.Random(5).randbytes(2**20) * 128)' >noise.raw || exit 2
cast() {  # least and largest number of volumes, options
  local least=$1 most=$2
  shift 2
  "$bin/vol-raycast" noise.raw --raw-dims 512x512x512 --raw-type u8 -o picture.exr --size 512x512 --step 4v --quiet --stats stats.json "$@" ||
    fail "status $? with $*"
  /usr/bin/python3 -c '
import json, sys
peak, least, most = json.load(open("stats.json"))["peak_rss_bytes"] / 2**27, *map(float, sys.argv[1:3])
print(f"{peak:.3f} volumes of {most:.3f}")
sys.exit(not least < peak <= most)' "$least" "$most" || fail "memory with $*"
}
cast 1 1.3
cast 1 1.3 --layout blocks
grep -q '"layout": "blocks"' stats.json || fail "drawn from rows, not from blocks"
cast 1.5 1.8 --index auto --index-reduction 1
cast 1 1.3625 --index auto --index-reduction 2
cast 1 1.3078125 --index auto --index-reduction 4
exit $failed
