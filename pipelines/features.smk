# Rules of the segmentation in wavelet space (features.yaml).

ENDS += [f"{RESULTS}/{name}" for name in ("table.csv", "table.md", "agreement.png", "agreement.svg", "labels.png", "splats.png")]
FEATURES_CODE = ["pipelines/features.py", SETTINGS]

rule agreement:
    input: FEATURES_CODE, [f"{BIN}/{tool}" for tool in ("vol-phantom", "vol-dwt", "vol-segment")]
    output: f"{OUT}/agreement.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/features.py {SETTINGS} agreement --bin {BIN} -o {output}"

rule table:
    input: "pipelines/features_table.py", "pipelines/features.py", found=f"{OUT}/agreement.json"
    output: [f"{RESULTS}/{name}" for name in ("table.csv", "table.md", "agreement.png", "agreement.svg")]
    shell: "{PYTHON} -B pipelines/features_table.py {SETTINGS} {input.found} -o {RESULTS}"

rule labels:
    input:
        FEATURES_CODE, "configs/transfer/labels.yaml", "configs/transfer/label-tints.yaml",
        [f"{BIN}/{tool}" for tool in ("vol-dwt", "vol-segment", "vol-raycast")],
        [volume(d) for d in DATASETS]
    output: f"{RESULTS}/labels.png"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/features.py {SETTINGS} labels --bin {BIN} -o {output}"

rule splats:
    input: FEATURES_CODE, "configs/transfer/labels.yaml", [f"{BIN}/{tool}" for tool in ("vol-phantom", "vol-dwt", "vol-segment", "vol-raycast")]
    output: f"{RESULTS}/splats.png"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/features.py {SETTINGS} splats --bin {BIN} -o {output}"
