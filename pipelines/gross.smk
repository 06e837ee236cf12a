# Rules of rendering wavelet coefficients (gross.yaml): one table a question, each with its own runs.

ENDS += [f"{RESULTS}/cost.{kind}" for kind in ("csv", "md", "png", "svg")]
GROSS_DATASETS = [d for d in DATASETS if d in SWEEP.get("only", list(SWEEP["datasets"]))]
if not GROSS_DATASETS:
    raise WorkflowError("gross: no data set at hand; PRECIS_DATA is the folder of configs/data.yaml's files")

rule cost:
    input:
        "pipelines/gross.py", SETTINGS, f"{OUT}/volumes/{{dataset}}.nrrd",
        [f"{BIN}/{tool}" for tool in ("vol-dwt", "vol-raycast", "wavelet-raycast", "img-compare")]
    output: f"{OUT}/cost/{{dataset}}.json"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/gross.py {SETTINGS} {wildcards.dataset} --bin {BIN} -o {output}"

rule cost_table:
    input: "pipelines/gross_table.py", "pipelines/gross.py", SETTINGS, found=expand(f"{OUT}/cost/{{dataset}}.json", dataset=GROSS_DATASETS)
    output: [f"{RESULTS}/cost.{kind}" for kind in ("csv", "md", "png", "svg")]
    shell: "{PYTHON} -B pipelines/gross_table.py {SETTINGS} {input.found} -o {RESULTS}"
