# Rules of the comparison of all renderers (renderers.yaml).

import pareto

ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md"]
if PICTURES:
    ENDS += [f"{RESULTS}/{name}.png" for name in ("error-time", "error-memory", "pictures")]
TOOLS = [f"{BIN}/{tool}" for tool in ("vol-raycast", "vol-dwt", "vol-index", "wavelet-raycast", "vol-fft", "fvr-slice", "curv-tricubic",
                                      "isosurf-ray", "isosurf-mc", "vol-convert", "img-compare")]
TOOLS += [str(tool) for tool in Path(BIN).glob("fvr-slice-gpu")]  # where it can be built
CODE = [f"pipelines/{name}.py" for name in ("renderers", "blobs", "pareto", "convergence", "fourier_truth")]
HERE = [d for d in DATASETS if d in SWEEP.get("only", list(DATASETS))]
BLOBS = {name: entry["edge"] for name, entry in SWEEP["datasets"].items() if "edge" in entry}

ruleorder: blobs > dataset
ruleorder: blobs > grid

rule blobs:
    input: "pipelines/blobs.py", "pipelines/isosurface.py"
    output: **{kind: f"{OUT}/volumes/{{dataset}}{end}" for kind, end in (("volume", ".nrrd"), ("dense", "-dense.nrrd"), ("grid", ".vts"))}
    wildcard_constraints: dataset="|".join(BLOBS)
    params: edge=lambda w: BLOBS[w.dataset]
    shell: "{PYTHON} -B pipelines/blobs.py --edge {params.edge} --volume {output.volume} --dense {output.dense} --grid {output.grid}"

# The samples of a volume as a curvilinear grid.
rule grid:
    input: "pipelines/blobs.py", volume=f"{OUT}/volumes/{{dataset}}.nrrd"
    output: f"{OUT}/volumes/{{dataset}}.vts"
    shell: "{PYTHON} -B pipelines/blobs.py --volume {input.volume} --grid {output}"

def needs_grid(dataset, picture):
    return any("{grid}" in family["draw"] and dataset in family.get("only", [dataset]) for _, family in pareto.families(SWEEP["pictures"][picture]))

# Every setting once, for its error.
rule accuracy:
    input:
        CODE, TOOLS, volume=f"{OUT}/volumes/{{dataset}}.nrrd",
        grid=lambda w: [f"{OUT}/volumes/{w.dataset}.vts"] if needs_grid(w.dataset, w.picture) else []
    output: f"{OUT}/accuracy/{{dataset}}/{{picture}}.json"
    params: asked=lambda w: [SWEEP["datasets"][w.dataset], SWEEP["pictures"][w.picture], SWEEP["size"], SWEEP["targets"], SWEEP["limit_s"]]
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/renderers.py {SETTINGS} {wildcards.dataset} {wildcards.picture} --bin {BIN} -o {output}"

rule times:
    input: "pipelines/renderers_times.py", rows=f"{OUT}/accuracy/{{dataset}}/{{picture}}.json"
    output: f"{OUT}/times/{{dataset}}/{{picture}}.json"
    params: asked=lambda w: [SWEEP["rounds"], SWEEP["repeats"], SWEEP["near"], SWEEP["targets"], SWEEP["pictures"][w.picture].get("targets")]
    threads: ALL_CORES
    shell:
        "{PYTHON} -B pipelines/renderers_times.py {SETTINGS} {wildcards.dataset} {wildcards.picture} {input.rows} --bin {BIN} -o {output}"

FOUND = expand(f"{OUT}/accuracy/{{dataset}}/{{picture}}.json", dataset=HERE, picture=list(SWEEP["pictures"]))
TIMED = expand(f"{OUT}/times/{{dataset}}/{{picture}}.json", picture=list(SWEEP["pictures"]),
               dataset=[d for d in HERE if not SWEEP["datasets"][d].get("check")])

rule table:
    input: "pipelines/renderers_table.py", SETTINGS, FOUND, TIMED
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    shell: "{PYTHON} -B pipelines/renderers_table.py {SETTINGS} --csv {output.csv} --markdown {output.md}"

rule plot:
    input: "pipelines/renderers_plot.py", SETTINGS, FOUND, TIMED, f"{RESULTS}/table.csv"
    threads: ALL_CORES
    output: f"{RESULTS}/error-time.png", f"{RESULTS}/error-memory.png", f"{RESULTS}/pictures.png"
    shell: "{PYTHON} -B pipelines/renderers_plot.py {SETTINGS} --bin {BIN} -o {RESULTS}"
