# Rules of the sweep of fitted transfer curves (transfer.yaml).

TRANSFER_DATASETS = [d for d in DATASETS if d in SWEEP.get("only", list(SWEEP["datasets"]))]
ENDS += [f"{RESULTS}/{name}" for name in ("table.csv", "cost.csv", "table.md", "curves.png", "residual.png", "pictures.png", "cost.png",
                                          "curves.svg", "residual.svg", "cost.svg", "pairs/pairs.json")]

rule fitted:
    input:
        "pipelines/transfer.py", [f"{BIN}/{tool}" for tool in ("tf-fit", "vol-fft", "fvr-slice", "vol-raycast", "img-compare")],
        volume=f"{OUT}/volumes/{{dataset}}.nrrd"
    output: f"{OUT}/fitted/{{dataset}}.json"
    params: asked=lambda w: [SWEEP["datasets"][w.dataset], *(SWEEP[k] for k in ("size", "weight", "points", "drawn", "cost", "frames", "filter", "raycast"))]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/transfer.py {SETTINGS} {wildcards.dataset} --bin {BIN} -o {output}"

rule table:
    input:
        "pipelines/transfer_table.py", "pipelines/transfer.py", SETTINGS,
        found=expand(f"{OUT}/fitted/{{dataset}}.json", dataset=TRANSFER_DATASETS)
    output: ENDS
    shell: "{PYTHON} -B pipelines/transfer_table.py {SETTINGS} -o {RESULTS} {input.found}"
