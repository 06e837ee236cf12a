# Rules of rendering wavelet coefficients (gross.yaml): one table a question, each with its own runs.

GROSS_DATASETS = [d for d in DATASETS if d in SWEEP.get("only", list(SWEEP["datasets"]))]
if GROSS_DATASETS:  # in full a measured volume alone: its coefficients are those that a user would keep
    ENDS += [f"{RESULTS}/cost.{kind}" for kind in ("csv", "md", "png", "svg")]

rule cost_truth:
    input:
        "pipelines/gross.py", SETTINGS, f"{OUT}/volumes/{{dataset}}.nrrd",
        [f"{BIN}/{tool}" for tool in ("vol-dwt", "vol-raycast", "wavelet-raycast", "img-compare")]
    output: directory(f"{OUT}/cost/{{dataset}}.truth")
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/gross.py {SETTINGS} truth {wildcards.dataset} --bin {BIN} -o {output}"

rule cost:
    input:
        "pipelines/gross.py", SETTINGS, f"{OUT}/cost/{{dataset}}.truth",
        [f"{BIN}/{tool}" for tool in ("vol-dwt", "vol-raycast", "wavelet-raycast", "img-compare")]
    output: f"{OUT}/cost/{{dataset}}.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/gross.py {SETTINGS} cost {wildcards.dataset} --bin {BIN} -o {output}"

rule cost_table:
    input: "pipelines/gross_table.py", "pipelines/gross.py", SETTINGS, found=expand(f"{OUT}/cost/{{dataset}}.json", dataset=GROSS_DATASETS)
    output: [f"{RESULTS}/cost.{kind}" for kind in ("csv", "md", "png", "svg")]
    shell: "{PYTHON} -B pipelines/gross_table.py {SETTINGS} {input.found} -o {RESULTS}"
