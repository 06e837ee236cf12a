#!/usr/bin/python3
"""Rows of a table from what the tools wrote: PICTURE.error.json of img-compare, and PICTURE.json, the stats record beside it."""

import json
import statistics
import sys

print("picture,samples,seconds,rmse_byte")
for path in sys.argv[1:]:
    picture = path.removesuffix(".error.json")
    with open(path) as file:
        error = json.load(file)["all"]["rmse_byte"]
    with open(picture + ".json") as file:
        stats = json.load(file)
    seconds = statistics.median(stats["time_s"]["phases"]["render"])
    print(f"{picture.rsplit('/', 1)[-1]},{stats['counts']['samples']},{seconds:.4g},{error:.4g}")
