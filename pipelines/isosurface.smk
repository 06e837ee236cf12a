# Rules of the comparison of isosurfaces (isosurface.yaml).

PICTURES = [f"{RESULTS}/{dataset}_{value}.png" for dataset in DATASETS for value in SWEEP["datasets"][dataset]["isovalues"]]
ENDS += [f"{RESULTS}/table.csv", f"{RESULTS}/table.md", *PICTURES]

ruleorder: noisy > dataset

rule noisy:
    input: "pipelines/isosurface.py"
    output: f"{OUT}/volumes/noisy.nrrd"
    params: edge=SWEEP["datasets"]["noisy"]["edge"]
    shell: "{PYTHON} -B pipelines/isosurface.py --noisy {params.edge} {output}"

rule picture:
    input: f"{BIN}/isosurf-ray", volume=f"{OUT}/volumes/{{dataset}}.nrrd"
    output: f"{RESULTS}/{{dataset}}_{{value}}.png"
    params: view=lambda w: SWEEP["datasets"][w.dataset]["picture"], size=SWEEP["size"]
    threads: ALL_CORES
    shell: "{BIN}/isosurf-ray {input.volume} -o {output} --isovalue {wildcards.value} --size {params.size} {params.view} --quiet"

rule table:
    input: "pipelines/isosurface.py", SETTINGS, f"{BIN}/isosurf-mc", [volume(d) for d in DATASETS]
    output: csv=f"{RESULTS}/table.csv", md=f"{RESULTS}/table.md"
    threads: ALL_CORES
    shell: "{PYTHON} -B pipelines/isosurface.py --settings {SETTINGS} --bin {BIN} --csv {output.csv} --markdown {output.md}"
